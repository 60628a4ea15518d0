//! Flight plans: a list of legs, and the manoeuvres composed of them.

use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::frames::Vector;

use super::leg::{Leg, Level};
use super::trajectory::{Trajectory, TrajectoryError};

/// Duration of a stick movement in a test point, s.
const STICK_S: f64 = 0.5;
/// Duration of entering or leaving a turn or a climb, s.
const ENTRY_S: f64 = 2.0;

/// A flight plan: it starts in a hover, manoeuvres are appended, and it becomes a [`Trajectory`].
///
/// Every manoeuvre except [`then`](Self::then) tilts the vehicle so that the thrust is along the body's −z axis, as for
/// a helicopter. Each begins and ends smoothly.
///
/// ```
/// use hovernav::earth::Geodetic;
/// use hovernav::frames::Vector;
/// use hovernav_sim::FlightPlan;
///
/// let start = Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap();
/// let trajectory = FlightPlan::hover_at(start, 0.0)
///     .hold(10.0)
///     .accelerate(Vector::new(8.0, 0.0, 0.0), 6.0)
///     .turn(90f64.to_radians(), 20f64.to_radians())
///     .hold(5.0)
///     .build()
///     .unwrap();
/// let end = trajectory.at(trajectory.duration_s());
/// assert!((end.velocity_mps.y() - 8.0).abs() < 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FlightPlan {
    start: Geodetic,
    heading_rad: f64,
    legs: Vec<Leg>,
    speed_mps: Vector<Level>,
}

impl FlightPlan {
    /// A plan that starts level and at rest at `start`, heading `heading_rad` from true north.
    #[must_use]
    pub fn hover_at(start: Geodetic, heading_rad: f64) -> Self {
        Self { start, heading_rad, legs: Vec::new(), speed_mps: Vector::ZERO }
    }

    /// A complete flight of 300 s from a hover at `start`. It consists of the thesis's test points, climbs,
    /// accelerations, coordinated turns, and a hover at the end.
    ///
    /// # Source
    /// Test points: Paw (2005), chapter 5, doi:10.32657/10356/47095.
    #[must_use]
    pub fn test_flight(start: Geodetic, heading_rad: f64) -> Self {
        let forward = |speed_mps| Vector::new(speed_mps, 0.0, 0.0);
        let plan = Self::hover_at(start, heading_rad)
            .hold(20.0)
            .test_points()
            .climb(20.0, 2.5)
            .accelerate(forward(8.0), 6.0)
            .turn(1.5 * core::f64::consts::PI, 20f64.to_radians())
            .hold(5.0)
            .accelerate(forward(4.0), 3.0)
            .turn(-core::f64::consts::TAU, 25f64.to_radians())
            .climb(-15.0, 2.0)
            .turn(core::f64::consts::PI, 30f64.to_radians())
            .accelerate(forward(-12.0), 7.0)
            .hold(5.0)
            .accelerate(Vector::new(0.0, 3.0, 0.0), 3.0)
            .hold(4.0)
            .accelerate(Vector::new(0.0, -3.0, 0.0), 3.0)
            .turn(core::f64::consts::PI, 40f64.to_radians());
        let rest_s = 300.0 - plan.duration_s();
        plan.hold(rest_s)
    }

    /// Appends a leg.
    #[must_use]
    pub fn then(mut self, leg: Leg) -> Self {
        self.speed_mps += self.speed_gained_mps(leg.duration_s, leg.acceleration_mps2);
        self.legs.push(leg);
        self
    }

    /// Holds acceleration, yaw rate, roll and pitch.
    #[must_use]
    pub fn hold(self, duration_s: f64) -> Self {
        let leg = Leg { duration_s, ..self.last() };
        self.then(leg)
    }

    /// Changes the forward, right and down speed by `change_mps` within `duration_s`.
    #[must_use]
    pub fn accelerate(self, change_mps: Vector<Level>, duration_s: f64) -> Self {
        let yaw_rate_radps = self.last().yaw_rate_radps;
        let peak_mps2 = change_mps * (2.0 / duration_s);
        self.balanced(0.5 * duration_s, peak_mps2, yaw_rate_radps).balanced(
            0.5 * duration_s,
            Vector::ZERO,
            yaw_rate_radps,
        )
    }

    /// Climbs by `height_m` (descends where negative) at `rate_mps`, with smooth transitions of 2 s. The rate is lower
    /// where the height is too small for that.
    #[must_use]
    pub fn climb(self, height_m: f64, rate_mps: f64) -> Self {
        let (rate_mps, steady_s) = steady_part(height_m, rate_mps);
        let down = Vector::new(0.0, 0.0, -rate_mps);
        let climbing = self.accelerate(down, ENTRY_S);
        let climbing = if steady_s > 0.0 { climbing.hold(steady_s) } else { climbing };
        climbing.accelerate(-down, ENTRY_S)
    }

    /// Turns by `heading_change_rad` (right positive) at `rate_radps`, banked for the speed, with smooth transitions of
    /// 2 s. The rate is lower where the change is too small for that.
    #[must_use]
    pub fn turn(self, heading_change_rad: f64, rate_radps: f64) -> Self {
        let (rate_radps, steady_s) = steady_part(heading_change_rad, rate_radps);
        let turning = self.balanced(ENTRY_S, Vector::ZERO, rate_radps);
        let turning = if steady_s > 0.0 { turning.hold(steady_s) } else { turning };
        turning.balanced(ENTRY_S, Vector::ZERO, 0.0)
    }

    /// Rolls to `angle_rad`, holds for `held_s`, rolls to the other side in the same way, and levels out. The sideways
    /// speed follows the roll.
    #[must_use]
    pub fn roll_doublet(self, angle_rad: f64, held_s: f64) -> Self {
        let sideways_mps2 = self.gravity_mps2() * angle_rad.tan();
        self.doublet(Vector::new(0.0, sideways_mps2, 0.0), 0.0, held_s)
    }

    /// Pitches to `angle_rad`, holds for `held_s`, pitches in the other direction in the same way, and levels out. The
    /// forward speed follows the pitch.
    #[must_use]
    pub fn pitch_doublet(self, angle_rad: f64, held_s: f64) -> Self {
        let forward_mps2 = -self.gravity_mps2() * angle_rad.tan();
        self.doublet(Vector::new(forward_mps2, 0.0, 0.0), 0.0, held_s)
    }

    /// Accelerates downwards by `acceleration_mps2` for `held_s`, then upwards.
    #[must_use]
    pub fn heave_doublet(self, acceleration_mps2: f64, held_s: f64) -> Self {
        self.doublet(Vector::new(0.0, 0.0, acceleration_mps2), 0.0, held_s)
    }

    /// Yaws at `rate_radps` for `held_s`, then back.
    #[must_use]
    pub fn yaw_doublet(self, rate_radps: f64, held_s: f64) -> Self {
        self.doublet(Vector::ZERO, rate_radps, held_s)
    }

    /// Test points for the identification of the helicopter: roll and pitch, heave, and yaw. Each has steps of 1.5 s
    /// from a hover and is flown three times with pauses. Takes 102 s.
    ///
    /// # Source
    /// Paw (2005), chapter 5, doi:10.32657/10356/47095. The excursions correspond to 10 to 15 % of control: 8° of roll
    /// and pitch, 1.2 m/s² of heave, 25°/s of yaw.
    #[must_use]
    pub fn test_points(self) -> Self {
        let three_times = |mut plan: Self, manoeuvre: fn(Self) -> Self| {
            for _ in 0..3 {
                plan = manoeuvre(plan).hold(3.5);
            }
            plan
        };
        let plan = three_times(self, |plan| plan.roll_doublet(8f64.to_radians(), 1.5));
        let plan = three_times(plan, |plan| plan.pitch_doublet(8f64.to_radians(), 1.5));
        let plan = three_times(plan, |plan| plan.heave_doublet(-1.2, 1.5));
        three_times(plan, |plan| plan.yaw_doublet(25f64.to_radians(), 1.5))
    }

    /// Duration of the legs in the plan, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.legs.iter().map(|leg| leg.duration_s).sum()
    }

    /// The trajectory of this plan.
    ///
    /// # Errors
    /// [`TrajectoryError`] for a leg that cannot be flown, or a position without a north direction.
    pub fn build(&self) -> Result<Trajectory, TrajectoryError> {
        Trajectory::new(self.start, self.heading_rad, &self.legs)
    }

    fn last(&self) -> Leg {
        self.legs.last().copied().unwrap_or(Leg::STEADY)
    }

    fn gravity_mps2(&self) -> f64 {
        LocalEarth::at(&self.start).gravity_mps2
    }

    /// Change of the forward, right and down speed, m/s, while the acceleration changes smoothly. The mean acceleration
    /// is half-way between the values at the ends.
    fn speed_gained_mps(&self, duration_s: f64, acceleration_mps2: Vector<Level>) -> Vector<Level> {
        (self.last().acceleration_mps2 + acceleration_mps2) * (0.5 * duration_s)
    }

    /// A leg at whose end the thrust is along the body's −z axis.
    fn balanced(
        self,
        duration_s: f64,
        acceleration_mps2: Vector<Level>,
        yaw_rate_radps: f64,
    ) -> Self {
        let speed = self.speed_mps + self.speed_gained_mps(duration_s, acceleration_mps2);
        let centripetal = Vector::new(-speed.y(), speed.x(), 0.0) * yaw_rate_radps;
        let [forward, right, down] = (acceleration_mps2 + centripetal).to_array();
        let lift = self.gravity_mps2() - down;
        let pitch_rad = (-forward / lift).atan();
        let roll_rad = (right * pitch_rad.cos() / lift).atan();
        self.then(Leg { duration_s, acceleration_mps2, yaw_rate_radps, roll_rad, pitch_rad })
    }

    fn doublet(self, acceleration: Vector<Level>, yaw_rate_radps: f64, held_s: f64) -> Self {
        self.balanced(STICK_S, acceleration, yaw_rate_radps)
            .hold(held_s)
            .balanced(2.0 * STICK_S, -acceleration, -yaw_rate_radps)
            .hold(held_s)
            .balanced(STICK_S, Vector::ZERO, 0.0)
    }
}

/// The signed rate for `change`, and the time at this rate, s, without entry and exit. Entry and exit each cover half
/// of the change that the steady rate would cover in the same time.
fn steady_part(change: f64, rate: f64) -> (f64, f64) {
    let steady_s = (change / rate).abs() - ENTRY_S;
    if steady_s <= 0.0 { (change / ENTRY_S, 0.0) } else { (rate.abs().copysign(change), steady_s) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use hovernav::frames::wrap_angle;

    fn field() -> Geodetic {
        Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap()
    }

    fn end_of(plan: &FlightPlan) -> crate::State {
        let trajectory = plan.build().unwrap();
        trajectory.at(trajectory.duration_s())
    }

    #[test]
    fn test_points_begin_and_end_in_a_level_hover() {
        let plan = FlightPlan::hover_at(field(), 0.3).test_points();
        assert_abs_diff_eq!(plan.duration_s(), 102.0, epsilon = 1e-9);
        let end = end_of(&plan);
        assert!(end.velocity_mps.norm() < 1e-12);
        assert!(end.angular_rate_radps.norm() < 1e-12);
        let angles = end.body_to_ned.euler();
        assert!(angles.roll_rad.abs() < 1e-15 && angles.pitch_rad.abs() < 1e-15);
        assert_abs_diff_eq!(angles.yaw_rad, 0.3, epsilon = 1e-12);
    }

    #[test]
    fn turns_climbs_and_accelerations_end_where_commanded() {
        for (turn_rad, rate_radps) in [(2.0, 0.3), (-3.0, 0.5), (0.2, 0.5)] {
            let plan = FlightPlan::hover_at(field(), -0.4)
                .accelerate(Vector::new(7.0, -1.0, 0.0), 4.0)
                .turn(turn_rad, rate_radps)
                .climb(-12.0, 2.0)
                .climb(3.0, 5.0);
            let end = end_of(&plan);
            let yaw = end.body_to_ned.euler().yaw_rad;
            assert!(wrap_angle(yaw - (turn_rad - 0.4)).abs() < 1e-12);
            assert_abs_diff_eq!(end.position.height_m, 41.0, epsilon = 1e-7);
            assert_abs_diff_eq!(end.velocity_mps.norm(), 50f64.sqrt(), epsilon = 1e-12);
        }
    }

    #[test]
    fn thrust_stays_along_the_body_axis() {
        let trajectory = FlightPlan::test_flight(field(), 1.0).build().unwrap();
        assert_abs_diff_eq!(trajectory.duration_s(), 300.0, epsilon = 1e-9);
        for i in 0..3000 {
            let force = trajectory.at(0.1 * f64::from(i)).specific_force_mps2;
            let sideways = force.x().hypot(force.y());
            assert!(sideways < 0.3 && force.z() < -7.0, "{force:?} at {} s", 0.1 * f64::from(i));
        }
    }
}
