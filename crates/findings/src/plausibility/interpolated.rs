//! Fixes between those of the receiver: positions on straight lines of equal duration.

use hovernav::earth::SEMI_MAJOR_AXIS_M;
use hovernav::gps::Fix;

use super::regression::norm;
use crate::finding::{Sensor, SetupFinding};
use hovernav_dataset::statistics::quantile;

/// Smallest movement from fix to fix, m; the last digit of a coordinate is 1 cm.
const MIN_STEP_M: f64 = 0.05;
/// Largest change of the interval between fixes, relative.
const UNEVEN: f64 = 0.2;
/// Smallest size of a corner, in usual second differences; noise of a receiver reaches less.
const CORNER: f64 = 6.0;
/// Smallest second difference of a corner, m.
const MIN_CORNER_M: f64 = 1e-4;
/// Smallest second difference of a corner, in steps of the rounded coordinates. Rounding alone reaches 2.8.
const ROUNDING: f64 = 3.0;
/// Distances, in fixes, over which second differences are formed, each with the quantile of the second differences that
/// is their usual size. Over more fixes, corners are larger and the rounding stays the same.
const SPACINGS: [(usize, f64); 5] = [(1, 0.75), (2, 0.5), (4, 0.5), (8, 0.5), (16, 0.5)];
/// Smallest number of fixes from corner to corner.
const MIN_LINE: usize = 5;
/// Smallest number of fixes from corner to corner, in spacings: most second differences are between corners.
const MIN_SPACINGS: usize = 4;
/// Smallest number of corners.
const MIN_CORNERS: usize = 20;
/// Smallest fraction of the distances between corners that are multiples of one number of fixes. Outliers have any
/// distance.
const REGULAR: f64 = 0.9;

/// Reports fixes that were interpolated between those of the receiver.
pub(super) fn check(fixes: &[Fix], found: &mut Vec<SetupFinding>) {
    let rounding_m = rounding_m(fixes);
    let lines = SPACINGS.iter().find_map(|usual| lines(fixes, *usual, rounding_m));
    let Some((length, line_s)) = lines else { return };
    found.push(SetupFinding {
        sensor: Sensor::Gps,
        is_certain: false,
        found: format!(
            "positions lie on straight lines of {length} fixes, {line_s:.2} s, with corners between them"
        ),
        cause: "interpolated from fewer fixes: the filter would assume independent errors".into(),
        mend: "write only the fixes of the receiver, once each".into(),
    });
}

/// Length of the lines on which `fixes` lie, fixes and s, by second differences over `spacing` fixes. Coordinates are
/// rounded to `rounding_m`.
fn lines(fixes: &[Fix], (spacing, usual): (usize, f64), rounding_m: f64) -> Option<(usize, f64)> {
    let bends: Vec<Option<f64>> = (0..fixes.len()).map(|at| bend_m(fixes, at, spacing)).collect();
    let mut sizes: Vec<f64> = bends.iter().flatten().copied().collect();
    let usual_m = quantile(&mut sizes, usual)?;
    let least_m = MIN_CORNER_M.max(CORNER * usual_m).max(ROUNDING * rounding_m);
    let is_corner = |at: &usize| {
        let near = at.saturating_sub(spacing - 1)..(at + spacing).min(bends.len());
        let is_largest = |size_m: f64| {
            let (before, after) = bends[near.clone()].split_at(at - near.start);
            before.iter().flatten().all(|other| size_m > *other)
                && after.iter().flatten().all(|other| size_m >= *other)
        };
        bends[*at].is_some_and(|size_m| size_m > least_m && is_largest(size_m))
    };
    let corners: Vec<usize> = (0..bends.len()).filter(is_corner).collect();
    let lines: Vec<usize> = corners.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut lengths: Vec<f64> = lines.iter().map(|line| *line as f64).collect();
    let length = quantile(&mut lengths, 0.5)? as usize;
    // The times of samples and of fixes differ, so a line may be one fix longer or shorter.
    let is_regular = |line: &&usize| (**line + 1) % length <= 2;
    let regular = lines.iter().filter(is_regular).count();
    let are_lines = length >= MIN_LINE.max(MIN_SPACINGS * spacing)
        && lines.len() >= MIN_CORNERS
        && regular as f64 >= REGULAR * lines.len() as f64;
    let line_s = (fixes.get(corners[0] + 1)?.time - fixes[corners[0]].time) * length as f64;
    are_lines.then_some((length, line_s))
}

/// Step of coordinates rounded to decimals of a degree, otherwise of a minute, m; 0 without rounding.
fn rounding_m(fixes: &[Fix]) -> f64 {
    /// Largest difference from a multiple of the step, in steps: conversion to radians and back.
    const OFF: f64 = 0.01;
    let steps_deg = (4..=9)
        .map(|digits| 0.1_f64.powi(digits))
        .chain((3..=7).map(|digits| 0.1_f64.powi(digits) / 60.0));
    let is_on = |step_deg: f64, degrees: f64| {
        let steps = degrees / step_deg;
        (steps - steps.round()).abs() < OFF
    };
    let are_on = |step_deg: &f64| {
        fixes.iter().map(|fix| fix.position).all(|position| {
            is_on(*step_deg, position.latitude_deg()) && is_on(*step_deg, position.longitude_deg())
        })
    };
    let step_deg = steps_deg.into_iter().find(are_on).unwrap_or(0.0);
    SEMI_MAJOR_AXIS_M * step_deg.to_radians()
}

/// Distance of a moving fix from the middle between those `spacing` fixes before and after it, m, times two.
fn bend_m(fixes: &[Fix], at: usize, spacing: usize) -> Option<f64> {
    let before = fixes.get(at.checked_sub(spacing)?)?;
    let (here, after) = (fixes.get(at)?, fixes.get(at + spacing)?);
    let [first_s, second_s] = [here.time - before.time, after.time - here.time];
    let level = |to: &Fix| {
        let moved = to.position.displacement_from(&here.position);
        [moved.x(), moved.y()]
    };
    let [back, on] = [level(before), level(after)];
    let is_moving = norm(back) > MIN_STEP_M && norm(on) > MIN_STEP_M;
    let is_even = (second_s - first_s).abs() < UNEVEN * first_s;
    (is_moving && is_even).then(|| norm([back[0] + on[0], back[1] + on[1]]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::earth::Geodetic;
    use hovernav::time::Time;

    /// Fixes at 50 Hz on a winding path at 15 m/s, interpolated between those at each `line_s`, with rounded coordinates.
    fn flight(line_s: f64, digits: i32) -> Vec<Fix> {
        let rounded = |degrees: f64| (degrees * 10f64.powi(digits)).round() / 10f64.powi(digits);
        let origin = Geodetic { latitude_rad: 0.8, longitude_rad: 0.1, height_m: 400.0 };
        let path = |t: f64| [15.0 * t, 40.0 * (0.3 * t).sin()];
        let fix = |k: u32| {
            let time_s = 0.02 * f64::from(k);
            let from = (time_s / line_s).floor() * line_s;
            let share = (time_s - from) / line_s;
            let [a, b] = [path(from), path(from + line_s)];
            let [north, east] = [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
            let down = hovernav::frames::Vector::new(north, east, 0.0);
            let Geodetic { height_m, .. } = origin;
            let exact = origin.displaced(down);
            let [latitude, longitude] = [exact.latitude_deg(), exact.longitude_deg()].map(rounded);
            let position = Geodetic::from_degrees(latitude, longitude, height_m).unwrap();
            Fix::at(Time::from_seconds(time_s), position)
        };
        (0..3000).map(fix).collect()
    }

    #[test]
    fn interpolated_fixes_are_named_and_measured_ones_are_not() {
        for (line_s, digits, expected) in [
            (1.0, 12, Some("50 fixes, 1.00 s")),
            (0.2, 12, Some("10 fixes")),
            (0.02, 12, None),
            (1.0, 7, Some("50 fixes, 1.00 s")),
            (0.02, 7, None),
            (0.02, 6, None),
            (0.02, 5, None),
        ] {
            let mut found = Vec::new();
            check(&flight(line_s, digits), &mut found);
            let is_found = |words: &str| found.iter().any(|one| one.found.contains(words));
            assert!(expected.map_or(found.is_empty(), is_found), "{line_s} {digits}: {found:?}");
        }
    }
}
