//! Whether inertial samples integrate over the time between them, or are points of it.

use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_log::Dataset;

/// How much of the time the samples integrate over.
#[derive(Debug, Default)]
pub(crate) struct Integrals {
    integrated_s: f64,
    spanned_s: f64,
    last: Option<Time>,
}

/// Longer intervals between samples are gaps, s.
const GAP_S: f64 = 1.0;
/// Integrals that cover this share of the time are whole.
const WHOLE: f64 = 0.9;
/// Point samples faster than this leave little of what vibrates below half their rate, Hz.
const FAST_HZ: f64 = 100.0;

/// Says of samples that are points in time what that costs.
pub(crate) fn remark_points(dataset: &mut Dataset) {
    if let Some(rate_hz) = dataset.imu_rate_hz().filter(|&rate| rate < FAST_HZ) {
        dataset.warnings.push(format!(
            "inertial samples are points at {rate_hz:.0} Hz, not integrals over the time between: \
             vibration above {:.0} Hz aliases into them, and attitude and velocity drift",
            rate_hz / 2.0
        ));
    }
}

impl Integrals {
    /// Counts a sample that integrates over `integral_s` and ends at `time`.
    pub fn sample(&mut self, time: Time, integral_s: f64) {
        if let Some(last) = self.last.replace(time) {
            let interval_s = time - last;
            if interval_s > 0.0 && interval_s < GAP_S && integral_s.is_finite() {
                self.integrated_s += integral_s;
                self.spanned_s += interval_s;
            }
        }
    }

    /// The share of the time that samples integrate over; `None` of fewer than two.
    pub fn share(&self) -> Option<f64> {
        (self.spanned_s > 0.0).then(|| self.integrated_s / self.spanned_s)
    }

    /// Whether nothing, or next to nothing, of the time is missing from the integrals.
    pub fn are_whole(&self) -> bool {
        self.share().is_some_and(|share| share >= WHOLE)
    }
}

/// Turns means over the interval before each sample into integrals over it: for a sample that was lost
/// the one after it stands in.
pub(crate) fn integrate(samples: &mut [ImuSample]) {
    let mut last = None;
    let first_s = samples.get(1).map_or(0.0, |second| second.time - samples[0].time);
    for sample in samples {
        let interval_s = last.map_or(first_s, |last| sample.time - last);
        last = Some(sample.time);
        if let Motion::Rates { angular_rate_radps, specific_force_mps2 } = sample.motion {
            sample.motion = Motion::Increments {
                angle_rad: angular_rate_radps * interval_s,
                velocity_mps: specific_force_mps2 * interval_s,
            };
        }
    }
}
