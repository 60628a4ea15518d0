//! The error model of the inertial unit: biases and scale factors.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// Known errors of the inertial unit: measured = (1 + scale) true + bias.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuErrors<T = f64> {
    /// Gyro bias, rad/s.
    pub gyro_bias_radps: Vector<Body, T>,
    /// Accelerometer bias, m/s².
    pub accel_bias_mps2: Vector<Body, T>,
    /// Gyro scale factor errors, one per axis, without unit.
    pub gyro_scale: [T; 3],
    /// Accelerometer scale factor errors, one per axis, without unit.
    pub accel_scale: [T; 3],
}

impl<T: Scalar> ImuErrors<T> {
    /// The true angular rate (`duration_s` = 1) or its integral over `duration_s`.
    #[must_use]
    pub fn rate(&self, measured: Vector<Body, T>, duration_s: T) -> Vector<Body, T> {
        unscaled(measured - self.gyro_bias_radps * duration_s, self.gyro_scale)
    }

    /// The true specific force (`duration_s` = 1) or its integral over `duration_s`.
    #[must_use]
    pub fn force(&self, measured: Vector<Body, T>, duration_s: T) -> Vector<Body, T> {
        unscaled(measured - self.accel_bias_mps2 * duration_s, self.accel_scale)
    }
}

/// Equation (S1) of docs/equations.md.
fn unscaled<T: Scalar>(vector: Vector<Body, T>, scale: [T; 3]) -> Vector<Body, T> {
    let ([x, y, z], [sx, sy, sz]) = (vector.to_array(), scale);
    Vector::new(x * (T::ONE - sx), y * (T::ONE - sy), z * (T::ONE - sz))
}
