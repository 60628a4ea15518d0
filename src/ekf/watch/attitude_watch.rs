//! Check of an attitude reference against the turns of the gyros.

use crate::frames::wrap_angle;
use crate::scalar::Scalar;

/// Recent swing of the difference between an attitude reference and the filter, which turns with the gyros.
///
/// A reference with slow errors keeps a steady difference to the gyros' attitude. The difference swings with the
/// vehicle's motion if the reference is frozen, late, smoothed or disturbed by accelerations. A steady change of the
/// difference is a drift of either gyros or reference; it does not count.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct AttitudeWatch {
    /// Last difference between reference and filter, rad.
    last: [f32; 3],
    /// Slow mean of the difference, rad.
    mean: [f32; 3],
    /// Slow mean of the deviation from `mean`, rad: the effect of a drift.
    drift: [f32; 3],
    /// Mean square of the swing, in tilt and in heading, rad². The swing is the difference minus mean and drift.
    square: [f32; 2],
    /// Whether a previous difference exists.
    is_begun: bool,
}

impl AttitudeWatch {
    /// State before the first comparison.
    pub const NONE: Self =
        Self { last: [0.0; 3], mean: [0.0; 3], drift: [0.0; 3], square: [0.0; 2], is_begun: false };

    /// Starts again: the next difference is not compared with earlier ones.
    pub fn forget(&mut self) {
        self.is_begun = false;
    }

    /// Adds a difference between reference and filter about north, east and down, rad, `elapsed_s` after the previous
    /// one.
    ///
    /// # Source
    /// Equation (M8) of docs/equations.md.
    pub fn push(&mut self, off_rad: [f32; 3], elapsed_s: f32) {
        // A reference that follows the motion does not step. After a step, the gate decides between reference and
        // filter.
        let jumped = |(last, off): (f32, f32)| wrap_angle(off - last).abs() > JUMP_RAD;
        if !self.is_begun || self.last.into_iter().zip(off_rad).any(jumped) {
            (self.mean, self.drift) = (off_rad, [0.0; 3]);
        }
        (self.last, self.is_begun) = (off_rad, true);
        let newest = (elapsed_s / MEMORY_S).min(1.0);
        let mut squares = [0.0; 3];
        let axes = self.mean.iter_mut().zip(&mut self.drift).zip(off_rad).zip(&mut squares);
        for (((mean, drift), off), square) in axes {
            let deviation = wrap_angle(off - *mean);
            *mean += newest * deviation;
            *drift += newest * (deviation - *drift);
            *square = (deviation - *drift) * (deviation - *drift);
        }
        let [north, east, down] = squares;
        for (mean, square) in self.square.iter_mut().zip([0.5 * (north + east), down]) {
            let memory_s = if square > *mean { RISE_S } else { FALL_S };
            *mean += (elapsed_s / memory_s).min(1.0) * (square - *mean);
        }
    }

    /// Accounts for a correction of the filter towards the reference, by `by_rad` about north, east and down.
    pub fn corrected(&mut self, by_rad: [f32; 3]) {
        for ((mean, last), by) in self.mean.iter_mut().zip(&mut self.last).zip(by_rad) {
            *mean -= by;
            *last -= by;
        }
    }

    /// Whether the reference turns differently from the gyros.
    pub fn is_inconsistent(&self) -> bool {
        self.square.iter().any(|square| *square > MAX_RAD * MAX_RAD)
    }

    /// Additional variances of a reading in tilt and heading, rad², beyond its noise of `noise_rad`, for readings every
    /// `elapsed_s`.
    pub fn excess<T: Scalar>(&self, noise_rad: f64, elapsed_s: f32) -> [T; 2] {
        let usual = USUAL * (noise_rad * noise_rad) as f32;
        let alike = (2.0 * ALIKE_S / elapsed_s).max(1.0);
        self.square.map(|square| T::of(f64::from(alike * (square - usual).max(0.0))))
    }
}

/// Largest change of the difference from one reading to the next, rad, that is not a jump.
const JUMP_RAD: f32 = 0.3;
/// Time constant of the mean difference and of its drift, s. Slower changes belong to the slow error of the reference.
const MEMORY_S: f32 = 3.0;
/// Time constant, s, with which a growing swing is detected.
const RISE_S: f32 = 1.0;
/// Time constant, s, with which a past swing is forgotten.
const FALL_S: f32 = 5.0;
/// Largest mean square swing, in multiples of the reference's noise variance, that counts as noise.
const USUAL: f32 = 1.5;
/// Correlation time, s, of the reference's error while the difference swings.
const ALIKE_S: f32 = 1.0;
/// Largest root mean square swing, rad (2.5°), of a reference that follows the vehicle's motion.
const MAX_RAD: f32 = 0.044;

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f32 = 0.1;
    const NOISE_RAD: f64 = 0.009;

    /// Heading of a vehicle that turns to and fro by 10° in 4 s, rad.
    fn heading_rad(time_s: f32) -> f32 {
        0.17 * (core::f32::consts::FRAC_PI_2 * time_s).sin()
    }

    /// Monitor after one minute of a reference whose heading is `reference_rad(time_s)`.
    fn watched(reference_rad: impl Fn(f32) -> f32) -> AttitudeWatch {
        let mut watch = AttitudeWatch::NONE;
        for step in 0..600_u16 {
            let time_s = STEP_S * f32::from(step);
            watch.push([0.0, 0.0, reference_rad(time_s) - heading_rad(time_s)], STEP_S);
        }
        watch
    }

    #[test]
    fn a_heading_that_is_frozen_late_or_smoothed_is_denied() {
        assert!(watched(|_| 0.1).is_inconsistent());
        assert!(watched(|time_s| heading_rad(time_s - 0.3)).is_inconsistent());
        assert!(watched(|time_s| 0.5 * heading_rad(time_s)).is_inconsistent());
    }

    #[test]
    fn one_that_is_off_by_much_or_drifts_as_gyros_may_is_not() {
        for (off_rad, drift_radps) in [(0.0, 0.0), (2.0, 0.0), (3.1, 0.017), (-3.1, -0.05)] {
            let watch = watched(|time_s| heading_rad(time_s) + off_rad + drift_radps * time_s);
            assert!(!watch.is_inconsistent(), "{off_rad} {drift_radps}");
            let [tilt, heading] = watch.excess::<f64>(NOISE_RAD, STEP_S);
            assert!(tilt == 0.0 && heading < 1e-4, "{off_rad} {drift_radps}: {heading}");
        }
    }

    #[test]
    fn one_that_jumps_is_left_to_the_gate() {
        let jumped = |time_s: f32| if time_s > 59.0 { 1.5 } else { 0.0 };
        assert!(!watched(|time_s| heading_rad(time_s) + jumped(time_s)).is_inconsistent());
    }

    #[test]
    fn a_little_late_it_counts_for_less() {
        let watch = watched(|time_s| heading_rad(time_s - 0.1));
        assert!(!watch.is_inconsistent());
        let [_, heading] = watch.excess::<f64>(NOISE_RAD, STEP_S);
        assert!(heading > 10.0 * NOISE_RAD * NOISE_RAD, "{heading}");
    }

    #[test]
    fn what_the_filter_corrects_is_no_swing() {
        let mut watch = AttitudeWatch::NONE;
        let mut off_rad = 0.3;
        for step in 0..200 {
            watch.push([off_rad, 0.0, 0.0], STEP_S);
            if step % 20 == 10 {
                watch.corrected([0.1, 0.0, 0.0]);
                off_rad -= 0.1;
            }
        }
        assert_eq!(watch.excess::<f64>(NOISE_RAD, STEP_S), [0.0; 2]);
    }
}
