//! The page of an identification: what flew, what the model says of it, and how far to trust it.

use hovernav_log::Dataset;
use hovernav_model::ModelError;
use hovernav_sysid::flight_response::StickResponse;
use hovernav_sysid::identify::Identification;
use hovernav_sysid::prediction_error::{Estimate, Fit, Run};
use hovernav_sysid::test_points::{STICKS, TestPoint};
use hovernav_sysid::vehicle::Pole;

use super::Held;
use super::summary::{is_estimated, status_name};
use crate::report::page::{Page, Section, Table, TableRow};
use crate::report::series::{Axis, Figure, Role, Row, Series};
use crate::report::{Fact, digits};

/// What the page of an identification shows.
pub struct Shown<'a> {
    pub title: &'a str,
    pub facts: &'a [Fact],
    pub headlines: &'a [Fact],
    pub warnings: &'a [String],
    pub dataset: &'a Dataset,
    pub found: &'a Identification,
    pub held: Held<'a>,
    pub responses: &'a [StickResponse],
}

/// The page.
///
/// # Errors
/// Where the poles do not settle.
pub fn page<'a>(shown: &Shown<'a>) -> Result<Page<'a>, ModelError> {
    let found = shown.found;
    let mut sections = vec![parameters(shown)];
    let (fit, points, title, told) = match &found.validation {
        Some(fit) => (
            fit,
            &found.validation_points,
            "Validation",
            "test points held back: the search never saw them",
        ),
        None => (
            &found.estimation,
            &found.estimation_points,
            "Fit",
            "the test points the parameters are from, as none could be held back",
        ),
    };
    let runs = runs_of(fit, found, points);
    let explanation = format!(
        "Over {told}. The model runs free for {:.1} s at a time from an initial state of its own, \
         with nothing but the sticks to go by; offsets are those of the test point.",
        fit.window_s()
    );
    let section = Section::new("histories", title, explanation);
    sections.push(histories(shown.dataset, found, fit, &runs).fold(section, Section::with));
    sections.push(residuals(found, fit, &runs));
    sections.push(responses(shown.responses));
    sections.push(poles(found, shown.held)?);
    sections.push(compared(shown));
    Ok(Page {
        title: shown.title,
        headlines: shown.headlines,
        warnings: shown.warnings,
        facts: shown.facts,
        table: Some(fits(found, shown.held.ok())),
        sections,
        time: None,
    })
}

/// The few numbers to see first: a fit never without the bounds behind it.
pub fn headlines(found: &Identification) -> Vec<Fact> {
    let fit = fit_of(found);
    let channels = fit.channels().0.iter();
    let fits = channels.map(|channel| format!("{} {:.0}", channel.name, channel.percent));
    let over = if found.validation.is_some() { "held-back flight" } else { "fitted flight" };
    let fits = fits.collect::<Vec<_>>().join(" · ");
    vec![
        Fact::new(&format!("fit, %, free runs of {:.1} s over {over}", fit.window_s()), fits),
        Fact::new("bounds of the parameters, 1σ", bounds_in_words(found)),
    ]
}

/// The fit to show of an identification: that over held-back test points where there is one.
pub fn fit_of(found: &Identification) -> &Fit {
    found.validation.as_ref().unwrap_or(&found.estimation)
}

/// The bounds without which a fit says nothing, in a few words.
pub fn bounds_in_words(found: &Identification) -> String {
    let identified = &found.identified;
    let parameters = identified.estimates.list.iter().take(identified.structure.parameters.len());
    let estimated = parameters.filter(|estimate| is_estimated(estimate));
    let mut bounds: Vec<(f64, &str)> =
        estimated.map(|estimate| (estimate.bound_percent(), &*estimate.name)).collect();
    bounds.sort_by(|one, other| one.0.total_cmp(&other.0));
    match (bounds.get(bounds.len() / 2), bounds.last()) {
        (Some((median, _)), Some((worst, name))) => {
            format!("median ±{median:.1} %, worst ±{worst:.1} % ({name})")
        }
        _ => "none: nothing was estimated".into(),
    }
}

/// Fits beside what noise alone would allow, with the parameters' bounds in the caption.
fn fits(found: &Identification, held: Option<&Identification>) -> Table {
    let fit = fit_of(found);
    let rows = fit.channels().0.iter().map(|channel| {
        let mut channels = held.into_iter().flat_map(|held| fit_of(held).channels().0);
        let other = channels.find(|other| other.name == channel.name);
        TableRow {
            name: channel.name.clone(),
            numbers: vec![
                format!("{:.1} %", channel.percent),
                format!("{:.1} %", channel.floor_percent),
                digits(channel.residual_rms),
                other.map_or_else(|| "–".into(), |other| format!("{:.1} %", other.percent)),
            ],
        }
    });
    Table {
        caption: format!(
            "Fit of free runs of {:.1} s, what a perfect model would reach in this noise, residual \
             (RMS), and the fit from held GPS velocity. Bounds of the parameters (1σ): {}",
            fit.window_s(),
            bounds_in_words(found)
        ),
        heads: ["", "Fit", "Noise floor", "Residual", "Held GPS"].map(Into::into).into(),
        rows: rows.collect(),
    }
}

fn parameters(shown: &Shown<'_>) -> Section {
    let identified = &shown.found.identified;
    let estimates = &identified.estimates;
    let count = identified.structure.parameters.len();
    let held = |name: &str| Some(shown.held.ok()?.identified.estimates.get(name)?.clone());
    let rows = estimates.list.iter().take(count).map(|estimate| {
        let mut numbers = vec![digits(estimate.value), estimate.unit.clone()];
        numbers.extend(if is_estimated(estimate) {
            [
                format!("±{}", digits(estimate.bound)),
                format!("{:.1} %", estimate.bound_percent()),
                format!("{:.1} %", estimate.insensitivity_percent()),
            ]
        } else {
            [status_name(estimate.status).to_owned(), "–".into(), "–".into()]
        });
        numbers.push(held(&estimate.name).map_or_else(|| "–".into(), |other| in_short(&other)));
        TableRow { name: estimate.name.clone(), numbers }
    });
    let heads =
        ["", "Value", "Unit", "Bound (1σ)", "Bound", "Insensitivity", "From held GPS velocity"];
    let table = Table {
        caption: "Continuous-time derivatives per full stick".into(),
        heads: heads.map(Into::into).into(),
        rows: rows.collect(),
    };
    let pairs = correlations(shown.found, WORTH_TELLING);
    let table_of_pairs = Table {
        caption: format!(
            "Correlations above {WORTH_TELLING} in size; beyond 0.9 the data cannot tell the two apart"
        ),
        heads: ["Pair", "Correlation"].map(Into::into).into(),
        rows: pairs
            .iter()
            .map(|(one, other, value)| TableRow {
                name: format!("{one}, {other}"),
                numbers: vec![format!("{value:.3}")],
            })
            .collect(),
    };
    let section = Section::new(
        "parameters",
        "Parameters",
        "What was found, how far chance alone may have moved it (Cramér–Rao, one sigma, widened for \
         correlated innovations), and how far it could move alone before the fit would notice \
         (insensitivity). Below the table what was left out of the model, and why.",
    )
    .with(table);
    let section = if pairs.is_empty() { section } else { section.with(table_of_pairs) };
    match identified.log.is_empty() {
        true => section.with(vec!["No parameter was dropped.".to_owned()]),
        false => section.with(identified.log.clone()),
    }
}

/// The strong correlations among the parameters; those of the noises are the filter's own affair.
pub fn correlations(found: &Identification, least: f64) -> Vec<(&str, &str, f64)> {
    let structure = &found.identified.structure;
    let mut pairs = found.identified.estimates.strong_correlations(least);
    pairs.retain(|(one, other, _)| {
        [one, other].iter().all(|name| structure.parameter(name).is_some())
    });
    pairs
}

/// Correlations smaller than this are not worth a line.
const WORTH_TELLING: f64 = 0.7;

fn in_short(estimate: &Estimate) -> String {
    if is_estimated(estimate) {
        format!("{} ±{}", digits(estimate.value), digits(estimate.bound))
    } else {
        format!("{} ({})", digits(estimate.value), status_name(estimate.status))
    }
}

/// The runs over one test point.
struct PointRuns<'a> {
    point: &'a TestPoint,
    name: &'a str,
    runs: Vec<&'a Run>,
}

/// The runs of a fit by test point; `points` are the test points that it went over.
fn runs_of<'a>(fit: &'a Fit, found: &'a Identification, points: &[usize]) -> Vec<PointRuns<'a>> {
    let by_experiment = fit.runs().chunk_by(|one, other| one.experiment == other.experiment);
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
    /// Times of the runs' samples and what `value` makes of each run's sample, a gap between runs.
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

    /// First and last second.
    fn span(&self, period_s: f64) -> [f64; 2] {
        let last = self.runs.last().map_or(0, |run| run.first_sample + run.measured.nrows());
        [seconds(self.point), seconds(self.point) + last as f64 * period_s]
    }

    fn axis(&self, period_s: f64) -> Axis {
        Axis::linear(&time_label(self.point), "s").within(self.span(period_s))
    }
}

/// Seconds of a test point's start on the page: within the day where the clock counts from far away.
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

/// Flight and model over each test point, the sticks above.
fn histories<'a>(
    dataset: &'a Dataset,
    found: &'a Identification,
    fit: &'a Fit,
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
        let outputs = fit.channels().0.iter().enumerate().map(|(output, channel)| {
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

fn residuals(found: &Identification, fit: &Fit, runs: &[PointRuns<'_>]) -> Section {
    let period_s = found.identified.period_s;
    let section = Section::new(
        "residuals",
        "Residuals",
        "Flight less model over the same runs. The shaded range is twice the size that the \
         identified noise alone would give a perfect model: what stays inside is not the model's.",
    );
    runs.iter().fold(section, |section, runs| {
        let rows = fit.channels().0.iter().enumerate().map(|(output, channel)| {
            let (times, left) = runs.line(period_s, |run, sample| {
                run.measured[(sample, output)] - run.model[(sample, output)]
            });
            // Both fits are of the same deviation, so the floor's residual follows from them.
            let floor = (100.0 - channel.floor_percent) / (100.0 - channel.percent);
            let bound = vec![2.0 * floor * channel.residual_rms; times.len()];
            Row::new(&channel.name, unit_of(&channel.name))
                .with(Series::bound(&times, &bound).named("±2σ of noise alone"))
                .with(Series::line(Role::Residual, &times, &left, None))
        });
        let rows: Vec<Row> = rows.collect();
        section.with(Figure::against(runs.axis(period_s), rows).captioned(runs.name))
    })
}

/// Below this, a response is not worth fitting: Tischler and Remple, section 7.5.1.
const GOOD_COHERENCE: f64 = 0.6;

fn responses(responses: &[StickResponse]) -> Section {
    let section = Section::new(
        "bode",
        "Frequency responses",
        "The same flight seen in frequency, to which the model was not fitted: amplification and \
         phase from stick to answer, all test points on the stick together, with twice their random \
         error. Where the coherence is below 0.6 noise and gusts outweigh the stick: believe neither.",
    );
    if responses.is_empty() {
        return section.with(vec!["No stick of this model has a test point.".to_owned()]);
    }
    responses.iter().fold(section, |section, response| {
        let StickResponse { stick, output, unit, frequencies_hz, .. } = response;
        let points = |values: Vec<f64>| frequencies_hz.clone().into_iter().zip(values);
        let part = |curve: &[(f64, f64)], pick: fn(&(f64, f64)) -> f64| {
            points(curve.iter().map(pick).collect())
        };
        let spread = |sign: f64| -> Vec<f64> {
            let each = response.flight.iter().zip(&response.random_error);
            each.map(|((size, _), error)| {
                size + 20.0 * (1.0 + sign * 2.0 * error).max(0.01).log10()
            })
            .collect()
        };
        let swing = |sign: f64| -> Vec<f64> {
            let each = response.flight.iter().zip(&response.random_error);
            each.map(|((_, phase), error)| {
                phase + sign * (2.0 * error).min(1.0).asin().to_degrees()
            })
            .collect()
        };
        let range = |low: Vec<f64>, high: Vec<f64>| {
            Series::range(Role::Bound, frequencies_hz, &low, &high).named("±2σ random error")
        };
        let ends = [frequencies_hz.first(), frequencies_hz.last()].map(|end| *end.unwrap_or(&1.0));
        let rows = [
            Row::new("Magnitude", "dB")
                .with(range(spread(-1.0), spread(1.0)))
                .with(Series::curve(Role::Flight, part(&response.flight, |point| point.0)))
                .with(Series::curve(Role::Model, part(&response.model, |point| point.0))),
            Row::new("Phase", "°")
                .with(range(swing(-1.0), swing(1.0)))
                .with(Series::curve(Role::Flight, part(&response.flight, |point| point.1)))
                .with(Series::curve(Role::Model, part(&response.model, |point| point.1))),
            Row { limits: Some([0.0, 1.05]), ..Row::new("Coherence", "") }
                .with(Series::curve(Role::Flight, points(response.coherence.clone())))
                .with(
                    Series::curve(Role::Limit, ends.map(|end| (end, GOOD_COHERENCE)))
                        .named("0.6: good enough"),
                ),
        ];
        let axis = Axis::logarithmic("Frequency", "Hz").within(ends);
        let figure = Figure::against(axis, rows);
        section.with(figure.captioned(format!("{stick} to {output}, {unit} per full stick")))
    })
}

fn poles(found: &Identification, held: Held<'_>) -> Result<Section, ModelError> {
    let poles = found.identified.poles()?;
    let others = match held {
        Ok(held) => held.identified.poles()?,
        Err(_) => Vec::new(),
    };
    let outlines = |poles: &[Pole]| -> Vec<(f64, f64)> {
        let gap = (f64::NAN, f64::NAN);
        let outlines = poles.iter().map(|pole| pole.region_95(61));
        outlines
            .flat_map(|outline| outline.into_iter().map(|at| (at.re, at.im)).chain([gap]))
            .collect()
    };
    let marks = |role, poles: &[Pole]| {
        Series::points(role, poles.iter().map(|pole| (pole.value.re, pole.value.im)))
    };
    let figure = |[left, right, up]: [f64; 3], caption: &str| {
        let row = Row { limits: Some([-up, up]), ..Row::new("Imaginary part", "1/s") }
            .with(
                Series::curve(Role::Limit, [(0.0, -10.0 * up), (0.0, 10.0 * up)])
                    .named("Border of stability"),
            )
            .with(
                Series::curve(Role::AlternativeRegion, outlines(&others)).named("its 95 % region"),
            )
            .with(marks(Role::AlternativePole, &others).named("From held GPS velocity"))
            .with(Series::curve(Role::Region, outlines(&poles)))
            .with(marks(Role::Pole, &poles).named("Pole"));
        let axis = Axis::plane("Real part", "1/s").within([left, right]);
        Figure::against(axis, [row]).captioned(caption)
    };
    let most = |part: fn(&Pole) -> f64| poles.iter().map(part).fold(0.0, f64::max);
    let (left, right, up) =
        (most(|pole| -pole.value.re), most(|pole| pole.value.re), most(|pole| pole.value.im));
    let size = left.max(right).max(up).max(0.1);
    let whole = [-left - 0.1 * size, right + 0.2 * size, up + 0.2 * size];
    let mut section = Section::new(
        "poles",
        "Poles",
        "The eigenvalues of the vehicle in continuous time: further left dies away faster, right of \
         the dashed line grows, off the real axis oscillates. Each with the region in which the \
         parameters' bounds leave it 95 times of 100; of a real pole that is a stretch of the axis.",
    )
    .with(figure(whole, "All"));
    if size > 5.0 && poles.len() > 1 {
        let near = [-1.5, 0.5, 0.6];
        section = section.with(figure(near, "Near the origin: the slow motion over ground"));
    }
    let rows = poles.iter().map(|Pole { value, covariance }| {
        let sigma = |axis: usize| digits(covariance[(axis, axis)].max(0.0).sqrt());
        let imaginary = if value.im == 0.0 {
            "0".into()
        } else {
            format!("{} ±{}", digits(value.im), sigma(1))
        };
        let size = value.norm();
        let damping = if size > 1e-9 { digits(-value.re / size) } else { "–".into() };
        TableRow {
            name: format!("{} ±{}", digits(value.re), sigma(0)),
            numbers: vec![imaginary, digits(size), damping],
        }
    });
    let heads = ["Real part ±1σ, 1/s", "Imaginary part ±1σ, 1/s", "Frequency, rad/s", "Damping"];
    Ok(section.with(Table {
        caption: "Poles, fastest decay first".into(),
        heads: heads.map(Into::into).into(),
        rows: rows.collect(),
    }))
}

/// The identification from held GPS velocity.
fn compared(shown: &Shown<'_>) -> Section {
    let section = Section::new(
        "held-gps",
        "The same from held GPS velocity",
        "What the estimator's velocity is worth: the same search on the same test points, fed with \
         the receiver's own velocity, each fix held until the next, as was done before. Its flight \
         curves are what it was given, so its fits count against those steps; its parameters stand \
         beside the others in the table above.",
    );
    let held = match shown.held {
        Ok(held) => held,
        Err(error) => return section.with(vec![format!("Nothing could be identified: {error}")]),
    };
    let other = fit_of(held);
    let points = match held.validation {
        Some(_) => &held.validation_points,
        None => &held.estimation_points,
    };
    let runs = runs_of(other, held, points);
    let mut section = section.with(side_by_side(shown.found, held));
    if !held.warnings.is_empty() {
        section = section.with(held.warnings.clone());
    }
    histories(shown.dataset, held, other, &runs).fold(section, Section::with)
}

/// Fits and noise floors of both, with what bounds both.
fn side_by_side(found: &Identification, held: &Identification) -> Table {
    let rows = fit_of(found).channels().0.iter().map(|channel| {
        let percent = |value: f64| format!("{value:.1} %");
        let mut numbers = vec![percent(channel.percent), percent(channel.floor_percent)];
        let other = fit_of(held).channels().0.iter().find(|other| other.name == channel.name);
        numbers.extend(match other {
            Some(other) => [percent(other.percent), percent(other.floor_percent)],
            None => ["–".into(), "–".into()],
        });
        TableRow { name: channel.name.clone(), numbers }
    });
    Table {
        caption: format!(
            "Bounds (1σ) from the estimator's velocity: {}; from held GPS velocity: {}",
            bounds_in_words(found),
            bounds_in_words(held)
        ),
        heads: ["", "Fit", "Noise floor", "Held GPS: fit", "Held GPS: noise floor"]
            .map(Into::into)
            .into(),
        rows: rows.collect(),
    }
}

/// The unit of a flight signal.
fn unit_of(signal: &str) -> &'static str {
    match signal {
        "u" | "v" | "w" => "m/s",
        "p" | "q" | "r" => "rad/s",
        _ => "rad",
    }
}
