//! The error model of the inertial unit: biases.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// Known errors of the inertial unit: measured = true + bias.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuErrors<T = f64> {
    /// Gyro bias, rad/s.
    pub gyro_bias_radps: Vector<Body, T>,
    /// Accelerometer bias, m/s².
    pub accel_bias_mps2: Vector<Body, T>,
}

impl<T: Scalar> ImuErrors<T> {
    /// The true angular rate (`duration_s` = 1) or its integral over `duration_s`.
    ///
    /// # Source
    /// Equation (S1) of docs/equations.md.
    #[must_use]
    pub fn rate(&self, measured: Vector<Body, T>, duration_s: T) -> Vector<Body, T> {
        measured - self.gyro_bias_radps * duration_s
    }

    /// The true specific force (`duration_s` = 1) or its integral over `duration_s`.
    #[must_use]
    pub fn force(&self, measured: Vector<Body, T>, duration_s: T) -> Vector<Body, T> {
        measured - self.accel_bias_mps2 * duration_s
    }
}
