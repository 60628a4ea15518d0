//! The error model of the unit: biases and scale factors.

use crate::frames::{Body, Vector};

/// What is wrong with the unit, as far as it is known: measured = (1 + scale) true + bias.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuErrors {
    /// Gyro bias, rad/s.
    pub gyro_bias_radps: Vector<Body>,
    /// Accelerometer bias, m/s².
    pub accel_bias_mps2: Vector<Body>,
    /// Gyro scale factor errors, one per axis, without unit.
    pub gyro_scale: [f64; 3],
    /// Accelerometer scale factor errors, one per axis, without unit.
    pub accel_scale: [f64; 3],
}

impl ImuErrors {
    /// The true angular rate (`duration_s` = 1) or its integral over `duration_s`.
    #[must_use]
    pub fn rate(&self, measured: Vector<Body>, duration_s: f64) -> Vector<Body> {
        unscaled(measured - self.gyro_bias_radps * duration_s, self.gyro_scale)
    }

    /// The true specific force (`duration_s` = 1) or its integral over `duration_s`.
    #[must_use]
    pub fn force(&self, measured: Vector<Body>, duration_s: f64) -> Vector<Body> {
        unscaled(measured - self.accel_bias_mps2 * duration_s, self.accel_scale)
    }
}

/// Equation (S1) of docs/equations.md.
fn unscaled(vector: Vector<Body>, scale: [f64; 3]) -> Vector<Body> {
    let ([x, y, z], [sx, sy, sz]) = (vector.to_array(), scale);
    Vector::new(x * (1.0 - sx), y * (1.0 - sy), z * (1.0 - sz))
}
