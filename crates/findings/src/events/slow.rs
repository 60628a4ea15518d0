//! Bias steps, from the filter's own bias estimates.

use hovernav::time::Time;

use super::judged::Judged;
use super::spans::when;
use crate::finding::{Finding, FindingKind, Sensor};

/// Longest time between the two compared values of a bias, s.
const OVER_S: f64 = 20.0;
/// Smallest step of a bias that is reported, in one-sigmas: the larger one of before and after. A correct bias changes
/// less, even at the end of a rest.
const STEP: f64 = 6.0;
/// Smallest step of a gyro's bias that is reported, rad/s.
const MIN_GYRO: f64 = 0.005;
/// Smallest step of an accelerometer's bias that is reported, m/s².
const MIN_ACCEL: f64 = 0.2;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let solutions = &log.run.solutions;
    let Some(first) = solutions.first() else { return };
    // Steps for which the filter itself has enlarged its bias uncertainty are judged in `steps`.
    let opened = log.run.reports().filter(|report| report.bias_variance_was_raised());
    let suspect: Vec<f64> = opened.filter_map(|report| report.time().map(Time::seconds)).collect();
    // Two solutions a second are enough.
    let mut coarse = Vec::new();
    let mut next_s = first.time.seconds() + OVER_S;
    for solution in solutions {
        if solution.time.seconds() >= next_s {
            next_s += 0.5;
            coarse.push(solution);
        }
    }
    for (what, least, unit, scale) in [
        ("gyro", MIN_GYRO, "°/s", 180.0 / std::f64::consts::PI),
        ("accelerometer", MIN_ACCEL, "m/s²", 1.0),
    ] {
        for axis in 0..3 {
            let at = |index: usize| {
                let solution = coarse[index];
                let (bias, sigma) = if what == "gyro" {
                    (solution.gyro_bias_radps, solution.gyro_bias_sigma_radps)
                } else {
                    (solution.accel_bias_mps2, solution.accel_bias_sigma_mps2)
                };
                (solution.time.seconds(), bias.to_array()[axis], sigma.to_array()[axis])
            };
            let mut largest: Option<(f64, f64, f64, f64)> = None;
            let mut before = 0;
            for index in 0..coarse.len() {
                let (end_s, after, sigma_after) = at(index);
                while at(before).0 < end_s - OVER_S {
                    before += 1;
                }
                let (start_s, earlier, sigma_before) = at(before);
                let sigma = sigma_before.max(sigma_after);
                let change = after - earlier;
                let ratio = change.abs() / sigma.max(1e-12);
                if change.abs() > least
                    && ratio > STEP
                    && !suspect.iter().any(|&suspect_s| (start_s..end_s).contains(&suspect_s))
                    && largest.is_none_or(|most| change.abs() > most.2.abs())
                {
                    largest = Some((start_s, end_s, change, sigma));
                }
            }
            let Some((start_s, end_s, change, sigma)) = largest else { continue };
            let words = format!(
                "{what} bias of axis {} changed by {:.3} {unit} {}, with a one-sigma of {:.3}: the sensor \
                 stepped, or the filter attributes another error to it",
                ["x", "y", "z"][axis],
                change * scale,
                when(start_s, end_s),
                sigma * scale
            );
            findings.push(Finding::warning(
                Sensor::InertialUnit,
                FindingKind::BiasStep,
                (start_s, end_s),
                words,
            ));
        }
    }
}
