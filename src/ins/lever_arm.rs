//! Lever arms from the inertial unit to the centre of gravity and the antenna.
//!
//! An IMU at r from the centre of gravity measures a + ω̇×r + ω×(ω×r): equation 4.1 of Paw 2005. The program of that
//! thesis kept only ω̇×r, and only for r along z. Differentiating a vibrating gyro for ω̇ multiplies its noise by the
//! sample rate. Navigation therefore follows the *inertial unit*, whose velocity needs no ω̇. The result is moved to
//! another point by ω×r, the exact integral of the two acceleration terms. Vibration then enters by its rate, not by
//! its derivative: 0.02 rad/s over 0.28 m is 6 mm/s.

use crate::earth::Geodetic;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::scalar::Scalar;

/// A displacement from the inertial unit to another point fixed in the body, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeverArm<T = f64>(pub Vector<Body, T>);

impl<T: Scalar> LeverArm<T> {
    /// The same lever arm in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> LeverArm<U> {
        LeverArm(self.0.cast())
    }

    /// The point's position, given the inertial unit's position and attitude.
    ///
    /// # Source
    /// Equation (S9) of docs/equations.md.
    #[must_use]
    pub fn position(&self, unit: &Geodetic, body_to_ned: Rotation<Body, Ned, T>) -> Geodetic {
        unit.displaced(body_to_ned * self.0)
    }

    /// The point's velocity, m/s, given the inertial unit's velocity and the angular rate of the body relative to the
    /// NED axes, rad/s.
    #[must_use]
    pub fn velocity(
        &self,
        unit_mps: Vector<Ned, T>,
        body_to_ned: Rotation<Body, Ned, T>,
        angular_rate_radps: Vector<Body, T>,
    ) -> Vector<Ned, T> {
        unit_mps + body_to_ned * self.relative_velocity(angular_rate_radps)
    }

    /// The point's velocity relative to the inertial unit, ω × ℓ, body axes, m/s.
    #[must_use]
    pub fn relative_velocity(&self, angular_rate_radps: Vector<Body, T>) -> Vector<Body, T> {
        angular_rate_radps.cross(self.0)
    }

    /// The specific force at the point, m/s², from that at the inertial unit: f + ω̇×ℓ + ω×(ω×ℓ).
    ///
    /// ℓ points from the inertial unit to the point. The r of equation 4.1 has the opposite direction, ℓ = −r.
    ///
    /// # Source
    /// Equation (S10) of docs/equations.md.
    #[must_use]
    pub fn specific_force(
        &self,
        unit_mps2: Vector<Body, T>,
        angular_rate_radps: Vector<Body, T>,
        angular_acceleration_radps2: Vector<Body, T>,
    ) -> Vector<Body, T> {
        unit_mps2
            + angular_acceleration_radps2.cross(self.0)
            + angular_rate_radps.cross(self.relative_velocity(angular_rate_radps))
    }
}
