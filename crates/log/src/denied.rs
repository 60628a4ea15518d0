//! Where the fixes deny a smoothed flight.
//!
//! The smoother takes every error of the filter for one that its covariance knew of. Where the filter was far
//! off and reopened, what is carried back across that moment is wrong by many of its own sigmas, and the
//! fixes tell so.

use hovernav::ekf::Solution;
use hovernav::ins::LeverArm;
use hovernav::time::Time;

use crate::dataset::Dataset;
use crate::finding::{Finding, FindingKind, Sensor, Severity};
use crate::replay::Run;
use crate::statistics::quantile;

/// Fixes within this time to either side judge a moment together, s.
const BESIDE_S: f64 = 5.0;
/// Fewer fixes than this judge nothing.
const LEAST_FIXES: usize = 4;
/// A mean square this many times as large as is usual in the flight, and as expected, denies.
const DENIED: f64 = 6.0;

/// A stretch that the fixes deny.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Denied {
    pub start: Time,
    pub end: Time,
    /// Fixes in it.
    fixes: usize,
    /// Root of the largest mean square in it.
    sigmas: f64,
}

impl Denied {
    /// Whether a moment falls into it.
    pub fn covers(&self, time: Time) -> bool {
        (self.start..=self.end).contains(&time)
    }

    pub fn finding(&self) -> Finding {
        let (start_s, end_s) = (self.start.seconds(), self.end.seconds());
        Finding {
            start_s,
            end_s,
            sensor: Sensor::Filter,
            kind: FindingKind::SmoothingDenied,
            severity: Severity::Warning,
            count: self.fixes,
            words: format!(
                "smoothing denied from {start_s:.1} to {end_s:.1} s: the velocities of the fixes are off the \
                 smoothed path by {:.1} one-sigmas, either wrong themselves or of a filter that was far off and \
                 put right; the filter's own solution stands there",
                self.sigmas
            ),
        }
    }
}

/// The stretches of `solutions`, smoothed from the filter of `forward`, that the fixes deny. A receiver that is
/// wrong denies what is right as well: that costs no more than the smoothing.
///
/// # Source
/// The residuals of a smoothed path by Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking
/// and Navigation*, section 8.6; their variance is taken for that of fix and path together, which is
/// more than it is.
pub(crate) fn denied(dataset: &Dataset, forward: &Run, solutions: &[Solution]) -> Vec<Denied> {
    let squares = residuals(dataset, forward, solutions);
    let mut sizes: Vec<f64> = squares.iter().map(|(_, square)| *square).collect();
    let Some(usual) = quantile(&mut sizes, 0.5) else { return Vec::new() };
    let limit = DENIED * usual.max(1.0);
    let mut found: Vec<Denied> = Vec::new();
    for (time, _) in &squares {
        let (start, end) = (time.offset_by(-BESIDE_S), time.offset_by(BESIDE_S));
        let first = squares.partition_point(|(time, _)| *time < start);
        let last = squares.partition_point(|(time, _)| *time <= end);
        let beside = &squares[first..last];
        let mean = beside.iter().map(|(_, square)| square).sum::<f64>() / beside.len() as f64;
        if beside.len() < LEAST_FIXES || mean < limit {
            continue;
        }
        match found.last_mut() {
            Some(span) if start <= span.end => {
                span.end = end;
                span.fixes += 1;
                span.sigmas = span.sigmas.max(mean.sqrt());
            }
            _ => found.push(Denied { start, end, fixes: 1, sigmas: mean.sqrt() }),
        }
    }
    found
}

/// Of each fix with a horizontal velocity, refused or not: when it held, and the mean over north and east of the
/// squared difference to `solutions` in units of its variance.
fn residuals(dataset: &Dataset, forward: &Run, solutions: &[Solution]) -> Vec<(Time, f64)> {
    let (early_s, _) = forward.gps_offset.unwrap_or_default();
    let arm = LeverArm(forward.config.mounting.antenna_lever_arm_m);
    dataset
        .fixes
        .iter()
        .filter_map(|fix| {
            let time = fix.time.offset_by(-early_s);
            let next = solutions.partition_point(|solution| solution.time < time);
            let (before, after) = (solutions.get(next.checked_sub(1)?)?, solutions.get(next)?);
            let share = (time - before.time) / (after.time - before.time);
            let of_arm = |solution: &Solution| {
                let Solution { velocity_mps, body_to_ned, angular_rate_radps, .. } = *solution;
                arm.velocity(velocity_mps, body_to_ned, angular_rate_radps)
            };
            let path = of_arm(before) * (1.0 - share) + of_arm(after) * share;
            let stated = fix.velocity_sigma_mps.map(|sigma| sigma.to_array());
            let [path_north, path_east, _] = path.to_array();
            let [north, east] = fix.horizontal_velocity_mps?;
            let [sigma_north, sigma_east, _] = after.velocity_sigma_mps.to_array();
            let gps = &forward.config.ekf.gps;
            let [of_north, of_east] = stated
                .map_or([gps.horizontal_velocity_sigma_mps; 2], |[north, east, _]| {
                    [north, east].map(|sigma| sigma.max(gps.velocity_floor_mps))
                });
            let square = |off: f64, a: f64, b: f64| off * off / (a * a + b * b);
            let sum = square(north - path_north, of_north, sigma_north)
                + square(east - path_east, of_east, sigma_east);
            Some((time, 0.5 * sum))
        })
        .collect()
}
