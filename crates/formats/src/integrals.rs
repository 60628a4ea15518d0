//! Distinguishes inertial samples that integrate over their interval from point samples.

use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::Dataset;

/// Accumulates the fraction of the time that the intervals of integrated samples cover.
#[derive(Debug, Default)]
pub(crate) struct Integrals {
    integrated_s: f64,
    spanned_s: f64,
    last: Option<Time>,
}

/// Shortest interval between samples that counts as a gap, s.
const GAP_S: f64 = 1.0;
/// Longest interval over which a sample is integrated, s; after a longer one the filter restarts.
const LONGEST_S: f64 = 60.0;
/// Smallest covered fraction of the time at which the integrals are complete.
const WHOLE: f64 = 0.9;
/// Sample rate above which point samples alias little vibration, Hz.
const FAST_HZ: f64 = 100.0;

/// Adds a warning about slow point samples.
pub(crate) fn remark_points(dataset: &mut Dataset) {
    if let Some(rate_hz) = dataset.imu_rate_hz().filter(|&rate| rate < FAST_HZ) {
        dataset.warnings.push(format!(
            "the inertial samples are instantaneous values at {rate_hz:.0} Hz, not integrals over \
             their interval: vibration above {:.0} Hz aliases, and attitude and velocity drift",
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

    /// The fraction of the time that the intervals of integrated samples cover; `None` for fewer than two samples.
    pub fn share(&self) -> Option<f64> {
        (self.spanned_s > 0.0).then(|| self.integrated_s / self.spanned_s)
    }

    /// Whether the integrals cover the time, at least to the fraction [`WHOLE`].
    pub fn are_whole(&self) -> bool {
        self.share().is_some_and(|share| share >= WHOLE)
    }
}

/// Converts mean rates over the interval before each sample to integrals. After a lost sample, the next sample covers
/// the longer interval.
pub(crate) fn integrate(samples: &mut [ImuSample]) {
    let mut last = None;
    let first_s = samples.get(1).map_or(0.0, |second| second.time - samples[0].time);
    for sample in samples {
        let interval_s = last.map_or(first_s, |last| sample.time - last).min(LONGEST_S);
        last = Some(sample.time);
        if let Motion::Rates { angular_rate_radps, specific_force_mps2 } = sample.motion {
            sample.motion = Motion::Increments {
                angle_rad: angular_rate_radps * interval_s,
                velocity_mps: specific_force_mps2 * interval_s,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::frames::Vector;

    #[test]
    fn a_jump_of_the_clock_makes_no_impossible_increment() {
        let motion = Motion::Rates {
            angular_rate_radps: Vector::ZERO,
            specific_force_mps2: Vector::new(0.0, 0.0, -9.8),
        };
        let times = [0.0, 0.02, 1e6, 1e6 + 0.02].map(|seconds| Time::ZERO + seconds);
        let mut samples = times.map(|time| ImuSample::new(time, motion));
        integrate(&mut samples);
        assert!(samples.iter().all(|sample| sample.motion.is_finite()));
    }
}
