//! A vehicle that rests, sets off and takes off, with unknown heading and gyro biases that differ from those at rest.
//! No good fix is rejected for long, and the one-sigmas are right.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Channel, Notice, Verdict};
use hovernav::event::Event;
use hovernav::frames::{Body, Vector, wrap_angle};
use hovernav::imu::{ImuSample, Motion};
use hovernav_sim::{FlightPlan, GpsConfig};

use crate::unaided::flown_unaided;

const REST_S: f64 = 60.0;

fn forward(speed_mps: f64) -> Vector<hovernav_sim::Level> {
    Vector::new(speed_mps, 0.0, 0.0)
}

fn at_rest(heading_rad: f64) -> FlightPlan {
    let place = Geodetic::from_degrees(45.3, -93.2, 250.0).unwrap();
    FlightPlan::hover_at(place, heading_rad).hold(REST_S)
}

/// Taxis, stops, is launched within 3 s and circles.
fn aeroplane(heading_rad: f64) -> FlightPlan {
    let turn = core::f64::consts::TAU;
    at_rest(heading_rad)
        .accelerate(forward(3.0), 3.0)
        .hold(4.0)
        .turn(0.4 * turn, 0.8)
        .accelerate(forward(-3.0), 3.0)
        .hold(8.0)
        .accelerate(forward(17.0), 3.0)
        .climb(20.0, 4.0)
        .turn(-turn, 0.4)
        .hold(5.0)
        .turn(turn, 0.4)
        .hold(20.0)
}

/// Lifts off, hovers, flies its test points and turns.
fn helicopter(heading_rad: f64) -> FlightPlan {
    at_rest(heading_rad)
        .climb(5.0, 1.0)
        .hold(5.0)
        .test_points()
        .accelerate(forward(8.0), 5.0)
        .turn(core::f64::consts::PI, 0.4)
        .hold(20.0)
}

/// Change of the gyro biases as the vehicle sets off, rad/s.
fn step(seed: u64) -> Vector<Body> {
    let sign = if seed.is_multiple_of(2) { 1.0 } else { -1.0 };
    Vector::new(0.004, -0.002, 0.01 * sign)
}

struct Outcome {
    found_s: Option<f64>,
    /// Longest run of fixes with rejected horizontal velocity after the heading was found.
    refused: usize,
    /// Fraction of later samples with yaw inside 3 sigma.
    yaw_inside: f64,
    /// Fraction of later samples with horizontal velocity inside 3 sigma.
    velocity_inside: f64,
    worst_off_m: f64,
}

fn flown(plan: &FlightPlan, seed: u64) -> Outcome {
    let gps = GpsConfig::default();
    let (recording, mut estimator) = flown_unaided::<Full, 28>(plan, &gps, seed);
    let mut outcome = Outcome {
        found_s: None,
        refused: 0,
        yaw_inside: 0.0,
        velocity_inside: 0.0,
        worst_off_m: 0.0,
    };
    let (mut in_a_row, mut count) = (0, 0.0);
    let mut fixes = recording.fixes.iter().peekable();
    for (index, (sample, truth)) in recording.imu.iter().zip(&recording.truth).enumerate() {
        let mut notify = |notice| match notice {
            Notice::HeadingFound { time, .. } => outcome.found_s = Some(time.seconds()),
            Notice::Updated(report) if outcome.found_s.is_some() => {
                let axis = report.innovations().find(|axis| axis.channel == Channel::VelocityNorth);
                match axis.map(|axis| axis.verdict) {
                    Some(Verdict::Rejected) => in_a_row += 1,
                    Some(_) => in_a_row = 0,
                    None => {}
                }
                outcome.refused = outcome.refused.max(in_a_row);
            }
            _ => {}
        };
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), &mut notify);
        }
        let moving = sample.time.seconds() > REST_S;
        let sample = if moving { set_off(sample, index, step(seed)) } else { *sample };
        estimator.push(&Event::Imu(sample), &mut notify);
        let solution = estimator.solution().filter(|_| outcome.found_s.is_some());
        let Some(solution) = solution else { continue };
        count += 1.0;
        let yaw = solution.body_to_ned.euler().yaw_rad - truth.body_to_ned.euler().yaw_rad;
        if wrap_angle(yaw).abs() <= 3.0 * solution.attitude_sigma_rad[2] {
            outcome.yaw_inside += 1.0;
        }
        let off = solution.velocity_mps - truth.velocity_mps;
        let sigmas = solution.velocity_sigma_mps;
        if off.x().abs() <= 3.0 * sigmas.x() && off.y().abs() <= 3.0 * sigmas.y() {
            outcome.velocity_inside += 1.0;
        }
        let [north, east, _] = solution.position.displacement_from(&truth.position).to_array();
        outcome.worst_off_m = outcome.worst_off_m.max(north.hypot(east));
    }
    outcome.yaw_inside /= count;
    outcome.velocity_inside /= count;
    outcome
}

/// A sample with the engine running and changed gyro biases.
fn set_off(sample: &ImuSample, index: usize, step_radps: Vector<Body>) -> ImuSample {
    let rates = sample.motion.mean_rates(0.02);
    let shake = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    let motion = Motion::Rates {
        angular_rate_radps: rates.angular_rate_radps
            + step_radps
            + Vector::new(0.02, 0.01, -0.01) * shake,
        specific_force_mps2: rates.specific_force_mps2 + Vector::new(0.3, 0.3, 1.5) * shake,
    };
    ImuSample { motion, ..*sample }
}

fn judge(kind: &str, plan: impl Fn(f64) -> FlightPlan) {
    let (mut yaw, mut velocity, mut least) = (0.0, 0.0, 1.0);
    for seed in 1..=SEEDS {
        let outcome = flown(&plan(0.8 * seed as f64), seed);
        let Outcome { found_s, refused, yaw_inside, velocity_inside, worst_off_m } = outcome;
        println!(
            "{kind} {seed}: found at {found_s:?} s, {refused} fixes refused in a row, inside 3 sigma: \
             yaw {yaw_inside:.3}, velocity {velocity_inside:.3}; at most {worst_off_m:.1} m off"
        );
        assert!(found_s.is_some(), "{kind} {seed}");
        assert!(refused <= 3, "{kind} {seed}: {refused}");
        assert!(worst_off_m < 15.0, "{kind} {seed}");
        least = f64::min(least, yaw_inside.min(velocity_inside));
        yaw += yaw_inside / SEEDS as f64;
        velocity += velocity_inside / SEEDS as f64;
    }
    println!("{kind}: inside 3 sigma: yaw {yaw:.3}, velocity {velocity:.3}, least {least:.3}");
    assert!(yaw > 0.9 && velocity > 0.95 && least > 0.5, "{kind}");
}

const SEEDS: u64 = 8;

#[test]
fn an_aeroplane_whose_gyro_biases_step_as_it_sets_off_keeps_its_fixes() {
    judge("aeroplane", aeroplane);
}

#[test]
fn a_helicopter_whose_gyro_biases_step_as_it_lifts_off_keeps_its_fixes() {
    judge("helicopter", helicopter);
}
