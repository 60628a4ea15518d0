//! Error of the antenna's lever arm, estimated from turns about the vertical.
//!
//! An antenna offset by δ from its declared position adds a velocity r × δ in a turn at rate r. A filter without this
//! term attributes the velocity to tilt and biases. The two horizontal components of δ are estimated outside the
//! filter's state, from the velocity of each fix alone. Correlations with the states are neglected. The offset is used
//! once it makes the fixes more likely, both in left and in right turns. Other errors do not change sign with the turn.

use crate::frames::{Body, Vector};
use crate::matrix::square;
use crate::scalar::root;

/// Estimated offset of the antenna from its declared lever arm.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct AntennaOffset {
    /// Estimated offset forward and to the right, in levelled axes, m.
    found_m: [f32; 2],
    /// Variance of each component of the offset, in multiples of the square of [`SIGMA_M`].
    variance: f32,
    /// Log likelihood ratio of the recent fixes, with the offset against without it: in left turns, then in right
    /// turns.
    evidence: [f32; 2],
    used: bool,
    /// Variance at the last report, infinite before the first.
    reported_variance: f32,
}

/// One-sigma of the antenna's offset before the first turn, m.
const SIGMA_M: f32 = 1.0;
/// Offset, m, that decides whether a turn counts. It must cause more velocity than a time error of [`LATE_S`].
const LOOKED_FOR_M: f32 = 0.3;
/// Minimum rate of a turn that is used, rad/s.
const SLOWEST_RADPS: f32 = 0.1;
/// Uncertainty of a fix's time, s. Its product with the acceleration is a velocity error.
const LATE_S: f32 = 0.05;
/// Evidence that left turns and right turns must each exceed before the offset is used. It then stays in use.
const ENOUGH: f32 = 4.0;
/// Upper limit of the evidence from each direction of turn.
const MAX_EVIDENCE: f32 = 10.0;
/// Minimum offset, m, for the offset to be used: the error of a smaller offset would be as large as the offset.
const MIN_M: f32 = 0.25;
/// Largest residual, in one-sigmas, after subtraction of the velocity caused by the offset. A fix beyond it is an
/// outlier and is ignored.
const OUTLIER: f32 = 5.0;
/// Ratio of the offset's variance to its variance at the last report, below which the offset is reported again.
const FALLEN: f32 = 0.25;

impl AntennaOffset {
    /// State before the first turn: zero offset.
    pub const BEFORE_FIRST_TURN: Self = Self {
        found_m: [0.0; 2],
        variance: 1.0,
        evidence: [0.0; 2],
        used: false,
        reported_variance: f32::INFINITY,
    };

    /// Whether a rate about the vertical, rad/s, is fast enough to show the antenna offset.
    pub fn is_turn(rate_radps: f32) -> bool {
        rate_radps.abs() >= SLOWEST_RADPS
    }

    /// Correction to add to the lever arm, body axes of a level vehicle, m.
    pub fn offset_m(&self) -> Vector<Body, f32> {
        let [x, y] = if self.used { self.found_m } else { [0.0; 2] };
        Vector::new(x, y, 0.0)
    }

    /// Offset and its one-sigma, m, for a report. `Some` at the first use of the offset, and again each time its
    /// variance has fallen to a quarter.
    pub fn next_report(&mut self) -> Option<(Vector<Body, f32>, f32)> {
        if !(self.used && self.variance < FALLEN * self.reported_variance) {
            return None;
        }
        self.reported_variance = self.variance;
        Some((self.offset_m(), SIGMA_M * root(self.variance)))
    }

    /// Variance of a fix's horizontal velocity due to the remaining offset error, at this rate about the vertical,
    /// (m/s)².
    pub fn velocity_variance(&self, rate_radps: f32) -> f32 {
        if self.used { self.own_variance(rate_radps) } else { 0.0 }
    }

    fn own_variance(&self, rate_radps: f32) -> f32 {
        SIGMA_M * SIGMA_M * square(rate_radps) * self.variance
    }

    /// Feeds the innovation of a fix's horizontal velocity, forward and right, m/s. `variance`, (m/s)², is the
    /// innovation variance of each component without the contribution of the antenna offset. `rate_radps` is the rate
    /// of turn, `acceleration_mps2` the horizontal acceleration.
    ///
    /// # Source
    /// Equation (M16) of docs/equations.md.
    pub fn observe_innovation(
        &mut self,
        rate_radps: f32,
        acceleration_mps2: f32,
        [forward, right]: [f32; 2],
        variance: f32,
    ) {
        let is_sharp = LATE_S * acceleration_mps2 < LOOKED_FOR_M * rate_radps.abs();
        // The comparison also rejects NaN.
        if !(Self::is_turn(rate_radps)
            && is_sharp
            && (rate_radps + forward + right).is_finite()
            && variance > 0.0
            && variance.is_finite())
        {
            return;
        }
        let own = self.own_variance(rate_radps);
        let [x, y] = self.found_m;
        // Velocity caused by the offset, and the residual with and without the offset.
        let (swing_forward, swing_right) = (-rate_radps * y, rate_radps * x);
        let (with, without) = if self.used {
            ([forward, right], [forward + swing_forward, right + swing_right])
        } else {
            ([forward - swing_forward, right - swing_right], [forward, right])
        };
        let size = |[a, b]: [f32; 2]| square(a) + square(b);
        if size(with) > square(OUTLIER) * (variance + own) {
            return;
        }
        let likelier = 0.5 * (size(without) / variance - size(with) / (variance + own))
            - logarithm_of_one_and(own / variance);
        let [left_hand, right_hand] = &mut self.evidence;
        let side = if rate_radps < 0.0 { left_hand } else { right_hand };
        *side = (*side + likelier).clamp(0.0, MAX_EVIDENCE);
        let gain = own / (own + variance);
        let [forward, right] = with;
        self.found_m = [x + gain * right / rate_radps, y - gain * forward / rate_radps];
        self.variance *= 1.0 - gain;
        let is_far = size(self.found_m) > square(MIN_M);
        self.used |= is_far && self.evidence.iter().all(|side| *side > ENOUGH);
    }
}

/// ln(1 + x) by its Padé approximant of orders 2 and 1. The error is at most 1 % up to x = 1; beyond, the result is too
/// large.
fn logarithm_of_one_and(x: f32) -> f32 {
    x * (6.0 + x) / (6.0 + 4.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One-sigma of a fix's velocity, m/s.
    const NOISE_MPS: f32 = 0.1;

    /// State after fixes in turns at these rates, with an antenna offset by `off_m` from its declared lever arm.
    fn flown(off_m: [f32; 2], rates_radps: impl IntoIterator<Item = f32>) -> AntennaOffset {
        let mut antenna = AntennaOffset::BEFORE_FIRST_TURN;
        for (step, rate) in rates_radps.into_iter().enumerate() {
            // Noise differs from fix to fix, with unit variance over many.
            let phase = 2.4 * step as f32;
            let noise = [phase.sin(), phase.cos()].map(|unit| unit * NOISE_MPS * 2_f32.sqrt());
            let known = antenna.offset_m().to_array();
            let left = [off_m[0] - known[0], off_m[1] - known[1]];
            let innovation = [-rate * left[1] + noise[0], rate * left[0] + noise[1]];
            antenna.observe_innovation(rate, 0.3, innovation, NOISE_MPS * NOISE_MPS);
        }
        antenna
    }

    fn to_and_fro(turns: usize) -> impl Iterator<Item = f32> {
        (0..turns).map(|turn| if turn % 4 < 2 { 0.5 } else { -0.5 })
    }

    #[test]
    fn an_antenna_a_metre_off_is_found_by_turns_to_both_sides() {
        let mut antenna = flown([0.4, -0.9], to_and_fro(40));
        let (offset_m, sigma_m) = antenna.next_report().unwrap();
        assert!(
            (offset_m - Vector::new(0.4, -0.9, 0.0)).norm() < 3.0 * sigma_m,
            "{offset_m:?} {sigma_m}"
        );
        assert!(sigma_m < 0.05 && antenna.next_report().is_none());
    }

    #[test]
    fn turns_to_one_side_alone_convince_nobody() {
        let mut antenna = flown([0.4, -0.9], core::iter::repeat_n(0.5, 100));
        assert!(antenna.next_report().is_none() && antenna.offset_m() == Vector::ZERO);
        assert!(antenna.velocity_variance(0.5) == 0.0);
    }

    #[test]
    fn an_antenna_that_stands_where_its_lever_arm_says_stays_there() {
        for turns in 1..400 {
            assert!(flown([0.0, 0.0], to_and_fro(turns)).offset_m() == Vector::ZERO);
        }
    }

    #[test]
    fn slow_turns_hard_accelerations_and_what_is_no_number_tell_nothing() {
        let mut antenna = flown([0.4, -0.9], to_and_fro(40).map(|rate| 0.1 * rate));
        for step in 0..100 {
            let rate = if step % 4 < 2 { 0.5 } else { -0.5 };
            antenna.observe_innovation(rate, 10.0, [0.5 * rate, rate], 0.01);
            antenna.observe_innovation(rate, 0.0, [f32::NAN, rate], 0.01);
            antenna.observe_innovation(rate, f32::NAN, [rate, rate], 0.01);
            antenna.observe_innovation(f32::NAN, 0.0, [rate, rate], 0.01);
            antenna.observe_innovation(f32::INFINITY, 0.0, [rate, rate], 0.01);
            antenna.observe_innovation(rate, 0.0, [rate, rate], f32::INFINITY);
            antenna.observe_innovation(rate, 0.0, [rate, rate], f32::NAN);
        }
        assert!(antenna.variance == 1.0 && antenna.evidence == [0.0; 2]);
    }
}
