//! A barometer that repeats itself while the vehicle climbs or sinks.

use super::judged::Judged;
use super::spans::{improbable_runs, when};
use crate::finding::{Finding, FindingKind, Sensor};
use hovernav_dataset::statistics::quantile;

/// Shortest repetition of a height, s, that counts as frozen: a shorter one may be real.
const FROZEN_S: f64 = 10.0;
/// Smallest change of the solution's height, m, during a repetition that counts as frozen.
const MOVED_M: f64 = 3.0;
/// Smallest such change in usual steps of the barometer's height; the larger of the two limits applies.
const STEPS: f64 = 3.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let baro = &log.dataset.baro;
    let heights: Vec<f64> = baro.iter().map(|(_, height_m)| *height_m).collect();
    let steps = heights.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    let mut runs = improbable_runs(&heights);
    if steps.is_empty() && heights.len() > 1 {
        runs = vec![(0, heights.len() - 1)];
    }
    let least_m = MOVED_M.max(STEPS * quantile(&mut steps, 0.5).unwrap_or(0.0));
    for (first, last) in runs {
        let (start_s, end_s) = (baro[first].0.seconds(), baro[last].0.seconds());
        let moved_m = climbed_m(log, start_s, end_s);
        if end_s - start_s < FROZEN_S || moved_m < least_m {
            continue;
        }
        let words = format!(
            "barometer frozen {}: {} readings repeat {:.1} m to the last digit while the height changed by \
             {moved_m:.1} m: the sensor or its connection delivered no new measurements",
            when(start_s, end_s),
            last - first,
            heights[first]
        );
        findings.push(
            Finding::warning(
                Sensor::Barometer,
                FindingKind::BarometerFrozen,
                (start_s, end_s),
                words,
            )
            .of(last - first),
        );
    }
}

/// Range of the solution's height within a span, m.
fn climbed_m(log: &Judged<'_>, start_s: f64, end_s: f64) -> f64 {
    let (mut lowest_m, mut highest_m) = (f64::INFINITY, f64::NEG_INFINITY);
    for solution in &log.run.solutions {
        if (start_s..=end_s).contains(&solution.time.seconds()) {
            lowest_m = lowest_m.min(solution.position.height_m);
            highest_m = highest_m.max(solution.position.height_m);
        }
    }
    highest_m - lowest_m
}
