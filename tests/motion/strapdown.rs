//! Without noise, the strapdown mechanization alone follows the truth: the test flight of the simulation, and motions
//! with a closed-form solution.

use approx::assert_abs_diff_eq;
use hovernav::earth::{EARTH_RATE_RADPS, Geodetic, LocalEarth};
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::imu::{ImuErrors, ImuSample, Motion};
use hovernav::ins::{Integrator, LeverArm, NavState};
use hovernav::time::Time;
use hovernav_sim::{DmuConfig, DmuOutput, FlightPlan, GpsConfig, Trajectory, fly};

const LEVER_ARM_M: Vector<Body> = Vector::new(0.03, -0.02, 0.28);

fn field() -> Geodetic {
    Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap()
}

fn test_flight() -> Trajectory {
    FlightPlan::test_flight(field(), 0.7).build().unwrap()
}

fn sample(time: Time, motion: Motion) -> ImuSample {
    ImuSample::new(time, motion)
}

fn rates(angular_rate_radps: Vector<Body>, specific_force_mps2: Vector<Body>) -> Motion {
    Motion::Rates { angular_rate_radps, specific_force_mps2 }
}

fn angle_between(a: Rotation<Body, Ned>, b: Rotation<Body, Ned>) -> f64 {
    (a * b.inverse()).rotation_vector().norm()
}

/// An inertial navigator alone.
struct Ins {
    state: NavState,
    integrator: Integrator,
}

impl Ins {
    fn new(
        position: Geodetic,
        velocity_mps: Vector<Ned>,
        body_to_ned: Rotation<Body, Ned>,
    ) -> Self {
        let state = NavState { time: Time::ZERO, position, velocity_mps, body_to_ned };
        Self { state, integrator: Integrator::default() }
    }

    fn push(&mut self, sample: &ImuSample) {
        if let Some(increment) = self.integrator.push(sample, &ImuErrors::default()) {
            self.state.advance(sample.time, &increment);
        }
    }
}

/// Largest errors of position, m, velocity, m/s, and attitude, rad, of an inertial unit flown on `trajectory`, compared
/// with the unit's own truth.
fn worst_errors(trajectory: &Trajectory, dmu: &DmuConfig) -> [f64; 3] {
    let recording = fly(trajectory, dmu, &GpsConfig::ideal(1.0), 1).unwrap();
    let start = trajectory.at(0.0).at_point(dmu.lever_arm_m);
    let mut ins = Ins::new(start.position, start.velocity_mps, start.body_to_ned);
    let mut worst = [0.0; 3];
    for sample in &recording.imu {
        ins.push(sample);
        let truth = trajectory.at(sample.time.seconds()).at_point(dmu.lever_arm_m);
        let errors = [
            ins.state.position.displacement_from(&truth.position).norm(),
            (ins.state.velocity_mps - truth.velocity_mps).norm(),
            angle_between(ins.state.body_to_ned, truth.body_to_ned),
        ];
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = f64::max(*worst, error);
        }
    }
    println!("{:?} at {} Hz: {worst:?}", dmu.output, dmu.rate_hz);
    worst
}

#[test]
fn increments_of_the_test_flight_are_followed_to_a_millimetre_and_a_microradian() {
    for lever_arm_m in [Vector::ZERO, LEVER_ARM_M] {
        let dmu = DmuConfig { lever_arm_m, ..DmuConfig::ideal(100.0, DmuOutput::Increments) };
        let [position_m, velocity_mps, attitude_rad] = worst_errors(&test_flight(), &dmu);
        assert!(position_m < 1e-3);
        assert!(velocity_mps < 2e-5);
        assert!(attitude_rad < 1e-7);
    }
}

#[test]
fn the_error_falls_with_the_cube_of_the_interval_for_increments_and_its_square_for_rates() {
    let trajectory = test_flight();
    for (output, order) in [(DmuOutput::Increments, 3), (DmuOutput::Rates, 2)] {
        let [coarse, fine] =
            [100.0, 200.0].map(|hz| worst_errors(&trajectory, &DmuConfig::ideal(hz, output)));
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            let ratio = coarse / fine;
            assert!((ratio / f64::from(1 << order) - 1.0).abs() < 0.1, "{output:?}: {ratio}");
        }
    }
}

/// Residual error of one interval of coning or sculling, at λ = ΩΔt, in units of the product of the amplitudes: λ⁵/60
/// and higher. It is the true term ½ (λ − sin λ) minus the term from the increments of this interval and the previous
/// one, ⅓ sin² ½λ sin λ. The first interval has no previous one, and keeps the full ½ (λ − sin λ).
fn left_of_two_samples(lambda: f64) -> f64 {
    0.5 * (lambda - lambda.sin()) - (0.5 * lambda).sin().powi(2) * lambda.sin() / 3.0
}

const PERIOD_S: f64 = 0.01;

fn moments(seconds: u32) -> impl Iterator<Item = (Time, f64, f64)> {
    (0..=100 * seconds).map(|k| {
        let end_s = f64::from(k) * PERIOD_S;
        (Time::ZERO + end_s, end_s - PERIOD_S, end_s)
    })
}

#[test]
fn coning_motion_drifts_by_the_two_sample_bound_and_no_more() {
    let half_angle = 1f64.to_radians();
    for hz in [2.0, 5.0, 10.0] {
        let omega = core::f64::consts::TAU * hz;
        // The rotation axis circles in y and z; the body turns back about x.
        let attitude = |t: f64| -> Rotation<Body, Ned> {
            let axis = Vector::<Ned>::new(0.0, (omega * t).cos(), (omega * t).sin());
            Rotation::IDENTITY.turned_in_to(axis * half_angle)
        };
        let mut integrator = Integrator::default();
        let mut found = attitude(0.0);
        for (time, from_s, to_s) in moments(20) {
            let (sine, cosine) = (
                (omega * to_s).sin() - (omega * from_s).sin(),
                (omega * to_s).cos() - (omega * from_s).cos(),
            );
            let back = -omega * PERIOD_S * 2.0 * (0.5 * half_angle).sin().powi(2);
            let angle_rad = Vector::new(back, half_angle.sin() * cosine, half_angle.sin() * sine);
            let motion = Motion::Increments { angle_rad, velocity_mps: Vector::ZERO };
            if let Some(increment) = integrator.push(&sample(time, motion), &ImuErrors::default()) {
                found = found.turned_in_from(increment.rotation_rad);
            }
        }
        let drift_radps = angle_between(found, attitude(20.0)) / 20.0;
        let lambda = omega * PERIOD_S;
        let bound_radps = half_angle * half_angle * left_of_two_samples(lambda) / PERIOD_S;
        let first_radps = half_angle * half_angle * 0.5 * (lambda - lambda.sin()) / 20.0;
        println!("coning at {hz} Hz: {drift_radps:e} rad/s, bound {bound_radps:e} rad/s");
        assert!(drift_radps < 1.02 * bound_radps + first_radps);
    }
}

#[test]
fn sculling_motion_drifts_by_the_two_sample_bound_and_no_more() {
    let (angle, acceleration_mps2) = (0.02, 5.0);
    for hz in [2.0, 5.0, 10.0] {
        let omega = core::f64::consts::TAU * hz;
        let mut integrator = Integrator::default();
        let mut attitude: Rotation<Body, Ned> = Rotation::IDENTITY;
        let mut velocity_mps = Vector::<Ned>::ZERO;
        for (time, from_s, to_s) in moments(20) {
            let turn = angle * ((omega * to_s).sin() - (omega * from_s).sin());
            let push = -acceleration_mps2 / omega * ((omega * to_s).cos() - (omega * from_s).cos());
            let motion = Motion::Increments {
                angle_rad: Vector::new(turn, 0.0, 0.0),
                velocity_mps: Vector::new(0.0, push, 0.0),
            };
            if let Some(increment) = integrator.push(&sample(time, motion), &ImuErrors::default()) {
                velocity_mps += attitude * increment.velocity_mps;
                attitude = attitude.turned_in_from(increment.rotation_rad);
            }
        }
        // The mean of A sin Ωt sin(θ sin Ωt) is A J₁(θ).
        let drift_mps2 = velocity_mps.z() / 20.0 - acceleration_mps2 * libm::j1(angle);
        let lambda = omega * PERIOD_S;
        let bound_mps2 = acceleration_mps2 * angle * left_of_two_samples(lambda) / lambda;
        let first_mps2 = acceleration_mps2 * angle * 0.5 * (lambda - lambda.sin()) / omega / 20.0;
        println!("sculling at {hz} Hz: {drift_mps2:e} m/s², bound {bound_mps2:e} m/s²");
        assert!(drift_mps2.abs() < 1.02 * bound_mps2 + first_mps2);
    }
}

#[test]
fn at_rest_on_the_rotating_earth_nothing_drifts_for_an_hour() {
    let place = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
    let attitude = Rotation::from_euler(EulerAngles::from_degrees(5.0, -3.0, 130.0));
    let earth = LocalEarth::at(&place);
    let rate = attitude.inverse() * earth.earth_rate_radps;
    let force = attitude.inverse() * Vector::new(0.0, 0.0, -earth.gravity_mps2);
    for increments in [false, true] {
        let motion = if increments {
            Motion::Increments { angle_rad: rate * PERIOD_S, velocity_mps: force * PERIOD_S }
        } else {
            rates(rate, force)
        };
        let mut ins = Ins::new(place, Vector::ZERO, attitude);
        for (time, ..) in moments(3600) {
            ins.push(&sample(time, motion));
        }
        let off_m = ins.state.position.displacement_from(&place).norm();
        let off_rad = angle_between(ins.state.body_to_ned, attitude);
        println!("at rest: {off_m:e} m, {off_rad:e} rad");
        // The bound is one rounding per step in the same direction, 360 000 × 1e-16 rad, and this angle times the
        // Earth's radius.
        assert!(off_m < 5e-4);
        assert!(off_rad < 1e-10);
    }
}

#[test]
fn a_velocity_error_swings_with_the_schuler_period() {
    let place = Geodetic::from_degrees(0.0, 20.0, 0.0).unwrap();
    let earth = LocalEarth::at(&place);
    let motion = rates(
        Vector::claim(earth.earth_rate_radps.components()),
        Vector::new(0.0, 0.0, -earth.gravity_mps2),
    );
    let error_mps = 0.1;
    let mut ins = Ins::new(place, Vector::new(error_mps, 0.0, 0.0), Rotation::IDENTITY);
    let schuler_radps = (earth.gravity_mps2 / earth.north_radius_m).sqrt();
    for (time, _, now_s) in moments(3600) {
        ins.push(&sample(time, motion));
        let expected_m = error_mps * (schuler_radps * now_s).sin() / schuler_radps;
        let north_m = ins.state.position.displacement_from(&place).x();
        assert!((north_m - expected_m).abs() < 0.5, "{north_m} m at {now_s} s, not {expected_m}");
    }
}

#[test]
fn free_fall_is_down_with_gravity_and_east_with_coriolis() {
    let place = Geodetic::from_degrees(40.0, 8.0, 2000.0).unwrap();
    let mut ins = Ins::new(place, Vector::ZERO, Rotation::IDENTITY);
    for (time, ..) in moments(10) {
        ins.push(&sample(time, rates(Vector::ZERO, Vector::ZERO)));
    }
    let earth = LocalEarth::at(&place);
    let (gravity, time_s) = (earth.gravity_mps2, 10.0f64);
    let gradient = 2.0 * gravity / earth.north_radius_m;
    let fallen = ins.state.position.displacement_from(&place);
    let turning = EARTH_RATE_RADPS * 40f64.to_radians().cos();
    // Series of the equations of motion in time; the next terms are 1e-5 m.
    let down_m = 0.5 * gravity * time_s.powi(2)
        + (gradient - 4.0 * turning * turning) * gravity * time_s.powi(4) / 24.0;
    let east_m = turning * gravity * time_s.powi(3) / 3.0;
    assert_abs_diff_eq!(fallen.z(), down_m, epsilon = 1e-4);
    assert_abs_diff_eq!(fallen.y(), east_m, epsilon = 1e-4);
    // Without rotation in inertial space, the body rotates against the rotating axes of the ground.
    let turned_rad = ins.state.body_to_ned.rotation_vector() + earth.earth_rate_radps * time_s;
    assert!(turned_rad.norm() < 1e-6);
}

#[test]
fn a_cruise_along_the_equator_keeps_its_height_and_its_speed() {
    let place = Geodetic::from_degrees(0.0, 0.0, 1000.0).unwrap();
    let earth = LocalEarth::at(&place);
    for speed in [100.0, -100.0] {
        let heading = EulerAngles::from_degrees(0.0, 0.0, f64::copysign(90.0, speed));
        let attitude = Rotation::from_euler(heading);
        let turning = EARTH_RATE_RADPS + speed / earth.east_radius_m;
        // The lift is the weight minus the centripetal force of the Earth's rotation and of the vehicle's own motion
        // (Eötvös).
        let lift = earth.gravity_mps2
            - 2.0 * EARTH_RATE_RADPS * speed
            - speed * speed / earth.east_radius_m;
        let motion = rates(
            attitude.inverse() * Vector::new(turning, 0.0, 0.0),
            attitude.inverse() * Vector::new(0.0, 0.0, -lift),
        );
        let mut ins = Ins::new(place, Vector::new(0.0, speed, 0.0), attitude);
        for (time, ..) in moments(600) {
            ins.push(&sample(time, motion));
        }
        let end = Geodetic { longitude_rad: 600.0 * speed / earth.east_radius_m, ..place };
        let off_m = ins.state.position.displacement_from(&end).norm();
        println!("equator: {off_m:e} m");
        // The velocity at the middle of a step neglects Coriolis: 1e-8 m/s² over ten minutes.
        assert!(off_m < 4e-3);
        assert!((ins.state.velocity_mps - Vector::new(0.0, speed, 0.0)).norm() < 2e-5);
        assert!(angle_between(ins.state.body_to_ned, attitude) < 5e-9);
    }
}

#[test]
fn a_cruise_along_a_meridian_keeps_its_height_and_its_speed() {
    let speed = 100.0;
    let place = Geodetic::from_degrees(40.0, 8.0, 1000.0).unwrap();
    let mut ins = Ins::new(place, Vector::new(speed, 0.0, 0.0), Rotation::IDENTITY);
    let mut truth = place;
    for (time, ..) in moments(600) {
        let earth = LocalEarth::at(&truth);
        let [north, _, down] = earth.earth_rate_radps.to_array();
        let rate = Vector::new(north, -speed / earth.north_radius_m, down);
        let force = Vector::new(
            0.0,
            2.0 * down * speed,
            speed * speed / earth.north_radius_m - earth.gravity_mps2,
        );
        ins.push(&sample(time, rates(rate, force)));
        let off_m = ins.state.position.displacement_from(&truth).norm();
        assert!(off_m < 4e-3, "{off_m} m after {time}");
        // The meridian is integrated by the midpoint rule; its radius changes by a relative 1e-7 in a step.
        let half_way = truth.latitude_rad + 0.5 * PERIOD_S * speed / earth.north_radius_m;
        let radius_m = LocalEarth::at(&Geodetic { latitude_rad: half_way, ..truth }).north_radius_m;
        truth.latitude_rad += PERIOD_S * speed / radius_m;
    }
    assert!((ins.state.velocity_mps - Vector::new(speed, 0.0, 0.0)).norm() < 2e-5);
    // The mechanization uses the Earth's rate at the step's start, half a metre behind. This is an error of 6e-12
    // rad/s, 6.5e-9 rad over the flight.
    let off_rad = angle_between(ins.state.body_to_ned, Rotation::IDENTITY);
    assert!(off_rad < 7e-9, "{off_rad:e} rad");
}

#[test]
fn a_lever_arm_feels_angular_acceleration_and_rotation_as_equation_4_1_says() {
    let arm = Vector::new(0.3, 0.0, 0.28);
    let (rate, acceleration) = (Vector::new(0.0, 0.0, 2.0), Vector::new(0.0, 4.0, 5.0));
    // Worked by hand: ω̇×r = (4·0.28, 5·0.3, −4·0.3), ω×(ω×r) = (−4·0.3, 0, 0).
    let expected = Vector::new(1.12 - 1.2, 1.5, -1.2);
    let felt = LeverArm(arm).specific_force(Vector::ZERO, rate, acceleration);
    assert!((felt - expected).norm() < 1e-15);
    let velocity = LeverArm(arm).velocity(Vector::ZERO, Rotation::IDENTITY, rate);
    assert!((velocity - Vector::new(0.0, 0.6, 0.0)).norm() < 1e-15);
}

#[test]
fn what_the_unit_feels_is_carried_to_the_centre_of_gravity_of_the_test_flight() {
    let trajectory = test_flight();
    for tenth in 0..3000 {
        let centre = trajectory.at(f64::from(tenth) * 0.1);
        let unit = centre.at_point(LEVER_ARM_M);
        let carried = LeverArm(-LEVER_ARM_M).specific_force(
            unit.specific_force_mps2,
            unit.inertial_rate_radps,
            unit.angular_acceleration_radps2,
        );
        // The remainder is the change of gravity over the arm: 3e-6 s⁻² · 0.28 m.
        assert!((carried - centre.specific_force_mps2).norm() < 2e-6);
    }
}
