//! Spans in which the fixes are inconsistent with a smoothed flight.
//!
//! The smoother assumes that the filter's covariance covers every error. If the filter had diverged and was reset, the
//! smoothed states before the reset are off by many of their own one-sigmas. The fixes show this.

use hovernav::ekf::Solution;
use hovernav::ins::LeverArm;
use hovernav::time::Time;

use crate::run::Run;
use hovernav_dataset::Dataset;
use hovernav_dataset::statistics::{quantile, within};

/// Half-width, s, of the window of fixes by which the path at a time is judged.
const HALF_WINDOW_S: f64 = 5.0;
/// Smallest number of fixes in a window.
const MIN_FIXES: usize = 4;
/// Smallest ratio of the mean square in an inconsistent window to its expected value. The ratio to the median over the
/// flight must also reach it.
const INCONSISTENT: f64 = 6.0;

/// Span of a smoothed path with which the fixes are inconsistent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InconsistentSpan {
    /// Start of the first inconsistent window.
    pub start: Time,
    /// End of the last inconsistent window.
    pub end: Time,
    /// Number of inconsistent windows, each centred on a fix.
    pub fixes: usize,
    /// Root of the largest mean square, in one-sigmas.
    pub sigmas: f64,
}

impl InconsistentSpan {
    /// Whether the span contains a time.
    #[must_use]
    pub fn covers(&self, time: Time) -> bool {
        (self.start..=self.end).contains(&time)
    }
}

/// Spans in which the fixes are inconsistent with `solutions`, smoothed from the filter run `forward`. An error of the
/// receiver also leads to such spans, although the path is correct. These spans then lose only the accuracy gained by
/// smoothing.
///
/// # Source
/// Residuals of a smoothed path after Bar-Shalom, Li, Kirubarajan, *Estimation with Applications to Tracking and
/// Navigation*, section 8.6. Their variance is approximated by the sum of the variances of fix and path, which is
/// larger.
pub(crate) fn inconsistent_spans(
    dataset: &Dataset,
    forward: &Run,
    solutions: &[Solution],
) -> Vec<InconsistentSpan> {
    let squares = residuals(dataset, forward, solutions);
    let mut sizes: Vec<f64> = squares.iter().map(|(_, square)| *square).collect();
    let Some(usual) = quantile(&mut sizes, 0.5) else { return Vec::new() };
    let limit = INCONSISTENT * usual.max(1.0);
    let mut found: Vec<InconsistentSpan> = Vec::new();
    for (time, _) in &squares {
        let (start, end) = (time.offset_by(-HALF_WINDOW_S), time.offset_by(HALF_WINDOW_S));
        let beside = within(&squares, |(time, _)| *time, start, end);
        let mean = beside.iter().map(|(_, square)| square).sum::<f64>() / beside.len() as f64;
        if beside.len() < MIN_FIXES || mean < limit {
            continue;
        }
        match found.last_mut() {
            Some(span) if start <= span.end => {
                span.end = end;
                span.fixes += 1;
                span.sigmas = span.sigmas.max(mean.sqrt());
            }
            _ => found.push(InconsistentSpan { start, end, fixes: 1, sigmas: mean.sqrt() }),
        }
    }
    found
}

/// Time of validity of each fix with a horizontal velocity, and the velocity's squared difference from `solutions`
/// divided by the variance. The square is the mean over north and east. Rejected fixes are included.
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
