//! Motion of one point of a rigid vehicle, and of its other points.

use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::ekf::Solution;
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::time::Time;
use hovernav_dataset::Truth;

/// Motion of one point of the vehicle at one time.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// Position of the point.
    pub position: Geodetic,
    /// Velocity of the point over the Earth, m/s.
    pub velocity_mps: Vector<Ned>,
    /// Attitude with respect to the north, east and down of the point.
    pub body_to_ned: Rotation<Body, Ned>,
    /// Angular rate of the body with respect to the point's NED axes, rad/s.
    pub angular_rate_radps: Vector<Body>,
    /// Angular rate of the body with respect to inertial space, rad/s, as gyros measure it.
    pub inertial_rate_radps: Vector<Body>,
    /// Rate of change of [`inertial_rate_radps`](Self::inertial_rate_radps), rad/s².
    pub angular_acceleration_radps2: Vector<Body>,
    /// Acceleration of the point minus gravitation, m/s², as accelerometers there measure it.
    pub specific_force_mps2: Vector<Body>,
    /// Gravity, radii and rotation of the Earth at [`position`](Self::position).
    pub(super) local: LocalEarth,
}

impl State {
    /// The truth of this point at `time`.
    #[must_use]
    pub fn truth(&self, time: Time) -> Truth {
        Truth {
            time,
            position: self.position,
            velocity_mps: self.velocity_mps,
            body_to_ned: self.body_to_ned,
            angular_rate_radps: self.angular_rate_radps,
        }
    }

    /// A solution equal to the truth at `time`, without error or uncertainty.
    #[must_use]
    pub fn solution(&self, time: Time) -> Solution {
        Solution {
            velocity_mps: self.velocity_mps,
            body_to_ned: self.body_to_ned,
            angular_rate_radps: self.angular_rate_radps,
            ..Solution::at_rest(time, self.position)
        }
    }

    /// The motion of the point at `lever_arm_m` from this point.
    ///
    /// The result is exact for a rigid body, except for rounding and the square of the lever arm over the Earth's
    /// radius (a relative 1e-7 at 1 m). The new point has its own height, gravity and north, east and down; its
    /// velocity and attitude are given in these axes. Specific force is equation 4.1 of Paw (2005),
    /// doi:10.32657/10356/47095, plus the difference in gravitation.
    #[must_use]
    pub fn at_point(&self, lever_arm_m: Vector<Body>) -> Self {
        let offset_m = self.body_to_ned * lever_arm_m;
        let frame_turn_rad = self.local.transport_rate(offset_m);
        let position = self.local.displaced(&self.position, offset_m);
        let local = LocalEarth::at(&position);

        let ned_to_body = self.body_to_ned.inverse();
        let rate_over_earth = self.inertial_rate_radps - ned_to_body * self.local.earth_rate_radps;
        let velocity = self.velocity_mps + self.body_to_ned * rate_over_earth.cross(lever_arm_m);
        let velocity_mps = velocity - frame_turn_rad.cross(velocity);
        let body_to_ned = self.body_to_ned.turned_in_to(-frame_turn_rad);
        let frame_rate = local.earth_rate_radps + local.transport_rate(velocity_mps);
        Self {
            position,
            velocity_mps,
            body_to_ned,
            angular_rate_radps: self.inertial_rate_radps - body_to_ned.inverse() * frame_rate,
            specific_force_mps2: self.specific_force_at(lever_arm_m),
            local,
            ..*self
        }
    }

    /// Specific force at `lever_arm_m` from this point, m/s², as accelerometers there measure it.
    #[must_use]
    pub fn specific_force_at(&self, lever_arm_m: Vector<Body>) -> Vector<Body> {
        self.steady_specific_force(lever_arm_m)
            + self.angular_acceleration_radps2.cross(lever_arm_m)
    }

    /// Specific force at a lever arm without the term of the angular acceleration, whose integral needs no quadrature.
    pub(super) fn steady_specific_force(&self, lever_arm_m: Vector<Body>) -> Vector<Body> {
        if lever_arm_m == Vector::ZERO {
            return self.specific_force_mps2;
        }
        let rate = self.inertial_rate_radps;
        let offset_m = self.body_to_ned * lever_arm_m;
        let there = LocalEarth::at(&self.local.displaced(&self.position, offset_m));
        let down_here: Vector<Ned> = Vector::new(0.0, 0.0, 1.0);
        let down_there = down_here + self.local.transport_rate(offset_m).cross(down_here);
        let gravity_more = down_there * there.gravity_mps2 - down_here * self.local.gravity_mps2;
        // Gravity includes the centrifugal acceleration of the Earth's rotation; gravitation does not.
        let earth_rate = self.local.earth_rate_radps;
        let gravitation_more = gravity_more + earth_rate.cross(earth_rate.cross(offset_m));
        self.specific_force_mps2 + rate.cross(rate.cross(lever_arm_m))
            - self.body_to_ned.inverse() * gravitation_more
    }
}
