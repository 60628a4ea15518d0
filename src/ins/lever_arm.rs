//! Lever arms from the inertial unit to the centre of gravity and the antenna.
//!
//! An IMU at r from the centre of gravity measures a + ω̇×r + ω×(ω×r): equation 4.1 of Paw 2005. The program of that
//! thesis kept only ω̇×r, and only for r along z. Differentiating a vibrating gyro for ω̇ multiplies its noise by the
//! sample rate. Navigation therefore follows the *inertial unit*, whose velocity needs no ω̇. The result is moved to
//! another point by ω×r, the exact integral of the two acceleration terms. Vibration then enters by its rate, not by
//! its derivative: 0.02 rad/s over 0.28 m is 6 mm/s.
//! Identification needs the acceleration of the centre of gravity itself. [`AngularAcceleration`] gives ω̇ for it by a
//! least-squares slope over a short window. Its noise gain falls with the window's length to the power 3/2.

use crate::earth::Geodetic;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

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

/// Angular acceleration as the least-squares slope of the last `W` angular rates.
///
/// White rate noise of σ at interval Δt gives a slope noise of σ √(12 / (W (W² − 1))) / Δt. For the nine samples suited
/// to 33 Hz that is 0.13 σ/Δt, against 1.41 σ/Δt for a difference of neighbours. The slope is valid for the middle of
/// the window, (W − 1)/2 samples ago.
#[derive(Clone, Copy, Debug)]
pub struct AngularAcceleration<const W: usize> {
    samples: [(Time, Vector<Body>); W],
    filled: usize,
}

impl<const W: usize> Default for AngularAcceleration<W> {
    fn default() -> Self {
        Self { samples: [(Time::ZERO, Vector::ZERO); W], filled: 0 }
    }
}

impl<const W: usize> AngularAcceleration<W> {
    /// Feeds the next angular rate, rad/s, and returns the slope, rad/s², once the window is full. Ignores a rate that
    /// is not finite or not later than the previous one. After a gap above one second the window starts empty.
    pub fn push(&mut self, time: Time, angular_rate_radps: Vector<Body>) -> Option<Vector<Body>> {
        let newest = self.samples.last().map_or(Time::ZERO, |&(time, _)| time);
        if !angular_rate_radps.is_finite() || (self.filled > 0 && time <= newest) {
            return None;
        }
        if self.filled > 0 && time - newest > 1.0 {
            self.filled = 0;
        }
        self.samples.rotate_left(1.min(W));
        if let Some(last) = self.samples.last_mut() {
            *last = (time, angular_rate_radps);
        }
        self.filled = W.min(self.filled + 1);
        (self.filled == W && W > 1).then(|| self.slope(time))
    }

    /// Equation (S11) of docs/equations.md.
    fn slope(&self, newest: Time) -> Vector<Body> {
        let count = W as f64;
        let mean_s = self.samples.iter().map(|&(time, _)| time - newest).sum::<f64>() / count;
        let mut square = 0.0;
        let mut product = Vector::ZERO;
        for &(time, rate) in &self.samples {
            let lag_s = time - newest - mean_s;
            square += lag_s * lag_s;
            product += rate * lag_s;
        }
        product * (1.0 / square)
    }
}
