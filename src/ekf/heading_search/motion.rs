//! Motion according to the hypotheses of a heading search, for a filter whose heading is unknown.

use super::super::scalar::Scalar;
use super::super::square;
use super::guess::{Block, Guess, STATES};
use super::{
    AGREED_RAD, GUESS_SIGMA_RAD, HeadingSearch, LEAST_SHARE, PROVEN_S, UNPROVEN_RAD, at,
    turn_between,
};
use crate::frames::{Body, Ned, Rotation, Vector, wrap_angle};

/// Motion according to the best hypothesis, and its covariance over all hypotheses.
#[derive(Clone, Copy, Debug)]
pub struct GuessedMotion<T> {
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
    /// Turn about the axis of unknown attitude from the start of the search, rad.
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
    pub(super) fn motion(&mut self) -> Option<GuessedMotion<T>> {
        let best = *self.best().filter(|_| self.has_begun())?;
        self.motion_of(&best)
    }

    fn motion_of(&mut self, guess: &Guess) -> Option<GuessedMotion<T>> {
        let (time, _) = self.last_fix?;
        let (velocity_mps, bias_radps) =
            (guess.velocity_after(&self.since_fix), guess.bias_radps());
        let [.., down] = guess.start_to_ned.rows();
        let mut covariance = [[0.0; STATES]; STATES];
        let weights: f64 = self.guesses.iter().map(|other| other.weight).sum();
        for other in &mut self.guesses {
            let share = (other.weight / weights) as f32;
            for (row, line) in covariance.iter_mut().zip(other.covariance()) {
                for (sum, value) in row.iter_mut().zip(line) {
                    *sum += share * value;
                }
            }
            let there = other.velocity_after(&self.since_fix);
            let [.., own_down] = other.start_to_ned.rows();
            let tilt = own_down.into_iter().zip(down).map(|(a, b)| square(a - b)).sum::<f32>();
            let mut spread = [0.0; STATES];
            for axis in 0..3 {
                let apart = at(&there, axis) - at(&velocity_mps, axis);
                let drift = at(&other.bias_radps(), axis) - at(&bias_radps, axis);
                let of = [(axis, square(apart)), (3 + axis, tilt), (6 + axis, square(drift))];
                for (state, variance) in of {
                    if let Some(sum) = spread.get_mut(state) {
                        *sum = variance;
                    }
                }
            }
            for (state, (row, variance)) in covariance.iter_mut().zip(spread).enumerate() {
                if let Some(sum) = row.get_mut(state) {
                    *sum += share * variance;
                }
            }
            other.correct_bias(bias_radps);
        }
        let (off_rad, agreed_rad) = self.heading_spread();
        let is_proven =
            self.is_fast || self.agreed_since.is_some_and(|since| time - since >= PROVEN_S);
        let least_rad = if is_proven { 0.0 } else { UNPROVEN_RAD };
        let heading_sigma_rad =
            Scalar::hypot(agreed_rad, off_rad).min(core::f64::consts::PI).max(least_rad);
        let wide = |value: f32| T::of(f64::from(value));
        let taken = bias_radps.map(wide);
        self.filter_bias_radps = self.filter_bias_radps.map(|used| used + taken.into());
        let motion = GuessedMotion {
            body_to_ned: self.attitude(guess),
            velocity_mps: velocity_mps.map(wide).into(),
            bias_radps: taken.into(),
            covariance,
            heading_sigma_rad,
            turn_rad: turn_between(self.start_to_ned.cast(), guess.start_to_ned, self.axis),
            is_found: is_proven && agreed_rad < AGREED_RAD,
        };
        let is_sound = motion.velocity_mps.is_finite()
            && motion.body_to_ned.is_finite()
            && covariance.as_flattened().iter().all(|value| value.is_finite());
        is_sound.then_some(motion)
    }

    /// Motion according to the hypothesis that points a baseline of the body nearest to `heading_rad`, clockwise from
    /// north. `None` if the fixes contradict that hypothesis.
    pub(super) fn motion_at(
        &mut self,
        baseline: Vector<Body>,
        heading_rad: f64,
    ) -> Option<GuessedMotion<T>> {
        let best = self.best().filter(|_| self.has_begun())?;
        let turn_rad = |guess: &Guess| {
            let pointed = (self.attitude(guess) * baseline.cast()).azimuth_rad().wide();
            wrap_angle(heading_rad - pointed)
        };
        let off = |guess: &&Guess| libm::fabs(turn_rad(guess));
        let nearest = *self.guesses.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if nearest.weight < LEAST_SHARE * best.weight {
            return None;
        }
        let turn = Vector::new(T::ZERO, T::ZERO, T::of(turn_rad(&nearest)));
        let motion = self.motion_of(&nearest)?;
        let body_to_ned = motion.body_to_ned.turned_in_to(turn);
        Some(GuessedMotion { body_to_ned, heading_sigma_rad: GUESS_SIGMA_RAD, ..motion })
    }
}
