//! The speed that a receiver tells against the distance between its places.

use std::ops::Range;

use super::look::median;
use crate::text::{CourseUnit, GpsColumns, SpeedUnit};
use hovernav::gps::Fix;

/// Units differ by 15 % at least, knots from miles an hour; places scatter.
const UNIT_TOLERANCE: f64 = 1.07;
/// Speeds further from the places than this are a doubt.
const SPEED_TOLERANCE: f64 = 1.1;
/// The same where directions disagree, as they do where places scatter.
const SPEED_TOLERANCE_ASTRAY: f64 = 1.5;
/// Cosine of the angle between velocity and displacement, below which they do not belong together.
const LEAST_COSINE: f64 = 0.7;
/// From this on the two tell a unit: where places scatter by half as much as the vehicle moves, it is less.
pub(super) const TELLING_COSINE: f64 = 0.9;
/// So many legs are enough to tell.
const LEAST_LEGS: usize = 5;

const SPEED_UNITS: [SpeedUnit; 6] = [
    SpeedUnit::MetresPerSecond,
    SpeedUnit::CentimetresPerSecond,
    SpeedUnit::MillimetresPerSecond,
    SpeedUnit::KilometresPerHour,
    SpeedUnit::Knots,
    SpeedUnit::MilesPerHour,
];
pub(super) const COURSE_UNITS: [CourseUnit; 4] =
    [CourseUnit::Degrees, CourseUnit::Radians, CourseUnit::Centidegrees, CourseUnit::ScaledDegrees];

/// What the units of a receiver's velocity are taken from.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Told {
    /// Whether a name, or the receiver's known format, tells the unit of the speed.
    pub speed: bool,
    /// The same of the course.
    pub course: bool,
    /// The same of the vertical velocity.
    pub vertical: bool,
}

/// How a receiver's velocity agrees with its places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Travel {
    /// Distance between places over that by speed.
    pub ratio: f64,
    /// Cosine of the angle between the two, in the median.
    pub cosine: f64,
}

/// How velocity and places of `fixes` agree; `None` where the vehicle moves too little, or too unsteadily, to
/// tell.
pub(super) fn travel(fixes: &[Fix]) -> Option<Travel> {
    let legs = legs(fixes);
    let cosine = median(legs.iter().map(Leg::cosine).collect());
    // Along a bend the chord is shorter than the path, but the sum of velocities is not longer than the chord.
    let ratio = |leg: &Leg| match cosine > LEAST_COSINE {
        true => norm(leg.moved_m) / norm(leg.velocity_m),
        false => norm(leg.moved_m) / leg.path_m,
    };
    let ratios = legs.iter().map(ratio).filter(|ratio| ratio.is_finite()).collect();
    let ratio = steady(ratios, 0.75..1.33).filter(|ratio| *ratio > 0.0)?;
    Some(Travel { ratio, cosine })
}

/// The median of `ratios` if there are enough of them and two thirds of them are within `near` of it.
fn steady(ratios: Vec<f64>, near: Range<f64>) -> Option<f64> {
    let middle = median(ratios.clone());
    let close = ratios.iter().filter(|ratio| near.contains(&(**ratio / middle))).count();
    (ratios.len() >= LEAST_LEGS && 3 * close >= 2 * ratios.len()).then_some(middle)
}

/// Some fixes that follow each other.
#[derive(Default)]
struct Leg {
    /// By the places, north and east.
    moved_m: [f64; 2],
    /// By the velocities, north and east, and along the path.
    velocity_m: [f64; 2],
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

/// The legs on which the vehicle moves further than places scatter.
fn legs(fixes: &[Fix]) -> Vec<Leg> {
    /// From one fix to the next, s.
    const LONGEST_STEP_S: f64 = 5.0;
    /// Of a leg, s: one of the slowest receivers has two fixes.
    const LONGEST_S: f64 = 10.0;
    /// A leg ends after so many metres, and counts from so many on.
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

/// Takes the unit of the speed in `gps` from how far the places are apart unless it is `told`; what was found, and
/// what is in doubt.
pub(super) fn settle_speed(
    gps: &mut GpsColumns,
    travel: Option<Travel>,
    told: Told,
    findings: &mut Vec<String>,
    doubts: &mut Vec<String>,
) {
    let (unit, columns) = (gps.speed_unit, velocity_columns(gps));
    let Some(Travel { ratio, cosine }) = travel else {
        if !told.speed {
            doubts.push(format!(
                "gps: nothing says the unit of {columns}, taken as {}: the vehicle moves too little to tell \
                 by the distances between the fixes; set speed_unit under [table.gps]",
                unit.name()
            ));
        }
        if !told.course && gps.course_unit == CourseUnit::Radians {
            doubts.push(format!(
                "gps: {} is taken as rad, as it stays below 6.3, and the vehicle moves too little to tell; \
                 if it is not, set course_unit under [table.gps]",
                gps.course
            ));
        }
        return;
    };
    let away = |candidate: &SpeedUnit| (candidate.factor() / unit.factor() / ratio).ln().abs();
    let nearest = SPEED_UNITS.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    let off = ratio.max(1.0 / ratio);
    let is_telling = cosine >= TELLING_COSINE;
    let fitting = nearest.filter(|nearest| is_telling && away(nearest) < UNIT_TOLERANCE.ln());
    match fitting {
        Some(fitting) if !told.speed => {
            gps.speed_unit = fitting;
            findings.push(format!(
                "{columns} agrees with the distances between the fixes if it is in {}",
                fitting.name()
            ));
        }
        _ if off > SPEED_TOLERANCE && (is_telling || off > SPEED_TOLERANCE_ASTRAY) => {
            let instead = fitting.map_or_else(String::new, |fitting| {
                format!("; as {} they would agree", fitting.name())
            });
            doubts.push(format!(
                "gps: {columns} as {} gives {:.2} times the distances between the fixes{instead}: check \
                 speed_unit and unit under [table.gps]",
                unit.name(),
                1.0 / ratio
            ));
        }
        _ if !told.speed => doubts.push(format!(
            "gps: nothing says the unit of {columns}, taken as {}, in which it gives {:.2} times the distances \
             between the fixes",
            unit.name(),
            1.0 / ratio
        )),
        _ => {}
    }
    if cosine < LEAST_COSINE {
        let angle_deg = cosine.clamp(-1.0, 1.0).acos().to_degrees();
        doubts.push(format!(
            "gps: the vehicle moves {angle_deg:.0}° from where {columns} says, in the median: are columns \
             swapped, is a sign or course_unit under [table.gps] another, or is the course a heading?"
        ));
    }
}

/// The columns of the velocity over ground.
fn velocity_columns(gps: &GpsColumns) -> String {
    if gps.north.is_empty() {
        format!("{} with {}", gps.speed, gps.course)
    } else {
        format!("{} with {}", gps.north, gps.east)
    }
}

/// Holds the vertical velocity of `fixes` against their heights; what is in doubt.
pub(super) fn judge_climb(gps: &GpsColumns, fixes: &[Fix], told: Told, doubts: &mut Vec<String>) {
    let column = if gps.down.is_empty() { &gps.up } else { &gps.down };
    if column.is_empty() {
        return;
    }
    match climb_ratio(fixes) {
        Some(ratio) if !(0.75..1.33).contains(&ratio) => doubts.push(format!(
            "gps: {column} as {}, with the sign that is taken, gives {:.2} times the change of height: is its \
             unit or its sign another, or that of the height?",
            gps.speed_unit.name(),
            1.0 / ratio
        )),
        None if !told.vertical && gps.speed_unit != SpeedUnit::MetresPerSecond => {
            doubts.push(format!(
                "gps: nothing says the unit of {column}, taken as {} as the speed over ground is",
                gps.speed_unit.name()
            ));
        }
        _ => {}
    }
}

/// The change of height over that by the vertical velocity; `None` where the vehicle climbs too little, or too
/// unsteadily, to tell.
fn climb_ratio(fixes: &[Fix]) -> Option<f64> {
    /// Over so many seconds at least, and from one fix to the next at most.
    const LEG_S: [f64; 2] = [5.0, 2.5];
    /// Heights scatter by metres.
    const LEAST_M: f64 = 8.0;
    let (mut ratios, mut first, mut climbed_m) = (Vec::new(), 0, 0.0);
    for (at, pair) in fixes.windows(2).enumerate() {
        let interval_s = pair[1].time - pair[0].time;
        let down = pair[0].down_velocity_mps.zip(pair[1].down_velocity_mps);
        let Some((before, after)) = down.filter(|_| interval_s <= LEG_S[1]) else {
            (first, climbed_m) = (at + 1, 0.0);
            continue;
        };
        climbed_m -= 0.5 * (before + after) * interval_s;
        if pair[1].time - fixes[first].time >= LEG_S[0] {
            let risen_m = pair[1].position.height_m - fixes[first].position.height_m;
            if risen_m.abs() >= LEAST_M {
                ratios.push(risen_m / climbed_m);
            }
            (first, climbed_m) = (at + 1, 0.0);
        }
    }
    steady(ratios, 0.67..1.5)
}
