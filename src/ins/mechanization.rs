//! The strapdown mechanization in north, east, down on the rotating ellipsoid.

use crate::earth::{Geodetic, LocalEarth};
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::ins::Increment;
use crate::scalar::Scalar;
use crate::time::Time;

/// Position, velocity and attitude of the inertial unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavState<T = f64> {
    /// Time of the state.
    pub time: Time,
    /// Position of the inertial unit.
    pub position: Geodetic,
    /// Velocity of the inertial unit over the ground, m/s.
    pub velocity_mps: Vector<Ned, T>,
    /// Attitude of the inertial unit.
    pub body_to_ned: Rotation<Body, Ned, T>,
}

/// Correlation time of a controlled vehicle's tilt rate, s.
const TILT_MEMORY_S: f64 = 0.3;
/// Correlation time of a controlled vehicle's turn rate about the vertical, s.
const TURN_MEMORY_S: f64 = 1.0;
/// Largest change of tilt over a gap, rad. A rate that would exceed this change is a movement about to stop, and a
/// single sample of the rate may be vibration. A state tilted past the vertical would return upside down.
const MAX_TILTED_RAD: f64 = 0.35;
/// Largest turn about the vertical over a gap, rad. A rate that would exceed this turn is a movement about to stop.
const MAX_TURNED_RAD: f64 = 1.0;

/// Upper limit of the speed, m/s: faster than any orbit.
const FASTEST_MPS: f64 = 1e4;

/// Intermediate results of one mechanization step, for the propagation of the covariance and for the filter's history.
#[derive(Clone, Copy, Debug)]
pub struct Advance<T = f64> {
    /// Direction cosines of the attitude at the start, rows north, east, down.
    pub body_to_ned_rows: [[T; 3]; 3],
    /// Velocity change by specific force alone, m/s.
    pub from_specific_force_mps: Vector<Ned, T>,
    /// Whole velocity change: specific force, gravity, Coriolis, m/s.
    pub velocity_mps: Vector<Ned, T>,
    /// Rotation of the NED axes relative to inertial space during the step, rad.
    pub frame_rotation_rad: Vector<Ned, T>,
}

impl<T: Scalar> NavState<T> {
    /// State at rest at latitude and longitude zero, level, heading north.
    pub const ORIGIN: Self = Self {
        time: Time::ZERO,
        position: Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 },
        velocity_mps: Vector::ZERO,
        body_to_ned: Rotation::IDENTITY,
    };

    /// The same state in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> NavState<U> {
        NavState {
            time: self.time,
            position: self.position,
            velocity_mps: self.velocity_mps.cast(),
            body_to_ned: self.body_to_ned.cast(),
        }
    }

    /// Carries the state over one increment that ends at `time`.
    ///
    /// Earth rate, transport rate, Coriolis and gravity are evaluated at the middle of the step. Position integrates
    /// the mean of the velocities at its ends. The position error of this rule does not grow for a trajectory of
    /// bounded jerk. It telescopes to Δt²/12 times the change of acceleration since the start.
    ///
    /// Valid where [`Geodetic::is_navigable`].
    ///
    /// # Source
    /// Groves, second edition, section 5.5 (precision local-navigation-frame equations).
    /// Equations (S6), (S7) and (S8) of docs/equations.md.
    pub fn advance(&mut self, time: Time, increment: &Increment<T>) -> Advance<T> {
        let half = T::of(0.5);
        let interval_s = increment.interval_s;
        let earth = LocalEarth::about(&self.position);
        let body_to_ned_rows = self.body_to_ned.rows();
        let force_start: Vector<Ned, T> = body_to_ned_rows
            .map(|row| Vector::<Body, T>::from(row).dot(increment.velocity_mps))
            .into();
        let start = self.velocity_mps;

        let gravity_mid =
            earth.gravity_mps2 * (T::ONE + start.z() * interval_s / earth.north_radius_m);
        let fall = Vector::new(T::ZERO, T::ZERO, gravity_mid * interval_s);
        let velocity_mid = start + (force_start + fall) * half;
        let transport = earth.transport_rate(velocity_mid);
        let frame_rotation_rad = (earth.earth_rate_radps + transport) * interval_s;
        let coriolis =
            (earth.earth_rate_radps * T::of(2.0) + transport).cross(velocity_mid) * interval_s;
        let from_specific_force_mps = force_start - frame_rotation_rad.cross(force_start) * half;
        let velocity_mps = from_specific_force_mps + fall - coriolis;

        self.velocity_mps = start + velocity_mps;
        let travel = (start + self.velocity_mps) * (half * interval_s);
        self.position = earth.carried(&self.position, travel);
        self.body_to_ned = self
            .body_to_ned
            .turned_in_from(increment.rotation_rad)
            .turned_in_to(-frame_rotation_rad)
            .renormalised();
        self.time = time;
        Advance { body_to_ned_rows, from_specific_force_mps, velocity_mps, frame_rotation_rad }
    }

    /// Carries the state over a gap in the inertial samples that ends at `time`. The velocity stays constant. The
    /// rotation continues at `angular_rate_radps` (relative to the NED axes) for the usual duration of a rate. A turn
    /// about the vertical continues for at most 1 s and 1 rad. A tilt continues for at most 0.3 s and 0.35 rad.
    ///
    /// The motion during a gap is unknown, and the rates at its ends predict it worse than rest does. A rate or force
    /// held for seconds leads to large errors.
    ///
    /// # Source
    /// Equation (S14) of docs/equations.md.
    pub fn coast(&mut self, time: Time, angular_rate_radps: Vector<Body, T>) -> Vector<Body, T> {
        let interval_s: T = time.seconds_since(self.time);
        self.position = LocalEarth::about(&self.position)
            .carried(&self.position, self.velocity_mps * interval_s);
        let lasting_s = |memory_s: f64| interval_s / (T::ONE + interval_s / T::of(memory_s));
        let rate = self.body_to_ned * angular_rate_radps;
        let tilt_s = lasting_s(TILT_MEMORY_S);
        let most = T::of(MAX_TILTED_RAD);
        let tilt_s = tilt_s * (most / (rate.x().hypot(rate.y()) * tilt_s).max(most));
        let most = T::of(MAX_TURNED_RAD);
        let turned = (rate.z() * lasting_s(TURN_MEMORY_S)).min(most).max(-most);
        let rotation = Vector::new(rate.x() * tilt_s, rate.y() * tilt_s, turned);
        let rotation_rad = self.body_to_ned.inverse() * rotation;
        self.body_to_ned = self.body_to_ned.turned_in_from(rotation_rad).renormalised();
        self.time = time;
        rotation_rad
    }

    /// Whether every value is finite, NED is defined at the position, and the speed is under 10 km/s.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.position.is_navigable()
            && self.velocity_mps.is_shorter_than(T::of(FASTEST_MPS))
            && self.body_to_ned.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_goes_on_over_a_gap_for_a_second_and_leaves_the_tilt_as_it_was() {
        let mut state = NavState::<f64>::ORIGIN;
        let banked = Vector::new(0.5, 0.0, 0.0);
        state.body_to_ned = state.body_to_ned.turned_in_from(banked);
        let rate = state.body_to_ned.inverse() * Vector::new(0.0, 0.0, 0.4);
        let before = state.body_to_ned.euler();
        state.coast(state.time.offset_by(2.0), rate);
        let after = state.body_to_ned.euler();
        assert!((after.roll_rad - before.roll_rad).abs() < 1e-9, "{after:?}");
        let turned = 0.4 * 2.0 / (1.0 + 2.0 / TURN_MEMORY_S);
        assert!((after.yaw_rad - before.yaw_rad - turned).abs() < 1e-9, "{after:?}");
    }

    #[test]
    fn no_gap_carries_a_state_past_the_vertical() {
        for rate_radps in [0.1, 1.0, 5.0, 50.0] {
            let mut state = NavState::<f64>::ORIGIN;
            let rate = Vector::new(0.0, rate_radps, 0.0);
            let turned = state.coast(state.time.offset_by(5.0), rate);
            let expected = (rate_radps * 5.0 / (1.0 + 5.0 / TILT_MEMORY_S)).min(MAX_TILTED_RAD);
            assert!((turned.y() - expected).abs() < 1e-6, "{rate_radps}: {turned:?}");
        }
    }
}
