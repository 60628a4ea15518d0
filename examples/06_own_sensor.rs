//! A sensor that the library does not know: a camera that looks at the ground and measures optical flow.
//!
//! A simulated helicopter flies half a minute without GPS. With the camera it drifts a fraction of the distance.
//!
//! `cargo run --release --example 06_own_sensor`

use std::error::Error;
use std::ops::Range;

use hovernav::ekf::{Expected, Measurement, Row, Rows};
use hovernav::ins::LeverArm;
use hovernav::prelude::*;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, fly};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// A reading of the camera: the angular rates, rad/s, at which the ground below moves backwards and to the left, and
/// the distance to the ground, m.
struct OpticalFlow {
    flow_radps: [f64; 2],
    distance_m: f64,
}

/// Position of the camera relative to the point of the solution, forward, right, down, m.
const CAMERA_M: Vector<Body> = Vector::new(0.30, 0.0, 0.10);
/// One-sigma of the camera's angular rates, rad/s.
const SIGMA_RADPS: f64 = 0.03;

impl Measurement for OpticalFlow {
    fn compare(&self, expected: &Expected, rows: &mut Rows) {
        let [forward_mps, right_mps, _] = expected.velocity_body_mps().to_array();
        let [roll_radps, pitch_radps, _] = expected.angular_rate_radps.to_array();
        let [backwards, left] = self.flow_radps;
        let per_metre = 1.0 / self.distance_m;

        let residual = backwards - (forward_mps * per_metre + pitch_radps);
        rows.push(
            Row::new(residual, SIGMA_RADPS)
                .with_velocity_body(expected, Vector::new(per_metre, 0.0, 0.0))
                .with_angular_rate(Vector::new(0.0, 1.0, 0.0)),
        );
        let residual = left - (right_mps * per_metre - roll_radps);
        rows.push(
            Row::new(residual, SIGMA_RADPS)
                .with_velocity_body(expected, Vector::new(0.0, per_metre, 0.0))
                .with_angular_rate(Vector::new(-1.0, 0.0, 0.0)),
        );
    }

    fn lever_arm_m(&self) -> Vector<Body> {
        CAMERA_M
    }
}

// The rest simulates the flight.

const OUTAGE_S: Range<f64> = 60.0..90.0;
const GROUND_M: f64 = 38.0;

/// The reading of a camera with the motion `truth`, with white errors.
fn reading(truth: &Expected, errors: &mut impl FnMut() -> f64) -> OpticalFlow {
    let [.., [_, _, down]] = truth.body_to_ned.rows();
    let distance_m = (truth.position.height_m - GROUND_M) / down;
    let [forward_mps, right_mps, _] = truth.velocity_body_mps().to_array();
    let [roll_radps, pitch_radps, _] = truth.angular_rate_radps.to_array();
    let flow_radps = [forward_mps / distance_m + pitch_radps, right_mps / distance_m - roll_radps];
    let flow_radps = flow_radps.map(|flow| flow + SIGMA_RADPS * errors());
    OpticalFlow { flow_radps, distance_m }
}

/// Errors of position, m, and velocity, m/s, at the end of the outage.
fn drift(seed: u64, with_camera: bool) -> Result<[f64; 2], Box<dyn Error>> {
    let start = Geodetic::from_degrees(1.3521, 103.8198, GROUND_M + 12.0).ok_or("no position")?;
    let forward = |speed_mps| Vector::new(speed_mps, 0.0, 0.0);
    let plan = FlightPlan::hover_at(start, 0.7)
        .hold(10.0)
        .accelerate(forward(6.0), 4.0)
        .turn(6.0, 20f64.to_radians())
        .hold(20.0)
        .turn(-3.0, 20f64.to_radians())
        .accelerate(forward(-3.0), 4.0);
    let rest_s = OUTAGE_S.end + 5.0 - plan.duration_s();
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let flight = fly(&plan.hold(rest_s).build()?, &dmu, &gps, seed)?;

    let mounting = Mounting::default()
        .with_imu_lever_arm_m(dmu.lever_arm_m)
        .with_antenna_lever_arm_m(gps.lever_arm_m);
    let mut estimator = Estimator::new(EstimatorConfig::default().with_mounting(mounting));
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut errors = || StandardNormal.sample(&mut generator);
    let mut fixes = flight.fixes.iter().peekable();
    for (count, (sample, truth)) in flight.imu.iter().zip(&flight.truth).enumerate() {
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            if !OUTAGE_S.contains(&fix.time.seconds()) {
                estimator.push(&Event::Gps(*fix), |_| {});
            }
        }
        estimator.push(&Event::Imu(*sample), |_| {});
        let Some(solution) = estimator.solution() else { continue };
        if sample.time.seconds() >= OUTAGE_S.end - 0.1 {
            let off_m = solution.position.displacement_from(&truth.position);
            return Ok([off_m.norm(), (solution.velocity_mps - truth.velocity_mps).norm()]);
        }
        // Eleven readings a second.
        if with_camera && count % 3 == 0 {
            let (arm, rate_radps) = (LeverArm(CAMERA_M), truth.angular_rate_radps);
            let camera = Expected {
                time: sample.time,
                position: arm.position(&truth.position, truth.body_to_ned),
                velocity_mps: arm.velocity(truth.velocity_mps, truth.body_to_ned, rate_radps),
                body_to_ned: truth.body_to_ned,
                angular_rate_radps: rate_radps,
            };
            match estimator.update(&reading(&camera, &mut errors), sample.time) {
                Ok(report) if report.any_rejected() => println!("{}: rejected", sample.time),
                Err(reason) if reason.is_fault() => println!("{}: {reason}", sample.time),
                _ => {}
            }
        }
    }
    Err("the flight is too short".into())
}

fn main() -> Result<(), Box<dyn Error>> {
    for seed in 1..=8 {
        let ([alone_m, alone_mps], [off_m, off_mps]) = (drift(seed, false)?, drift(seed, true)?);
        println!(
            "{alone_m:.1} m and {alone_mps:.2} m/s without the camera, {off_m:.1} m and {off_mps:.2} m/s with it"
        );
    }
    Ok(())
}

#[test]
fn with_the_camera_the_drift_is_a_fraction() {
    let (mut alone, mut with) = ([0.0; 2], [0.0; 2]);
    for seed in 1..=8 {
        for (sum, with_camera) in [(&mut alone, false), (&mut with, true)] {
            for (sum, error) in sum.iter_mut().zip(drift(seed, with_camera).unwrap()) {
                *sum += error / 8.0;
            }
        }
    }
    println!("{alone:?} {with:?}");
    assert!(with[0] < 0.3 * alone[0], "{} m against {} m", with[0], alone[0]);
    assert!(with[1] < 0.3 * alone[1], "{} m/s against {} m/s", with[1], alone[1]);
}

#[test]
fn the_derivatives_are_right() {
    use hovernav::ekf::check_derivatives;
    use hovernav::frames::Rotation;

    let expected = Expected {
        time: Time::ZERO,
        position: Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap(),
        velocity_mps: Vector::new(4.0, -3.0, 0.7),
        body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(10.0, -20.0, 130.0)),
        angular_rate_radps: Vector::new(0.1, -0.3, 0.2),
    };
    let flow = OpticalFlow { flow_radps: [0.2, -0.1], distance_m: 12.0 };
    assert_eq!(check_derivatives(&flow, &expected, 1e-6), Ok(()));
}
