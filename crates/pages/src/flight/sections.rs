//! The page of a flight: track, motion, attitude and sensor biases.

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav_dataset::statistics::quantile;

use super::data::FlightData;
use super::motion::{Clock, Columns, Fixes, Motion, columns, known};
use super::raw::Raw;
use super::{errors, innovations, sensors};
use crate::{Abscissa, Figure, Page, Role, Row, Section, Series};

const NED: [&str; 3] = ["North", "East", "Down"];
const ANGLES: [&str; 3] = ["Roll", "Pitch", "Yaw"];

/// The page of a flight.
pub fn page<'a>(data: &FlightData<'a>) -> Page<'a> {
    let clock = Clock::of(data);
    let solved = data.solutions.iter().map(|solution| solution.position);
    let origin = solved
        .chain(data.fixes.iter().map(|fix| fix.position))
        .find(Geodetic::is_navigable)
        .unwrap_or(Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 });
    let estimate = Motion::of_solutions(data.solutions, clock, &origin);
    let smoothed = Motion::of_solutions(data.smoothed, clock, &origin);
    let reference = Motion::of_reference(data.reference, clock, &origin);
    let onboard = Motion::of_onboard(data.onboard, clock, &origin);
    let raw = data.log.and_then(|log| Raw::of(log, data.notices, clock));
    let flight = Sections {
        clock,
        raw: raw.as_ref(),
        onboard,
        data,
        origin,
        estimate,
        smoothed,
        reference,
        fixes: Fixes::of(data.fixes, data.innovations, clock, &origin),
    };
    let mut sections = vec![
        flight.map(),
        flight.position(),
        flight.velocity(),
        flight.body_velocity(),
        flight.attitude(),
        flight.biases(),
        innovations::innovations(data.innovations, data.onboard, clock),
        innovations::test(data.innovations, clock),
    ];
    sections.extend(sensors::sections(data, raw.as_ref(), clock));
    sections.extend(data.score.map(|score| errors::section(score, clock)));
    Page {
        title: data.title,
        headlines: data.headlines,
        verdict: data.verdict.cloned(),
        warnings: data.warnings,
        facts: data.facts,
        table: data.score.map(|score| errors::table(score, clock)),
        sections,
        time: Some(clock.axis(data)),
    }
}

/// The points of accepted fixes, and of rejected ones.
fn dots(row: Row, x: &[f64], y: &[f64], rejected: &[bool]) -> Row {
    let those = |wanted: bool| {
        let points =
            x.iter().zip(y).zip(rejected).filter(move |&(_, &rejected)| rejected == wanted);
        points.map(|((&x, &y), _)| (x, y))
    };
    row.with(Series::points(Role::Gps, those(false)))
        .with(Series::points(Role::GpsRejected, those(true)))
}

struct Sections<'r, 'a> {
    data: &'r FlightData<'a>,
    raw: Option<&'r Raw>,
    clock: Clock,
    onboard: Motion,
    origin: Geodetic,
    estimate: Motion,
    smoothed: Motion,
    reference: Motion,
    fixes: Fixes,
}

impl Sections<'_, '_> {
    fn map(&self) -> Section {
        let track = |role, motion: &Motion| {
            let [north, east, _] = &motion.position_m;
            Series::track(role, &motion.time, [north, east])
        };
        let [onboard_north, onboard_east, _] = &self.onboard.position_m;
        let [onboard_time, onboard_north, onboard_east] =
            known([&self.onboard.time, onboard_north, onboard_east]);
        let [north, east, _] = &self.estimate.position_m;
        let end = |values: &[f64]| values.last().copied().unwrap_or(f64::NAN);
        let start = |values: &[f64]| values.first().copied().unwrap_or(f64::NAN);
        let [fix_north, fix_east, _] = &self.fixes.position_m;
        let row =
            dots(Row::new("North", "m"), fix_east, fix_north, &self.fixes.position_rejected[0])
                .with(track(Role::Reference, &self.reference))
                .with(Series::track(Role::Onboard, &onboard_time, [&onboard_north, &onboard_east]))
                .with(track(Role::Smoothed, &self.smoothed))
                .with(track(Role::Estimate, &self.estimate))
                .with(self.ellipses())
                .with(Series::points(Role::Start, [(start(east), start(north))].into_iter()))
                .with(Series::points(Role::End, [(end(east), end(north))].into_iter()));
        let rows = if row.series.is_empty() { Vec::new() } else { vec![row] };
        Section::new(
            "map",
            "Map",
            format!(
                "Track from above, with equal scales, in metres from {}. GPS dots are positions of \
                 the antenna.",
                if rows.is_empty() { "the first position".into() } else { described(&self.origin) }
            ),
        )
        .with(Figure::new(Abscissa::EastM, rows))
    }

    fn position(&self) -> Section {
        let sigma = columns(self.data.solutions, |s| s.position_sigma_m.to_array());
        let rows = self.rows(NED, "m", |motion| &motion.position_m, Some(&sigma));
        let fixes = self.fixes.position_m.iter().zip(&self.fixes.position_rejected);
        let rows = rows
            .zip(fixes)
            .map(|(row, (fixes, rejected))| dots(row, &self.fixes.time, fixes, rejected))
            .enumerate()
            .map(|(axis, row)| if axis == 2 { row.with(self.baro()) } else { row });
        Section::new(
            "position",
            "Position",
            "Position north, east and down, m, relative to the first point of the map, with \
                          a band of ±3σ (standard deviations). The down axis points downwards, so that \
                          a climb goes up.",
        )
        .with(Figure::against_time(downwards(rows)))
    }

    fn velocity(&self) -> Section {
        let sigma = columns(self.data.solutions, |s| s.velocity_sigma_mps.to_array());
        let rows = self.rows(NED, "m/s", |motion| &motion.velocity_mps, Some(&sigma));
        let fixes = self.fixes.velocity_mps.iter().zip(&self.fixes.velocity_rejected);
        let rows = rows
            .zip(fixes)
            .map(|(row, (fixes, rejected))| dots(row, &self.fixes.time, fixes, rejected));
        Section::new("velocity", "Velocity", "Velocity over ground north, east and down, with its 3σ band. \
                          Dots are the velocities that the receiver measured, if it reports velocity.").with(Figure::against_time(downwards(rows)))
    }

    fn body_velocity(&self) -> Section {
        let names = ["Forward u", "Right v", "Down w"];
        Section::new(
            "body-velocity",
            "Body velocity",
            "The same velocity in body axes: forward, right and down. \
                          Hover control and model identification use these \
                          components.",
        )
        .with(Figure::against_time(self.rows(
            names,
            "m/s",
            |motion| &motion.body_velocity_mps,
            Some(&columns(self.data.solutions, body_velocity_sigma_mps)),
        )))
    }

    fn attitude(&self) -> Section {
        let sigma = columns(self.data.solutions, |s| s.attitude_sigma_rad.map(f64::to_degrees));
        let rows = self.rows(ANGLES, "°", |motion| &motion.attitude_deg, Some(&sigma));
        let rows = rows.enumerate().map(|(axis, row)| row.with(self.unit_attitude(axis)));
        Section::new(
            "attitude",
            "Attitude",
            "Roll (right side down), pitch (nose up) and yaw (heading clockwise from \
                          true north), with 3σ bands. Yaw wraps at ±180°.",
        )
        .with(Figure::against_time(rows))
    }

    fn biases(&self) -> Section {
        const AXES: [&str; 3] = ["x", "y", "z"];
        let solutions = self.data.solutions;
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
        Section::new(
            "biases",
            "Sensor biases",
            "Estimated biases of gyros and accelerometers, \
                          with 3σ bands. A band narrows while the filter estimates a bias.",
        )
        .with(Figure::against_time(gyro.into_iter().chain(accelerometer)))
    }

    /// 3σ ellipses of the position at the end and at its largest uncertainty. North and east count as independent.
    fn ellipses(&self) -> Series {
        let level = |index: &usize| {
            let [north, east, _] = self.data.solutions[*index].position_sigma_m.to_array();
            north.hypot(east)
        };
        let last = self.data.solutions.len().checked_sub(1);
        let widest = (0..self.data.solutions.len())
            .filter(|index| level(index).is_finite())
            .max_by(|a, b| level(a).total_cmp(&level(b)));
        let outline = |index: usize| {
            let sigma = self.data.solutions[index].position_sigma_m.to_array();
            let [north, east, _] = &self.estimate.position_m;
            let turn = (0..=48).map(|step| std::f64::consts::TAU * f64::from(step) / 48.0);
            let points = turn.map(move |angle| {
                (
                    east[index] + 3.0 * sigma[1] * angle.sin(),
                    north[index] + 3.0 * sigma[0] * angle.cos(),
                )
            });
            points.chain([(f64::NAN, f64::NAN)])
        };
        let shown = last.into_iter().chain(widest.filter(|widest| Some(*widest) != last));
        Series::curve(Role::Ellipse, shown.flat_map(outline))
    }

    /// Barometric heights as metres down from the origin, shifted by the median difference: a barometer has its own
    /// zero.
    fn baro(&self) -> Series {
        let down = &self.estimate.position_m[2];
        let points: Vec<(f64, f64)> = self
            .data
            .baro
            .iter()
            .map(|(time, height)| (self.clock.seconds(*time), -height))
            .collect();
        let mut offsets: Vec<f64> = points
            .iter()
            .filter_map(|(time, baro)| {
                let index = self.estimate.time.partition_point(|known| known < time);
                Some(down.get(index)? - baro).filter(|offset| offset.is_finite())
            })
            .collect();
        let offset = quantile(&mut offsets, 0.5).unwrap_or(f64::NAN);
        let moved = points.into_iter().map(|(time, baro)| (time, baro + offset));
        Series::points(Role::Sensor, moved).named("Barometer, shifted to agree")
    }

    /// The attitude angle from the inertial unit, if it reports one.
    fn unit_attitude(&self, axis: usize) -> Series {
        let angles = self.raw.iter().flat_map(|raw| raw.attitude[axis].iter().copied());
        Series::points(Role::Sensor, angles).named("Inertial unit")
    }

    /// One row per component: reference, smoothed, and estimate with its 3σ band.
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
            let drawn = |role, x: &[f64], y: &[f64], band: Option<&[f64]>| {
                if name == "Yaw" {
                    Series::heading(role, x, y, band)
                } else {
                    Series::line(role, x, y, band)
                }
            };
            let line = |role, motion: &Motion, band: Option<&[f64]>| {
                drawn(role, &motion.time, &quantity(motion)[component], band)
            };
            let [onboard_time, onboard] =
                known([&self.onboard.time, &quantity(&self.onboard)[component]]);
            Row { limits: (name == "Yaw").then_some([-185.0, 185.0]), ..Row::new(name, unit) }
                .with(line(Role::Reference, &self.reference, None))
                .with(drawn(Role::Onboard, &onboard_time, &onboard, None))
                .with(line(Role::Smoothed, &self.smoothed, None))
                .with(line(Role::Estimate, &self.estimate, band.as_deref()))
        })
    }
}

/// Standard deviation of u, v and w, m/s, from those of velocity and attitude, which are taken as independent.
fn body_velocity_sigma_mps(solution: &Solution) -> [f64; 3] {
    let ned_to_body = solution.body_to_ned.inverse().matrix();
    let sigma = solution.velocity_sigma_mps.to_array();
    let [u, v, w] = solution.velocity_body_mps().to_array();
    let [roll, pitch, yaw] = solution.attitude_sigma_rad;
    let turned =
        [(v * yaw).hypot(w * pitch), (u * yaw).hypot(w * roll), (u * pitch).hypot(v * roll)];
    std::array::from_fn(|axis| {
        let row = ned_to_body.row(axis).to_array();
        let of_velocity: f64 = row.iter().zip(sigma).map(|(c, sigma)| (c * sigma).powi(2)).sum();
        (of_velocity + turned[axis].powi(2)).sqrt()
    })
}

/// Three times `sigma`.
fn triple(sigma: &[f64]) -> Vec<f64> {
    sigma.iter().map(|sigma| 3.0 * sigma).collect()
}

/// Reverses the axis of the downward component.
fn downwards(rows: impl Iterator<Item = Row>) -> impl Iterator<Item = Row> {
    rows.enumerate().map(|(component, row)| Row { reversed: component == 2, ..row })
}

/// The origin of the page's local coordinates, in words.
fn described(origin: &Geodetic) -> String {
    format!(
        "the first position ({:.6}°, {:.6}°, {:.1} m above the ellipsoid)",
        origin.latitude_deg(),
        origin.longitude_deg(),
        origin.height_m
    )
}
