//! Fixes between those of the receiver: positions on straight lines of equal duration.

use hovernav::gps::Fix;

use super::regression::norm;
use crate::finding::{Sensor, SetupFinding};
use hovernav_dataset::statistics::quantile;

/// Smallest movement from fix to fix, m; the last digit of a coordinate is 1 cm.
const MIN_STEP_M: f64 = 0.05;
/// Largest change of the interval between fixes, relative.
const UNEVEN: f64 = 0.2;
/// Smallest size of a corner, in third quartiles of all second differences; noise of a receiver reaches less.
const CORNER: f64 = 6.0;
/// Smallest second difference of a corner, m.
const MIN_CORNER_M: f64 = 1e-4;
/// Smallest number of fixes from corner to corner.
const MIN_LINE: usize = 5;
/// Smallest number of corners.
const MIN_CORNERS: usize = 20;
/// Smallest fraction of the distances between corners that are multiples of one number of fixes. Outliers have any
/// distance.
const REGULAR: f64 = 0.9;

/// Reports fixes that were interpolated between those of the receiver.
pub(super) fn check(fixes: &[Fix], found: &mut Vec<SetupFinding>) {
    let bends: Vec<(usize, f64)> = (1..fixes.len().saturating_sub(1))
        .filter_map(|at| Some((at, bend_m(fixes, at)?)))
        .collect();
    let mut sizes: Vec<f64> = bends.iter().map(|(_, bend_m)| *bend_m).collect();
    let Some(usual_m) = quantile(&mut sizes, 0.75) else { return };
    let least_m = MIN_CORNER_M.max(CORNER * usual_m);
    let corners: Vec<usize> =
        bends.iter().filter(|(_, bend_m)| *bend_m > least_m).map(|(at, _)| *at).collect();
    let lines: Vec<usize> = corners.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut lengths: Vec<f64> = lines.iter().map(|line| *line as f64).collect();
    let Some(length) = quantile(&mut lengths, 0.5).map(|length| length as usize) else { return };
    // The times of samples and of fixes differ, so a line may be one fix longer or shorter.
    let is_regular = |line: &&usize| (**line + 1) % length <= 2;
    let regular = lines.iter().filter(is_regular).count();
    if length < MIN_LINE
        || lines.len() < MIN_CORNERS
        || (regular as f64) < REGULAR * lines.len() as f64
    {
        return;
    }
    let line_s = (fixes[corners[0] + 1].time - fixes[corners[0]].time) * length as f64;
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

/// Distance of a moving fix from the middle between its neighbours, m, times two.
fn bend_m(fixes: &[Fix], at: usize) -> Option<f64> {
    let [before, here, after] = [at - 1, at, at + 1].map(|at| &fixes[at]);
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

    /// Fixes at 50 Hz on a winding path at 15 m/s, interpolated between those at each `line_s`.
    fn flight(line_s: f64) -> Vec<Fix> {
        let origin = Geodetic { latitude_rad: 0.8, longitude_rad: 0.1, height_m: 400.0 };
        let path = |t: f64| [15.0 * t, 40.0 * (0.3 * t).sin()];
        let fix = |k: u32| {
            let time_s = 0.02 * f64::from(k);
            let from = (time_s / line_s).floor() * line_s;
            let share = (time_s - from) / line_s;
            let [a, b] = [path(from), path(from + line_s)];
            let [north, east] = [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]));
            let down = hovernav::frames::Vector::new(north, east, 0.0);
            Fix::at(Time::from_seconds(time_s), origin.displaced(down))
        };
        (0..3000).map(fix).collect()
    }

    #[test]
    fn interpolated_fixes_are_named_and_measured_ones_are_not() {
        for (line_s, expected) in
            [(1.0, Some("50 fixes, 1.00 s")), (0.2, Some("10 fixes")), (0.02, None)]
        {
            let mut found = Vec::new();
            check(&flight(line_s), &mut found);
            let is_found = |words: &str| found.iter().any(|one| one.found.contains(words));
            assert!(expected.map_or(found.is_empty(), is_found), "{line_s}: {found:?}");
        }
    }
}
