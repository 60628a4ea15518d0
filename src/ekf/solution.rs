//! What the filter says: the vehicle's motion, and how sure it is of it.

use crate::earth::Geodetic;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::time::Time;

/// Position, velocity and attitude at one moment, with one-sigma and the biases removed.
///
/// Position and velocity are those of the point the configuration names: the centre of gravity, or
/// the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// The inertial sample it holds at.
    pub time: Time,
    /// Where the point is.
    pub position: Geodetic,
    /// The point's velocity over ground, m/s.
    pub velocity_mps: Vector<Ned>,
    /// Attitude.
    pub body_to_ned: Rotation<Body, Ned>,
    /// Angular rate p, q, r of the body against the ground's axes, rad/s, less bias.
    pub angular_rate_radps: Vector<Body>,
    /// One-sigma of position, m.
    pub position_sigma_m: Vector<Ned>,
    /// One-sigma of velocity, m/s.
    pub velocity_sigma_mps: Vector<Ned>,
    /// One-sigma of roll, pitch and yaw, rad.
    pub attitude_sigma_rad: [f64; 3],
    /// Gyro bias removed, rad/s.
    pub gyro_bias_radps: Vector<Body>,
    /// Accelerometer bias removed, m/s².
    pub accel_bias_mps2: Vector<Body>,
    /// One-sigma of the gyro bias, rad/s.
    pub gyro_bias_sigma_radps: Vector<Body>,
    /// One-sigma of the accelerometer bias, m/s².
    pub accel_bias_sigma_mps2: Vector<Body>,
}

impl Solution {
    /// u, v, w: the point's velocity in body axes, m/s.
    #[must_use]
    pub fn velocity_body_mps(&self) -> Vector<Body> {
        self.body_to_ned.inverse() * self.velocity_mps
    }
}
