//! Flight and model over the test points.

use hovernav_dataset::Dataset;
use hovernav_sysid::helicopter::Identification;
use hovernav_sysid::methods::prediction_error::Run;
use hovernav_sysid::record::{STICKS, TestPoint};

use hovernav_pages::{Axis, Figure, Role, Row, Section, Series};

/// The runs over one test point.
pub struct PointRuns<'a> {
    point: &'a TestPoint,
    name: &'a str,
    runs: Vec<&'a Run>,
}

/// The runs of the fit of `found`, by test point.
pub fn runs_of(found: &Identification) -> Vec<PointRuns<'_>> {
    let points = found.fit_points();
    let by_experiment =
        found.fit().runs().chunk_by(|one, other| one.experiment == other.experiment);
    let points = points.iter().map(|&point| &found.test_points[point]);
    by_experiment
        .zip(points)
        .map(|(runs, point)| PointRuns {
            point,
            name: &runs[0].experiment,
            runs: runs.iter().collect(),
        })
        .collect()
}

impl PointRuns<'_> {
    /// The times of all samples, and `value` of each sample, with a gap between runs.
    fn line(&self, period_s: f64, value: impl Fn(&Run, usize) -> f64) -> (Vec<f64>, Vec<f64>) {
        let (mut times, mut values) = (Vec::new(), Vec::new());
        for run in &self.runs {
            let start_s = seconds(self.point) + run.first_sample as f64 * period_s;
            if !times.is_empty() {
                times.push(start_s - 0.5 * period_s);
                values.push(f64::NAN);
            }
            for sample in 0..run.measured.nrows() {
                times.push(start_s + sample as f64 * period_s);
                values.push(value(run, sample));
            }
        }
        (times, values)
    }

    /// Start and end, s.
    fn span(&self, period_s: f64) -> [f64; 2] {
        let last = self.runs.last().map_or(0, |run| run.first_sample + run.measured.nrows());
        [seconds(self.point), seconds(self.point) + last as f64 * period_s]
    }

    fn axis(&self, period_s: f64) -> Axis {
        Axis::linear(&time_label(self.point), "s").within(self.span(period_s))
    }
}

/// Start of a test point on the page, s. Large clock values are shown relative to the start's whole second.
fn seconds(point: &TestPoint) -> f64 {
    point.start.seconds() - zero(point)
}

fn zero(point: &TestPoint) -> f64 {
    let start_s = point.start.seconds();
    if start_s.abs() < 1e6 { 0.0 } else { start_s.floor() }
}

fn time_label(point: &TestPoint) -> String {
    match zero(point) {
        0.0 => "Time".into(),
        zero => format!("Time after {zero:.0} s"),
    }
}

/// Flight and model over each test point, with the sticks above.
pub fn histories<'a>(
    dataset: &'a Dataset,
    found: &'a Identification,
    runs: &'a [PointRuns<'a>],
) -> impl Iterator<Item = Figure> + 'a {
    let period_s = found.identified.period_s;
    runs.iter().map(move |runs| {
        let [from_s, to_s] = runs.span(period_s);
        let sticks = (0..STICKS.len()).filter(|&stick| {
            found.identified.structure.inputs.iter().any(|input| input == STICKS[stick])
                && runs.point.stick.is_none_or(|tested| tested == stick)
        });
        let sticks = sticks.map(|stick| {
            let offset_s = zero(runs.point);
            let moved =
                dataset.controls.iter().map(|(time, sticks)| (time.seconds(), sticks[stick]));
            let (times, values): (Vec<f64>, Vec<f64>) = moved
                .map(|(time_s, value)| (time_s - offset_s, value))
                .filter(|(time_s, _)| (from_s..=to_s).contains(time_s))
                .unzip();
            Row::new(STICKS[stick], "").with(Series::line(Role::Input, &times, &values, None))
        });
        let outputs = found.fit().channels().0.iter().enumerate().map(|(output, channel)| {
            let (times, flown) = runs.line(period_s, |run, sample| run.measured[(sample, output)]);
            let (_, modelled) = runs.line(period_s, |run, sample| run.model[(sample, output)]);
            Row::new(&channel.name, unit_of(&channel.name))
                .with(Series::line(Role::Flight, &times, &flown, None))
                .with(Series::line(Role::Model, &times, &modelled, None))
        });
        let rows: Vec<Row> = sticks.chain(outputs).collect();
        Figure::against(runs.axis(period_s), rows).captioned(runs.name)
    })
}

/// Flight minus model over each test point.
pub fn residuals(found: &Identification, runs: &[PointRuns<'_>]) -> Section {
    let period_s = found.identified.period_s;
    let section = Section::new(
        "residuals",
        "Residuals",
        "Flight minus model over the same runs. The shaded range is ±2σ of the residuals of a perfect \
         model with the identified noise. Residuals inside this range are not errors of the model.",
    );
    runs.iter().fold(section, |section, runs| {
        let rows = found.fit().channels().0.iter().enumerate().map(|(output, channel)| {
            let (times, left) = runs.line(period_s, |run, sample| {
                run.measured[(sample, output)] - run.model[(sample, output)]
            });
            let bound = vec![2.0 * channel.floor_rms(); times.len()];
            Row::new(&channel.name, unit_of(&channel.name))
                .with(Series::bound(&times, &bound).named("±2σ of noise alone"))
                .with(Series::line(Role::Residual, &times, &left, None))
        });
        let rows: Vec<Row> = rows.collect();
        section.with(Figure::against(runs.axis(period_s), rows).captioned(runs.name))
    })
}

/// The unit of a flight signal.
fn unit_of(signal: &str) -> &'static str {
    match signal {
        "u" | "v" | "w" => "m/s",
        "p" | "q" | "r" => "rad/s",
        _ => "rad",
    }
}
