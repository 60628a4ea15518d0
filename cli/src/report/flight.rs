//! The page of a flight: its track, its motion, its attitude and its sensors' biases.

use std::collections::HashSet;

use hovernav::earth::{Geodetic, Local};
use hovernav::ekf::{Channel, Innovation, Solution, Verdict};
use hovernav::gps::Fix;
use hovernav::time::Time;

use super::innovations;
use super::page::{Page, Section, Table, TableRow, TimeAxis};
use super::series::{Abscissa, Figure, Role, Row, Series};
use super::{ErrorRow, ReferenceSample, Report};

const NED: [&str; 3] = ["North", "East", "Down"];
const ANGLES: [&str; 3] = ["Roll", "Pitch", "Yaw"];

/// The page of a report.
pub fn page<'a>(report: &Report<'a>) -> Page<'a> {
    let clock = Clock::of(report);
    let origin = report
        .solutions
        .first()
        .map(|solution| solution.position)
        .or_else(|| report.fixes.first().map(|fix| fix.position))
        .unwrap_or(Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 });
    let estimate = Motion::of_solutions(report.solutions, clock, &origin);
    let smoothed = Motion::of_solutions(report.smoothed, clock, &origin);
    let reference = Motion::of_reference(report.reference, clock, &origin);
    let flight = Flight {
        report,
        origin,
        estimate,
        smoothed,
        reference,
        fixes: Fixes::of(report.fixes, report.innovations, clock, &origin),
    };
    let mut sections = vec![
        flight.map(),
        flight.position(),
        flight.velocity(),
        flight.body_velocity(),
        flight.attitude(),
        flight.biases(),
        innovations::innovations(report.innovations, clock),
        innovations::test(report.innovations, clock),
    ];
    if !report.errors.is_empty() {
        sections.push(innovations::errors(report.errors, report.solutions, clock));
    }
    Page {
        title: report.title,
        headlines: report.headlines,
        warnings: report.warnings,
        facts: report.facts,
        table: error_table(report.error_table),
        sections,
        time: clock.axis(report),
    }
}

/// Seconds on the page. A log whose clock counts from far away, as GPS or Unix time does, is shown
/// from its own first second on, and the axis says so.
#[derive(Clone, Copy)]
pub struct Clock {
    zero: Time,
}

impl Clock {
    const FAR_S: f64 = 1e6;

    fn of(report: &Report<'_>) -> Self {
        const SECOND_NS: i64 = 1_000_000_000;
        let start = span(report).map_or(Time::ZERO, |(start, _)| start);
        let is_far = start.seconds().abs() >= Self::FAR_S;
        let whole_s = if is_far { start.nanoseconds().div_euclid(SECOND_NS) } else { 0 };
        Self { zero: Time::from_nanoseconds(whole_s.saturating_mul(SECOND_NS)) }
    }

    /// The page's second of a moment.
    pub fn seconds(self, time: Time) -> f64 {
        time - self.zero
    }

    fn axis(self, report: &Report<'_>) -> TimeAxis {
        let label = if self.zero == Time::ZERO {
            "Time, s".into()
        } else {
            format!("Time after {:.0} s, s", self.zero.seconds())
        };
        let (start, end) = span(report).unwrap_or((self.zero, self.zero));
        let outages = report.outages.iter().filter(|(_, duration_s)| duration_s.is_finite());
        TimeAxis {
            label,
            span: [self.seconds(start), self.seconds(end)],
            outages: outages
                .map(|&(start, duration_s)| [start, start + duration_s].map(|t| self.seconds(t)))
                .collect(),
        }
    }
}

/// First and last moment of solutions and fixes.
fn span(report: &Report<'_>) -> Option<(Time, Time)> {
    let solutions = report.solutions.iter().map(|solution| solution.time);
    let times = || solutions.clone().chain(report.fixes.iter().map(|fix| fix.time));
    Some((times().min()?, times().max()?))
}

/// Three components of a quantity, each a series.
type Columns = [Vec<f64>; 3];

fn columns<T>(items: &[T], components: impl Fn(&T) -> [f64; 3]) -> Columns {
    let mut columns = [(); 3].map(|()| Vec::with_capacity(items.len()));
    for item in items {
        for (column, value) in columns.iter_mut().zip(components(item)) {
            column.push(value);
        }
    }
    columns
}

/// What an estimate or a reference says of the vehicle, in the page's units; unknown is NaN.
struct Motion {
    time: Vec<f64>,
    position_m: Columns,
    velocity_mps: Columns,
    body_velocity_mps: Columns,
    attitude_deg: Columns,
}

impl Motion {
    fn of_solutions(solutions: &[Solution], clock: Clock, origin: &Geodetic) -> Self {
        let local = Local::at(origin);
        Self {
            time: solutions.iter().map(|s| clock.seconds(s.time)).collect(),
            position_m: columns(solutions, |s| local.displacement(origin, &s.position).to_array()),
            velocity_mps: columns(solutions, |s| s.velocity_mps.to_array()),
            body_velocity_mps: columns(solutions, |s| s.velocity_body_mps().to_array()),
            attitude_deg: columns(solutions, |s| s.body_to_ned.euler().to_degrees()),
        }
    }

    fn of_reference(samples: &[ReferenceSample], clock: Clock, origin: &Geodetic) -> Self {
        const UNKNOWN: [f64; 3] = [f64::NAN; 3];
        let local = Local::at(origin);
        Self {
            time: samples.iter().map(|s| clock.seconds(s.time)).collect(),
            position_m: columns(samples, |s| {
                s.position.map_or(UNKNOWN, |place| local.displacement(origin, &place).to_array())
            }),
            velocity_mps: columns(samples, |s| {
                s.velocity_mps.map_or(UNKNOWN, |velocity| velocity.to_array())
            }),
            body_velocity_mps: columns(samples, |s| {
                s.velocity_body_mps().map_or(UNKNOWN, |velocity| velocity.to_array())
            }),
            attitude_deg: columns(samples, |s| {
                s.attitude.map_or(UNKNOWN, |attitude| attitude.to_degrees())
            }),
        }
    }
}

/// The fixes in the page's units, and which of them the filter refused.
struct Fixes {
    time: Vec<f64>,
    position_m: Columns,
    velocity_mps: Columns,
    position_refused: Vec<bool>,
    velocity_refused: Vec<bool>,
}

impl Fixes {
    fn of(fixes: &[Fix], innovations: &[Innovation], clock: Clock, origin: &Geodetic) -> Self {
        use Channel::{PositionDown, PositionEast, PositionNorth};
        use Channel::{VelocityDown, VelocityEast, VelocityNorth};
        let refused = |channels: [Channel; 3]| -> Vec<bool> {
            let refused = innovations.iter().filter(|innovation| {
                innovation.verdict == Verdict::Rejected && channels.contains(&innovation.channel)
            });
            let times: HashSet<Time> = refused.map(|innovation| innovation.time).collect();
            fixes.iter().map(|fix| times.contains(&fix.time)).collect()
        };
        let local = Local::at(origin);
        Self {
            time: fixes.iter().map(|fix| clock.seconds(fix.time)).collect(),
            position_m: columns(fixes, |fix| local.displacement(origin, &fix.position).to_array()),
            velocity_mps: columns(fixes, |fix| {
                let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
                [north, east, fix.down_velocity_mps.unwrap_or(f64::NAN)]
            }),
            position_refused: refused([PositionNorth, PositionEast, PositionDown]),
            velocity_refused: refused([VelocityNorth, VelocityEast, VelocityDown]),
        }
    }
}

/// The dots of those fixes that were taken, and of those that were refused.
fn dots(row: Row, x: &[f64], y: &[f64], refused: &[bool]) -> Row {
    let those = |wanted: bool| {
        let points = x.iter().zip(y).zip(refused).filter(move |&(_, &refused)| refused == wanted);
        points.map(|((&x, &y), _)| (x, y))
    };
    row.with(Series::points(Role::Gps, those(false)))
        .with(Series::points(Role::GpsRejected, those(true)))
}

struct Flight<'r, 'a> {
    report: &'r Report<'a>,
    origin: Geodetic,
    estimate: Motion,
    smoothed: Motion,
    reference: Motion,
    fixes: Fixes,
}

impl Flight<'_, '_> {
    fn map(&self) -> Section {
        let track = |role, motion: &Motion| {
            let [north, east, _] = &motion.position_m;
            Series::track(role, &motion.time, [north, east])
        };
        let [north, east, _] = &self.estimate.position_m;
        let end = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
        let start = |values: &[f64]| values.first().copied().unwrap_or(f64::NAN);
        let [fix_north, fix_east, _] = &self.fixes.position_m;
        let row = dots(Row::new("North", "m"), fix_east, fix_north, &self.fixes.position_refused)
            .with(track(Role::Reference, &self.reference))
            .with(track(Role::Smoothed, &self.smoothed))
            .with(track(Role::Estimate, &self.estimate))
            .with(Series::points(Role::Start, [(start(east), start(north))].into_iter()))
            .with(Series::points(Role::End, [(end(east), end(north))].into_iter()));
        let rows = if row.series.is_empty() { Vec::new() } else { vec![row] };
        Section {
            anchor: "map",
            title: "Map",
            explanation: format!(
                "The flight from above, both axes to one scale, in metres from {}. GPS dots are \
                 the antenna's.",
                if rows.is_empty() { "its first point".into() } else { described(&self.origin) }
            ),
            figure: Figure { abscissa: Abscissa::EastM, rows },
        }
    }

    fn position(&self) -> Section {
        let sigma = columns(self.report.solutions, |s| s.position_sigma_m.to_array());
        let rows = self.rows(NED, "m", |motion| &motion.position_m, Some(&sigma));
        let fixes = self.fixes.position_m.iter();
        let rows = rows
            .zip(fixes)
            .map(|(row, fixes)| dots(row, &self.fixes.time, fixes, &self.fixes.position_refused));
        Section {
            anchor: "position",
            title: "Position",
            explanation: "Metres north, east and down from the map's first point, the shaded band \
                          three standard deviations (3σ) to either side. The down axis points down \
                          the page, so that climbing looks like climbing."
                .into(),
            figure: Figure::against_time(downwards(rows)),
        }
    }

    fn velocity(&self) -> Section {
        let sigma = columns(self.report.solutions, |s| s.velocity_sigma_mps.to_array());
        let rows = self.rows(NED, "m/s", |motion| &motion.velocity_mps, Some(&sigma));
        let fixes = self.fixes.velocity_mps.iter();
        let rows = rows
            .zip(fixes)
            .map(|(row, fixes)| dots(row, &self.fixes.time, fixes, &self.fixes.velocity_refused));
        Section {
            anchor: "velocity",
            title: "Velocity",
            explanation:
                "Speed over ground northwards, eastwards and downwards, with its 3σ band. \
                          Dots are the velocity that the receiver itself gives, where it gives one."
                    .into(),
            figure: Figure::against_time(downwards(rows)),
        }
    }

    fn body_velocity(&self) -> Section {
        let names = ["Forward u", "Right v", "Down w"];
        Section {
            anchor: "body-velocity",
            title: "Body velocity",
            explanation: "The same velocity seen from the cockpit: forward, to the right, and \
                          through the floor. This is what hover control and model identification \
                          work with."
                .into(),
            figure: Figure::against_time(self.rows(
                names,
                "m/s",
                |motion| &motion.body_velocity_mps,
                None,
            )),
        }
    }

    fn attitude(&self) -> Section {
        let sigma = columns(self.report.solutions, |s| s.attitude_sigma_rad.map(f64::to_degrees));
        let rows = self.rows(ANGLES, "°", |motion| &motion.attitude_deg, Some(&sigma));
        Section {
            anchor: "attitude",
            title: "Attitude",
            explanation: "Roll (right side down), pitch (nose up) and yaw (heading clockwise from \
                          true north), with 3σ bands. Yaw starts over at ±180°."
                .into(),
            figure: Figure::against_time(rows),
        }
    }

    fn biases(&self) -> Section {
        const AXES: [&str; 3] = ["x", "y", "z"];
        let solutions = self.report.solutions;
        let degrees = |rates: [f64; 3]| rates.map(f64::to_degrees);
        let row = |quantity: &str, unit, values: Columns, sigmas: Columns| -> Vec<Row> {
            let columns = AXES.iter().zip(values).zip(sigmas);
            columns
                .map(|((axis, value), sigma)| {
                    let (time, band) = (&self.estimate.time, triple(&sigma));
                    let line = Series::line(Role::Estimate, time, &value, Some(&band));
                    Row::new(&format!("{quantity} {axis}"), unit).with(line)
                })
                .collect()
        };
        let gyro = row(
            "Gyro",
            "°/s",
            columns(solutions, |s| degrees(s.gyro_bias_radps.to_array())),
            columns(solutions, |s| degrees(s.gyro_bias_sigma_radps.to_array())),
        );
        let accelerometer = row(
            "Accel",
            "m/s²",
            columns(solutions, |s| s.accel_bias_mps2.to_array()),
            columns(solutions, |s| s.accel_bias_sigma_mps2.to_array()),
        );
        Section {
            anchor: "biases",
            title: "Sensor biases",
            explanation: "What the filter has found the gyros and accelerometers to read at rest \
                          in excess, with 3σ bands. A band that narrows is a bias being learnt."
                .into(),
            figure: Figure::against_time(gyro.into_iter().chain(accelerometer)),
        }
    }

    /// One row per component: reference, smoothed and estimate, the estimate in its 3σ band.
    fn rows(
        &self,
        names: [&'static str; 3],
        unit: &'static str,
        quantity: impl Fn(&Motion) -> &Columns,
        sigma: Option<&Columns>,
    ) -> impl Iterator<Item = Row> {
        (0..3).map(move |component| {
            let name = names[component];
            let band = sigma.map(|columns| triple(&columns[component]));
            let line = |role, motion: &Motion, band: Option<&[f64]>| {
                let (x, y) = (&motion.time, &quantity(motion)[component]);
                if name == "Yaw" {
                    Series::heading(role, x, y, band)
                } else {
                    Series::line(role, x, y, band)
                }
            };
            Row::new(name, unit)
                .with(line(Role::Reference, &self.reference, None))
                .with(line(Role::Smoothed, &self.smoothed, None))
                .with(line(Role::Estimate, &self.estimate, band.as_deref()))
        })
    }
}

/// Three sigma of one.
fn triple(sigma: &[f64]) -> Vec<f64> {
    sigma.iter().map(|sigma| 3.0 * sigma).collect()
}

/// With the axes of what is measured downwards turned over.
fn downwards(rows: impl Iterator<Item = Row>) -> impl Iterator<Item = Row> {
    rows.enumerate().map(|(component, row)| Row { reversed: component == 2, ..row })
}

/// The point that the page's metres count from.
fn described(origin: &Geodetic) -> String {
    format!(
        "its first point ({:.6}°, {:.6}°, {:.1} m above the ellipsoid)",
        origin.latitude_deg(),
        origin.longitude_deg(),
        origin.height_m
    )
}

fn error_table(rows: &[ErrorRow]) -> Option<Table> {
    let row = |row: &ErrorRow| TableRow {
        name: format!("{}, {}", row.quantity, row.unit),
        numbers: [row.rmse, row.median, row.p95, row.max].map(three_digits).into(),
    };
    (!rows.is_empty()).then(|| Table {
        caption: "Error against the reference: root mean square, then median, 95th percentile and \
                  largest of its size",
        heads: &["", "RMSE", "Median", "95 %", "Max"],
        rows: rows.iter().map(row).collect(),
    })
}

/// A number to three digits, as a person would write it; a dash where it is unknown.
fn three_digits(value: f64) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    let whole_digits = value.abs().max(1e-3).log10().floor();
    format!("{value:.*}", (2.0 - whole_digits).clamp(0.0, 4.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_numbers_have_three_digits() {
        let written = [0.0, 0.012_345, 1.2345, 12.345, 12_345.6, f64::NAN].map(three_digits);
        assert_eq!(written, ["0.0000", "0.0123", "1.23", "12.3", "12346", "–"]);
    }

    #[test]
    fn a_clock_that_counts_from_far_away_is_shown_from_the_first_second() {
        let start = Time::from_nanoseconds(1_400_000_000_250_000_000);
        let fixes = [0.0, 9.0].map(|offset_s| {
            Fix::at(start + offset_s, Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap())
        });
        let report = Report { fixes: &fixes, outages: &[(start + 2.0, 3.0)], ..Report::default() };
        let axis = Clock::of(&report).axis(&report);
        assert_eq!(axis.label, "Time after 1400000000 s, s");
        assert_eq!(axis.span, [0.25, 9.25]);
        assert_eq!(axis.outages, [[2.25, 5.25]]);
    }
}
