//! Compares a receiver's velocity with the distances between its positions.

use std::ops::Range;

use super::look::median;
use crate::text::{CourseUnit, GpsColumns, SpeedUnit};
use hovernav::gps::Fix;

/// Largest ratio of the two distances, or of its inverse, at which a unit fits. Units differ by at least 10 % (feet per
/// second and km/h), and positions scatter.
const UNIT_TOLERANCE: f64 = 1.07;
/// Ratio of speed to displacement, or its inverse, above which a warning is given.
const SPEED_TOLERANCE: f64 = 1.1;
/// [`SPEED_TOLERANCE`] for directions that disagree because the positions scatter.
const SPEED_TOLERANCE_SCATTERED: f64 = 1.5;
/// Cosine of the angle between velocity and displacement below which they are inconsistent.
pub(super) const MIN_COSINE: f64 = 0.7;
/// Cosine above which velocity and displacement determine a unit. It is lower if the positions scatter by half the
/// vehicle's movement.
pub(super) const DECISIVE_COSINE: f64 = 0.9;
/// Number of legs needed for a conclusion.
const MIN_LEGS: usize = 5;

const SPEED_UNITS: [SpeedUnit; 7] = [
    SpeedUnit::MetresPerSecond,
    SpeedUnit::CentimetresPerSecond,
    SpeedUnit::MillimetresPerSecond,
    SpeedUnit::KilometresPerHour,
    SpeedUnit::Knots,
    SpeedUnit::MilesPerHour,
    SpeedUnit::FeetPerSecond,
];
pub(super) const COURSE_UNITS: [CourseUnit; 4] =
    [CourseUnit::Degrees, CourseUnit::Radians, CourseUnit::Centidegrees, CourseUnit::ScaledDegrees];

/// Units that the file states: of velocity, height, barometer and gyros.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StatedUnits {
    /// Whether a name or the receiver's known format states the unit of the speed.
    pub speed: bool,
    /// Whether the unit of the course is stated.
    pub course: bool,
    /// Whether the unit of the vertical velocity is stated.
    pub vertical: bool,
    /// Whether the unit of the height is stated.
    pub height: bool,
    /// Whether the unit of the barometer is stated. The unit of a pressure follows from its size.
    pub baro: bool,
    /// Whether the unit of the gyros is stated.
    pub gyro: bool,
    /// Whether gyros of unknown unit give whole numbers, which may be counts.
    pub is_gyro_whole: bool,
}

/// Agreement of a receiver's velocity with its positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Travel {
    /// Distance between positions divided by the distance from integrated speed.
    pub ratio: f64,
    /// Median cosine of the angle between displacement and velocity.
    pub cosine: f64,
}

/// Agreement of velocity and positions in `fixes`; `None` if the vehicle moves too little, or too unsteadily, to
/// decide.
pub(super) fn travel(fixes: &[Fix]) -> Option<Travel> {
    let legs = legs(fixes);
    let cosine = median(legs.iter().map(Leg::cosine).collect());
    // In a bend the path is longer than the chord; the integrated velocity vector is not.
    let ratio = |leg: &Leg| match cosine > MIN_COSINE {
        true => norm(leg.moved_m) / norm(leg.velocity_m),
        false => norm(leg.moved_m) / leg.path_m,
    };
    let ratios = legs.iter().map(ratio).filter(|ratio| ratio.is_finite()).collect();
    let ratio = steady(ratios, 0.75..1.33).filter(|ratio| *ratio > 0.0)?;
    Some(Travel { ratio, cosine })
}

/// The median of `ratios`. `None` with fewer than [`MIN_LEGS`] ratios, or if fewer than two thirds of them, divided
/// by the median, are in `near`.
fn steady(ratios: Vec<f64>, near: Range<f64>) -> Option<f64> {
    let middle = median(ratios.clone());
    let close = ratios.iter().filter(|ratio| near.contains(&(**ratio / middle))).count();
    (ratios.len() >= MIN_LEGS && 3 * close >= 2 * ratios.len()).then_some(middle)
}

/// Movement over several consecutive fixes.
#[derive(Default)]
struct Leg {
    /// Displacement between the positions, north and east, m.
    moved_m: [f64; 2],
    /// Integrated velocity, north and east, m.
    velocity_m: [f64; 2],
    /// Length of the path from integrated speed, m.
    path_m: f64,
}

impl Leg {
    fn cosine(&self) -> f64 {
        let [a, b] = [self.moved_m, self.velocity_m];
        (a[0] * b[0] + a[1] * b[1]) / (norm(a) * norm(b))
    }
}

fn norm([north, east]: [f64; 2]) -> f64 {
    north.hypot(east)
}

/// The legs on which the vehicle moves further than positions scatter.
fn legs(fixes: &[Fix]) -> Vec<Leg> {
    /// Longest interval between consecutive fixes, s.
    const LONGEST_STEP_S: f64 = 5.0;
    /// Longest leg, s; with the slowest receivers it contains two fixes.
    const LONGEST_S: f64 = 10.0;
    /// Distance after which a leg ends, and smallest distance at which it counts, m.
    const LENGTH_M: [f64; 2] = [20.0, 5.0];
    let (mut legs, mut leg, mut first) = (Vec::new(), Leg::default(), 0);
    for (at, pair) in fixes.windows(2).enumerate() {
        let interval_s = pair[1].time - pair[0].time;
        let velocities = pair[0].horizontal_velocity_mps.zip(pair[1].horizontal_velocity_mps);
        let Some((before, after)) = velocities.filter(|_| interval_s <= LONGEST_STEP_S) else {
            (leg, first) = (Leg::default(), at + 1);
            continue;
        };
        for axis in 0..2 {
            leg.velocity_m[axis] += 0.5 * (before[axis] + after[axis]) * interval_s;
        }
        leg.path_m += 0.5 * (norm(before) + norm(after)) * interval_s;
        let moved_m = pair[1].position.displacement_from(&fixes[first].position);
        leg.moved_m = [moved_m.x(), moved_m.y()];
        let is_long = norm(leg.moved_m) >= LENGTH_M[0];
        if is_long || pair[1].time - fixes[first].time >= LONGEST_S {
            let whole = std::mem::take(&mut leg);
            if norm(whole.moved_m) >= LENGTH_M[1] && whole.path_m > 0.0 {
                legs.push(whole);
            }
            first = at + 1;
        }
    }
    legs
}

/// Determines the unit of the speed in `gps` from the distances between positions, unless it is `stated`. Appends
/// findings and points to check.
pub(super) fn settle_speed(
    gps: &mut GpsColumns,
    travel: Option<Travel>,
    stated: StatedUnits,
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) {
    let (unit, columns) = (gps.speed_unit, velocity_columns(gps));
    let Some(Travel { ratio, cosine }) = travel else {
        if !stated.speed {
            checks.push(format!(
                "gps: the unit of {columns} is not stated and is assumed to be {}; the vehicle \
                 moves too little to determine it from the positions. Set speed_unit under \
                 [table.gps]",
                unit.name()
            ));
        }
        if !stated.course && gps.course_unit == CourseUnit::Radians {
            checks.push(format!(
                "gps: {} is read as rad because it stays below 6.3; the vehicle moves too little \
                 to confirm it. If it is not, set course_unit under [table.gps]",
                gps.course
            ));
        }
        return;
    };
    let off = ratio.max(1.0 / ratio);
    let is_decisive = cosine >= DECISIVE_COSINE;
    let fitting = fitting(unit, Travel { ratio, cosine });
    match fitting {
        Some(fitting) if !stated.speed => {
            gps.speed_unit = fitting;
            findings.push(format!(
                "{columns} agrees with the distances between the fixes if the unit is {}",
                fitting.name()
            ));
        }
        _ if off > SPEED_TOLERANCE && (is_decisive || off > SPEED_TOLERANCE_SCATTERED) => {
            let instead = fitting.map_or_else(String::new, |fitting| {
                format!("; as {} they would agree", fitting.name())
            });
            checks.push(format!(
                "gps: {columns}, read as {}, gives {:.2} times the distances between the \
                 fixes{instead}: check speed_unit and unit under [table.gps]",
                unit.name(),
                1.0 / ratio
            ));
        }
        _ if !stated.speed => checks.push(format!(
            "gps: the unit of {columns} is not stated and is assumed to be {}; this gives {:.2} \
             times the distances between the fixes",
            unit.name(),
            1.0 / ratio
        )),
        _ => {}
    }
    if cosine < MIN_COSINE {
        let angle_deg = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        checks.push(format!(
            "gps: the direction of motion differs from {columns} by a median of {angle_deg:.0}°: \
             check for swapped columns, a wrong sign, a wrong course_unit under [table.gps], or a \
             heading instead of a course"
        ));
    }
}

/// The unit of a velocity that was read as `unit`, if the positions determine it.
pub(super) fn fitting(unit: SpeedUnit, Travel { ratio, cosine }: Travel) -> Option<SpeedUnit> {
    let away = |candidate: &SpeedUnit| (candidate.factor() / unit.factor() / ratio).ln().abs();
    let nearest = SPEED_UNITS.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
    (cosine >= DECISIVE_COSINE && away(&nearest) < UNIT_TOLERANCE.ln()).then_some(nearest)
}

/// The columns of the velocity over ground.
fn velocity_columns(gps: &GpsColumns) -> String {
    if gps.north.is_empty() {
        format!("{} with {}", gps.speed, gps.course)
    } else {
        format!("{} with {}", gps.north, gps.east)
    }
}

/// Compares the vertical velocity of `fixes` with their heights and appends points to check.
pub(super) fn judge_climb(
    gps: &GpsColumns,
    fixes: &[Fix],
    stated: StatedUnits,
    checks: &mut Vec<String>,
) {
    let column = if gps.down.is_empty() { &gps.up } else { &gps.down };
    if column.is_empty() {
        return;
    }
    match climb_ratio(fixes) {
        Some(ratio) if !(0.75..1.33).contains(&ratio) => checks.push(format!(
            "gps: {column}, read as {} with the assumed sign, gives {:.2} times the change of \
             height: check its unit and sign, and the unit of the height",
            gps.vertical_unit().name(),
            1.0 / ratio
        )),
        None if !stated.vertical && gps.vertical_unit() != SpeedUnit::MetresPerSecond => {
            checks.push(format!(
                "gps: the unit of {column} is not stated and is assumed to be {}, as for the speed \
                 over ground",
                gps.speed_unit.name()
            ));
        }
        _ => {}
    }
}

/// The change of height divided by the integrated vertical velocity; `None` if the vehicle climbs too little, or too
/// unsteadily, to decide.
pub(super) fn climb_ratio(fixes: &[Fix]) -> Option<f64> {
    /// Shortest and longest leg, s. A leg ends at the smallest change of height that counts.
    const LEG_S: std::ops::Range<f64> = 5.0..60.0;
    /// Longest interval between consecutive fixes, s.
    const LONGEST_STEP_S: f64 = 2.5;
    /// Smallest change of height that counts, m; heights scatter by metres.
    const MIN_M: f64 = 8.0;
    let (mut ratios, mut first, mut climbed_m) = (Vec::new(), 0, 0.0);
    for (at, pair) in fixes.windows(2).enumerate() {
        let interval_s = pair[1].time - pair[0].time;
        let down = pair[0].down_velocity_mps.zip(pair[1].down_velocity_mps);
        let Some((before, after)) = down.filter(|_| interval_s <= LONGEST_STEP_S) else {
            (first, climbed_m) = (at + 1, 0.0);
            continue;
        };
        climbed_m -= 0.5 * (before + after) * interval_s;
        let leg_s = pair[1].time - fixes[first].time;
        let risen_m = pair[1].position.height_m - fixes[first].position.height_m;
        let is_climb = risen_m.abs() >= MIN_M && leg_s >= LEG_S.start;
        if is_climb {
            ratios.push(risen_m / climbed_m);
        }
        if is_climb || leg_s >= LEG_S.end {
            (first, climbed_m) = (at + 1, 0.0);
        }
    }
    steady(ratios, 0.67..1.5)
}

/// Whether the heights of `fixes` change by more than they scatter.
pub(super) fn climbs(fixes: &[Fix]) -> bool {
    /// Number of successive fixes whose median is one height.
    const PART: usize = 10;
    /// Smallest range of the heights, in their median distance from the median of their part.
    const MIN: f64 = 10.0;
    let heights: Vec<f64> = fixes.iter().map(|fix| fix.position.height_m).collect();
    let parts: Vec<f64> = heights.chunks(PART).map(|part| median(part.to_vec())).collect();
    let off = heights.iter().enumerate().map(|(at, height)| (height - parts[at / PART]).abs());
    let scatter = median(off.collect());
    let (low, high) = (parts.iter())
        .fold((f64::MAX, f64::MIN), |(low, high), height| (low.min(*height), high.max(*height)));
    high - low > MIN * scatter
}
