//! The simulated flight is consistent: integrating its sensor data, in a separate frame and by a separate method,
//! gives its position, velocity and attitude.

use std::f64::consts::TAU;

use approx::assert_abs_diff_eq;
use hovernav::earth::{EARTH_RATE_RADPS, Geodetic, LocalEarth};
use hovernav::frames::{Body, Vector};
use hovernav::glam::{DQuat, DVec3};
use hovernav_sim::{FlightPlan, Leg, State, Trajectory, TrajectoryError};
use proptest::prelude::*;

const EARTH_RATE: DVec3 = DVec3::new(0.0, 0.0, EARTH_RATE_RADPS);

fn place(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Geodetic {
    Geodetic::from_degrees(latitude_deg, longitude_deg, height_m).unwrap()
}

/// Position, velocity and attitude in Earth-centred, Earth-fixed axes.
#[derive(Clone, Copy)]
struct InEcef {
    position: DVec3,
    velocity: DVec3,
    body_to_ecef: DQuat,
}

impl InEcef {
    fn of(state: &State) -> Self {
        let ned_to_ecef = state.position.ecef_to_ned().inverse();
        Self {
            position: state.position.to_ecef().components(),
            velocity: (ned_to_ecef * state.velocity_mps).components(),
            body_to_ecef: (ned_to_ecef * state.body_to_ned).quaternion(),
        }
    }

    /// Derivative computed from the measurements of an inertial unit at this point.
    fn derivative(&self, sensed: &State) -> Self {
        let place = Geodetic::from_ecef(Vector::claim(self.position)).unwrap();
        let down = Vector::new(0.0, 0.0, LocalEarth::at(&place).gravity_mps2);
        let gravity = (place.ecef_to_ned().inverse() * down).components();
        let force = self.body_to_ecef * sensed.specific_force_mps2.components();
        let rate = DQuat::from_vec4(sensed.inertial_rate_radps.components().extend(0.0));
        let earth = DQuat::from_vec4(EARTH_RATE.extend(0.0));
        Self {
            position: self.velocity,
            velocity: force + gravity - 2.0 * EARTH_RATE.cross(self.velocity),
            body_to_ecef: (self.body_to_ecef * rate - earth * self.body_to_ecef) * 0.5,
        }
    }

    fn moved(&self, derivative: &Self, seconds: f64) -> Self {
        Self {
            position: self.position + derivative.position * seconds,
            velocity: self.velocity + derivative.velocity * seconds,
            body_to_ecef: self.body_to_ecef + derivative.body_to_ecef * seconds,
        }
    }
}

/// Largest difference of position, velocity and attitude between the flight and an integration of inertial
/// measurements. The measurements are those at the lever arm; the integration is fourth-order Runge-Kutta.
fn closure(trajectory: &Trajectory, lever_arm: Vector<Body>, step_s: f64) -> [f64; 3] {
    let steps = (trajectory.duration_s() / step_s).floor() as u32;
    let sensed =
        |half_steps: u32| trajectory.at(0.5 * step_s * f64::from(half_steps)).at_point(lever_arm);
    let mut start = sensed(0);
    let mut found = InEcef::of(&start);
    let mut worst = [0f64; 3];
    for step in 0..steps {
        let middle = sensed(2 * step + 1);
        let end = sensed(2 * step + 2);
        let k1 = found.derivative(&start);
        let k2 = found.moved(&k1, 0.5 * step_s).derivative(&middle);
        let k3 = found.moved(&k2, 0.5 * step_s).derivative(&middle);
        let k4 = found.moved(&k3, step_s).derivative(&end);
        for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
            found = found.moved(&k, step_s * weight / 6.0);
        }
        found.body_to_ecef = found.body_to_ecef.normalize();
        start = end;

        let claimed = InEcef::of(&start);
        let turn = found.body_to_ecef.conjugate() * claimed.body_to_ecef;
        for (worst, error) in worst.iter_mut().zip([
            (found.position - claimed.position).length(),
            (found.velocity - claimed.velocity).length(),
            2.0 * turn.xyz().length(),
        ]) {
            *worst = worst.max(error);
        }
    }
    worst
}

#[test]
fn integrated_specific_force_and_rate_give_back_the_test_flight() {
    let starts = [(place(1.352, 103.82, 50.0), 1.0), (place(-79.0, 179.999_9, 300.0), -2.5)];
    for (start, heading_rad) in starts {
        let trajectory = FlightPlan::test_flight(start, heading_rad).build().unwrap();
        let [position_m, velocity_mps, attitude_rad] = closure(&trajectory, Vector::ZERO, 0.0025);
        assert!(position_m < 1e-5 && velocity_mps < 5e-9 && attitude_rad < 5e-11);
    }
}

#[test]
fn a_unit_on_a_lever_arm_feels_its_own_motion_and_gravity() {
    let start = place(48.0, 11.3, 560.0);
    let trajectory = FlightPlan::test_flight(start, 0.4).build().unwrap();
    let lever_arm = Vector::new(-0.4, 0.3, 0.5);
    let [position_m, velocity_mps, attitude_rad] = closure(&trajectory, lever_arm, 0.0025);
    assert!(position_m < 1e-5 && velocity_mps < 5e-9 && attitude_rad < 5e-11);
}

prop_compose! {
    fn some_leg()(
        duration_s in 0.5..3.0, forward in -3.0..3.0, right in -3.0..3.0, down in -3.0..3.0,
        yaw_rate_radps in -1.0..1.0, roll_rad in -2.0..2.0, pitch_rad in -1.0..1.0,
    ) -> Leg {
        let acceleration_mps2 = Vector::new(forward, right, down);
        Leg { duration_s, acceleration_mps2, yaw_rate_radps, roll_rad, pitch_rad }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn any_legs_anywhere_make_one_motion(
        latitude_deg in -85.0..85.0, longitude_deg in -180.0..180.0, heading_rad in -3.0..3.0,
        legs in prop::collection::vec(some_leg(), 1..4), x in -1.0..1.0, z in -1.0..1.0,
    ) {
        let hover = FlightPlan::hover_at(place(latitude_deg, longitude_deg, 100.0), heading_rad);
        let trajectory = legs.into_iter().fold(hover, FlightPlan::then).build().unwrap();
        let [position_m, velocity_mps, attitude_rad] =
            closure(&trajectory, Vector::new(x, 0.2, z), 0.001);
        prop_assert!(position_m < 5e-6 && velocity_mps < 2e-8 && attitude_rad < 1e-9);
    }
}

#[test]
fn increments_are_the_integrals_of_what_is_sensed() {
    let trajectory = FlightPlan::test_flight(place(1.352, 103.82, 50.0), 1.0).build().unwrap();
    let lever_arm = Vector::new(0.03, -0.02, 0.28);
    for (rate_hz, samples) in [(33, 9900), (100, 30_000)] {
        let mut worst = [0f64; 2];
        for sample in 0..samples {
            let [from_s, to_s] = [sample, sample + 1].map(|k| f64::from(k) / f64::from(rate_hz));
            let (angle, velocity) = trajectory.increments(from_s, to_s, lever_arm);
            let step_s = (to_s - from_s) / 32.0;
            let mut simpson: [Vector<Body>; 2] = [Vector::ZERO; 2];
            for k in 0..=32 {
                let weight = if k % 32 == 0 { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
                let state = trajectory.at(from_s + f64::from(k) * step_s).at_point(lever_arm);
                simpson[0] += state.inertial_rate_radps * (weight * step_s / 3.0);
                simpson[1] += state.specific_force_mps2 * (weight * step_s / 3.0);
            }
            worst[0] = worst[0].max((angle - simpson[0]).norm());
            worst[1] = worst[1].max((velocity - simpson[1]).norm());
        }
        // Error of Simpson's rule.
        let bound = 1e-10 * (33.0 / f64::from(rate_hz)).powi(5);
        assert!(worst[0] < bound && worst[1] < bound, "{worst:?} at {rate_hz} Hz");
    }
}

#[test]
fn increments_over_a_long_time_are_the_sum_of_those_over_short_ones() {
    let trajectory = FlightPlan::test_flight(place(1.352, 103.82, 50.0), 1.0).build().unwrap();
    let lever_arm = Vector::new(0.03, -0.02, 0.28);
    for start_s in [-0.5, 19.9, 100.0, 180.3, 299.5] {
        let mut sum: [Vector<Body>; 2] = [Vector::ZERO; 2];
        for k in 0..100 {
            let from_s = start_s + f64::from(k) * 0.01;
            let (angle, velocity) = trajectory.increments(from_s, from_s + 0.01, lever_arm);
            sum[0] += angle;
            sum[1] += velocity;
        }
        let (angle, velocity) = trajectory.increments(start_s, start_s + 1.0, lever_arm);
        let errors = [(angle - sum[0]).norm(), (velocity - sum[1]).norm()];
        assert!(errors[0] < 1e-12 && errors[1] < 1e-11, "{errors:?}");
    }
}

#[test]
fn angular_rate_is_the_motion_of_the_attitude() {
    let trajectory = FlightPlan::test_flight(place(60.0, 25.0, 50.0), 1.0).build().unwrap();
    for lever_arm in [Vector::ZERO, Vector::new(-0.35, 0.0, 0.2)] {
        for time_s in (0..2990).map(|k| 0.1 * f64::from(k)) {
            let half_s = 1e-3;
            let [before, at, after] = [time_s - half_s, time_s, time_s + half_s]
                .map(|time_s| trajectory.at(time_s.max(0.0)).at_point(lever_arm));
            if time_s > 0.0 {
                let turn = before.body_to_ned.inverse() * after.body_to_ned;
                let rate: Vector<Body> = Vector::claim(turn.quaternion().xyz() / half_s);
                assert!((rate - at.angular_rate_radps).norm() < 1e-5);
            }
        }
    }
}

#[test]
fn a_hover_senses_gravity_and_the_rotation_of_the_earth() {
    let field = place(45.0, 7.0, 300.0);
    let plan = FlightPlan::hover_at(field, 90f64.to_radians());
    for trajectory in [plan.build().unwrap(), plan.hold(60.0).build().unwrap()] {
        let state = trajectory.at(17.0);
        let local = LocalEarth::at(&field);
        assert_abs_diff_eq!(state.specific_force_mps2.z(), -local.gravity_mps2, epsilon = 1e-15);
        // The nose points east: north is to the left.
        let half = EARTH_RATE_RADPS * 0.5f64.sqrt();
        let expected = Vector::new(0.0, -half, -half);
        assert!((state.inertial_rate_radps - expected).norm() < 1e-19);
        assert!(state.angular_rate_radps.norm() == 0.0 && state.velocity_mps.norm() == 0.0);
        assert!((state.position.to_ecef() - field.to_ecef()).norm() < 2e-9);
    }
}

#[test]
fn a_steady_turn_is_a_circle() {
    let (speed_mps, rate_radps) = (8.0, 0.4);
    let trajectory = FlightPlan::hover_at(place(1.352, 103.82, 50.0), 0.0)
        .accelerate(Vector::new(speed_mps, 0.0, 0.0), 6.0)
        .turn(4.0 * TAU, rate_radps)
        .build()
        .unwrap();
    let [start, later] = [20.0, 20.0 + TAU / rate_radps].map(|time_s| trajectory.at(time_s));
    assert!(later.position.displacement_from(&start.position).norm() < 1e-4);
    let opposite = trajectory.at(20.0 + 0.5 * TAU / rate_radps);
    let diameter_m = opposite.position.displacement_from(&start.position).norm();
    assert_abs_diff_eq!(diameter_m, 2.0 * speed_mps / rate_radps, epsilon = 1e-4);
    // The vehicle is banked so that the thrust gives the turn, tan(roll) = V r / g, and the sideways force is zero.
    let roll_rad = start.body_to_ned.euler().roll_rad;
    assert_abs_diff_eq!(roll_rad, (speed_mps * rate_radps / 9.78f64).atan(), epsilon = 1e-3);
    assert!(start.specific_force_mps2.y().abs() < 1e-2);
}

#[test]
fn a_plan_that_cannot_be_flown_says_why() {
    let field = place(1.352, 103.82, 50.0);
    let hover = || FlightPlan::hover_at(field, 0.0).hold(1.0);
    for plan in [
        hover().hold(0.0),
        hover().hold(-1.0),
        hover().hold(f64::NAN),
        hover().hold(f64::INFINITY),
        hover().turn(1.0, f64::NAN),
        hover().accelerate(Vector::new(f64::NAN, 0.0, 0.0), 1.0),
        hover().accelerate(Vector::new(1.0, 0.0, 0.0), 0.0),
        hover().pitch_doublet(1.56, 1.0),
    ] {
        let found = plan.build().unwrap_err();
        assert!(matches!(found, TrajectoryError::Leg { index: 1, .. }), "{found}");
    }
    assert_eq!(hover().hold(2e4).build().unwrap_err(), TrajectoryError::TooLong(20_001.0));
    let beside_the_pole = place(89.899, 0.0, 0.0);
    let astray = FlightPlan::hover_at(beside_the_pole, 0.0)
        .accelerate(Vector::new(30.0, 0.0, 0.0), 5.0)
        .hold(10.0)
        .build()
        .unwrap_err();
    assert!(matches!(astray, TrajectoryError::NotNavigable { .. }), "{astray}");
    let pole = place(90.0, 0.0, 0.0);
    let found = FlightPlan::hover_at(pole, 0.0).build().unwrap_err();
    assert_eq!(found, TrajectoryError::Start(pole));
    let found = FlightPlan::hover_at(field, f64::INFINITY).build().unwrap_err();
    assert_eq!(found, TrajectoryError::Heading(f64::INFINITY));
}
