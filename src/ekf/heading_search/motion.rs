//! Motion according to the hypotheses of a heading search, for a filter whose heading is unknown.

use super::hypothesis::{Block, HYPOTHESIS_SIGMA_RAD, Hypothesis, STATES};
use super::{AGREED_RAD, HeadingSearch, MIN_SHARE, PROVEN_S, UNPROVEN_RAD, turn_between};
use crate::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use crate::matrix::square;
use crate::scalar::Scalar;

/// Motion according to the best hypothesis, and its covariance over all hypotheses.
#[derive(Clone, Copy, Debug)]
pub struct HypothesisMotion<T> {
    /// Attitude.
    pub body_to_ned: Rotation<Body, Ned, T>,
    /// Velocity, m/s.
    pub velocity_mps: Vector<Ned, T>,
    /// Gyro bias beyond that of the filter, rad/s.
    pub bias_radps: Vector<Body, T>,
    /// Covariance of velocity, attitude and gyro bias.
    pub covariance: Block,
    /// One-sigma of the heading, rad.
    pub heading_sigma_rad: f64,
    /// Turn about the axis of unknown attitude, rad: from the assumed to the found attitude at the search's start.
    pub turn_rad: f64,
    /// Whether the heading is found.
    pub is_found: bool,
}

impl<T: Scalar> HeadingSearch<T> {
    /// Motion according to the best hypothesis now; `None` before the first fix. Its gyro bias moves to the filter: the
    /// hypotheses exclude it from now on.
    ///
    /// # Source
    /// Equation (H4) of docs/equations.md.
    #[inline(never)]
    pub(in crate::ekf) fn motion(&mut self) -> Option<HypothesisMotion<T>> {
        let best = *self.best().filter(|_| self.has_begun())?;
        self.motion_of(&best)
    }

    fn motion_of(&mut self, hypothesis: &Hypothesis) -> Option<HypothesisMotion<T>> {
        let (time, _) = self.last_fix?;
        let (velocity_mps, bias_radps) =
            (hypothesis.velocity_after(&self.since_fix), hypothesis.bias_radps());
        let [.., down] = hypothesis.start_to_ned.rows();
        let mut covariance = [[0.0; STATES]; STATES];
        let weights: f64 = self.hypotheses.iter().map(|other| other.weight).sum();
        for other in &mut self.hypotheses {
            let share = (other.weight / weights) as f32;
            for (row, line) in covariance.iter_mut().zip(other.covariance()) {
                for (sum, value) in row.iter_mut().zip(line) {
                    *sum += share * value;
                }
            }
            let apart = (other.velocity_after(&self.since_fix) - velocity_mps).to_array();
            let [.., own_down] = other.start_to_ned.rows();
            let tilt = own_down.into_iter().zip(down).map(|(a, b)| square(a - b)).sum::<f32>();
            let drift = (other.bias_radps() - bias_radps).to_array();
            let spread = [apart.map(square), [tilt; 3], drift.map(square)];
            let spread = spread.as_flattened().iter().enumerate();
            for (row, (state, variance)) in covariance.iter_mut().zip(spread) {
                if let Some(sum) = row.get_mut(state) {
                    *sum += share * variance;
                }
            }
            other.correct_bias(bias_radps);
        }
        let (off_rad, agreed_rad) = self.heading_spread();
        let is_proven =
            self.is_fast || self.agreed_since.is_some_and(|since| time - since >= PROVEN_S);
        let min_rad = if is_proven { 0.0 } else { UNPROVEN_RAD };
        let heading_sigma_rad =
            Scalar::hypot(agreed_rad, off_rad).min(core::f64::consts::PI).max(min_rad);
        let taken = bias_radps.cast();
        self.filter_bias_radps = self.filter_bias_radps.map(|used| used + taken);
        let motion = HypothesisMotion {
            body_to_ned: self.attitude(hypothesis),
            velocity_mps: velocity_mps.cast(),
            bias_radps: taken,
            covariance,
            heading_sigma_rad,
            turn_rad: turn_between(self.start_to_ned.cast(), hypothesis.start_to_ned, self.axis),
            is_found: is_proven && agreed_rad < AGREED_RAD,
        };
        let is_sound = motion.velocity_mps.is_finite()
            && motion.body_to_ned.is_finite()
            && covariance.as_flattened().iter().all(|value| value.is_finite());
        is_sound.then_some(motion)
    }

    /// Motion according to the hypothesis that points a baseline of the body nearest to `heading_rad`, clockwise from
    /// north. `None` if the fixes contradict that hypothesis.
    #[inline(never)]
    pub(in crate::ekf) fn motion_at(
        &mut self,
        baseline: Vector<Body>,
        heading_rad: f64,
    ) -> Option<HypothesisMotion<T>> {
        let best = self.best().filter(|_| self.has_begun())?;
        let turn_rad = |hypothesis: &Hypothesis| {
            let pointed = (self.attitude(hypothesis) * baseline.cast()).azimuth_rad().wide();
            wrap_angle(heading_rad - pointed)
        };
        let off = |hypothesis: &&Hypothesis| libm::fabs(turn_rad(hypothesis));
        let nearest = *self.hypotheses.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if nearest.weight < MIN_SHARE * best.weight {
            return None;
        }
        let turn = Vector::new(T::ZERO, T::ZERO, T::of(turn_rad(&nearest)));
        let motion = self.motion_of(&nearest)?;
        let body_to_ned = motion.body_to_ned.turned_in_to(turn);
        Some(HypothesisMotion { body_to_ned, heading_sigma_rad: HYPOTHESIS_SIGMA_RAD, ..motion })
    }
}
