//! What moves the estimate beside its own steps: a correction, and the reset of the covariance.

use super::filter::Ekf;
use super::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use super::process::MOST_HIDDEN_RAD;
use super::scalar::Scalar;
use super::square;
use crate::frames::{Ned, Vector};
use crate::ins::NavState;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Adds a correction of the whole error state to the estimates. A correction to an invalid state,
    /// or one that has left no valid covariance, can only come of gaps that have opened the covariance
    /// beyond what rounding bears: it is not applied, and the covariance is reset. Gives whether that
    /// happened.
    ///
    /// # Source
    /// Equation (K1) of docs/equations.md.
    pub(super) fn correct(&mut self, correction: &[T; N]) -> bool {
        let at = |state: usize| correction.get(state).map_or(0.0, |value| value.wide());
        let block = |first: usize| Vector::<Ned>::new(at(first), at(first + 1), at(first + 2));
        let corrected = NavState {
            time: self.state.time,
            position: self.state.position.displaced(block(POSITION)),
            velocity_mps: self.state.velocity_mps + block(VELOCITY),
            body_to_ned: self.state.body_to_ned.turned_in_to(block(ATTITUDE)).renormalised(),
        };
        if !corrected.is_valid() || !self.covariance.is_valid() {
            self.reset_covariance();
            return true;
        }
        self.state = corrected;
        for (parameter, value) in self.parameters.iter_mut().zip(correction).skip(GYRO_BIAS) {
            *parameter += value.wide();
        }
        false
    }

    /// Opens attitude, velocity and position so wide that the next fixes decide, and forgets the
    /// history. The estimates stay; those of the sensors' errors are as sure as at the start.
    pub(super) fn reset_covariance(&mut self) {
        self.history.clear();
        self.covariance.clear();
        self.open(ATTITUDE, [MOST_HIDDEN_RAD; 3]);
        self.open(VELOCITY, [RESET_VELOCITY_MPS; 3]);
        self.open(POSITION, [RESET_POSITION_M; 3]);
        self.open(GYRO_BIAS, [self.config.imu.gyro_bias_sigma_radps; 3]);
        self.open(ACCEL_BIAS, [self.config.imu.accel_bias_sigma_mps2; 3]);
        self.open_blocks();
        self.gps_wander = None;
    }

    /// Opens the heading to at least `sigma_rad`.
    pub(super) fn open_heading(&mut self, sigma_rad: f64) {
        let missing = square(sigma_rad) - self.covariance.variance(ATTITUDE + 2);
        self.covariance.add_variance(ATTITUDE + 2, missing.max(0.0));
    }
}

/// One-sigmas of velocity, m/s, and position, m, after a reset.
const RESET_VELOCITY_MPS: f64 = 50.0;
const RESET_POSITION_M: f64 = 1e4;
