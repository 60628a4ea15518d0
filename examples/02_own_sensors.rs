//! Sensors without a driver in this project: their data, converted to the units and axes of the estimator.
//!
//! The inertial unit has its axes forward, left, up and sends g and degrees a second, 100 times a second. The
//! receiver sends degrees, speed and course, 5 times a second. The magnetometer sends microtesla.
//!
//! `cargo run --release --example 02_own_sensors`

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::prelude::*;

/// The solution after all events, in the order of their arrival.
fn navigate(settings: EstimatorConfig, events: impl Iterator<Item = Event>) -> Option<Solution> {
    let mut estimator = Estimator::new(settings);
    for event in events {
        estimator.push(&event, |notice| match notice {
            Notice::SetupSuspect { fault, .. } => println!("units or axes: {fault}"),
            Notice::Updated(report) if report.any_rejected() => println!("rejected: {report:?}"),
            _ => {} // readings that were not used, gaps, resets
        });
    }
    estimator.solution() // position, velocity, attitude, biases, one-sigmas
}

/// A reading of your sensors, in their own units and axes.
enum Reading {
    /// Axes forward, left, up: °/s, g, µT.
    Unit { gyro_degps: [f64; 3], accel_g: [f64; 3], field_microtesla: [f64; 3] },
    /// Latitude and longitude, °, height, m; speed, m/s, course, °, climb, m/s.
    Receiver { position: [f64; 3], speed_mps: f64, course_deg: f64, climb_mps: f64 },
}

/// The settings are from the datasheets of the sensors; the lever arms were measured with a ruler.
fn settings() -> EstimatorConfig {
    let imu = ImuModel::default()
        .with_gyro_noise_degps_per_sqrt_hz(0.014)
        .with_accel_noise_ug_per_sqrt_hz(190.0)
        .with_gyro_bias_sigma_degps(0.3)
        .with_gyro_range_degps(2000.0);
    let antenna_m = Vector::new(-0.40, 0.0, -0.15);
    let mounting = Mounting::default().with_antenna_lever_arm_m(antenna_m);
    EstimatorConfig::default().with_imu(imu).with_mounting(mounting)
}

/// The reading in SI units and the estimator's axes: forward, right, down. `None` for an invalid position.
fn event(time: Time, reading: &Reading) -> Option<Event> {
    let turned = |[forward, left, up]: [f64; 3]| Vector::<Body>::new(forward, -left, -up);
    Some(match *reading {
        Reading::Unit { gyro_degps, accel_g, field_microtesla } => {
            let rate_radps = turned(gyro_degps.map(f64::to_radians));
            let force_mps2 = turned(accel_g) * STANDARD_GRAVITY_MPS2;
            let field_gauss = turned(field_microtesla) * 0.01;
            let sample = ImuSample::from_rates(time, rate_radps, force_mps2);
            Event::Imu(sample.with_magnetic_field_gauss(field_gauss))
        }
        Reading::Receiver { position, speed_mps, course_deg, climb_mps } => {
            let [latitude_deg, longitude_deg, height_m] = position;
            let position = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m)?;
            let (sin, cos) = course_deg.to_radians().sin_cos();
            let velocity_mps = Vector::new(speed_mps * cos, speed_mps * sin, -climb_mps);
            Event::Gps(Fix::at(time, position).with_velocity_mps(velocity_mps))
        }
    })
}

// A simulated cart replaces your drivers. It rolls to and fro along heading 40°; its vertical gyro has a bias of
// 0.3°/s.

const HEADING_DEG: f64 = 40.0;
const GYRO_BIAS_DEGPS: f64 = 0.3;
const PERIOD_S: f64 = 30.0;
const REACH_M: f64 = 30.0;
const DURATION_S: f64 = 120.0;

/// Distance, speed and acceleration of the cart, at rest for the first five seconds.
fn motion(seconds: f64) -> [f64; 3] {
    let rate = std::f64::consts::TAU / PERIOD_S;
    let (sin, cos) = (rate * (seconds - 5.0).max(0.0)).sin_cos();
    let acceleration = if seconds < 5.0 { 0.0 } else { REACH_M * rate * rate * cos };
    [REACH_M * (1.0 - cos), REACH_M * rate * sin, acceleration]
}

fn unit(seconds: f64) -> Reading {
    let [.., acceleration] = motion(seconds);
    let (sin, cos) = HEADING_DEG.to_radians().sin_cos();
    // 20 µT to the north and 43 µT down, in axes that point to 40°, left and up.
    Reading::Unit {
        gyro_degps: [0.0, 0.0, -GYRO_BIAS_DEGPS],
        accel_g: [acceleration, 0.0, GRAVITY_MPS2].map(|force| force / STANDARD_GRAVITY_MPS2),
        field_microtesla: [20.0 * cos, 20.0 * sin, -43.0],
    }
}

/// Gravity at the start, 47.4° north and 450 m high.
const GRAVITY_MPS2: f64 = 9.806_9;

fn receiver(seconds: f64) -> Reading {
    let [way, speed_mps, _] = motion(seconds);
    let start = Geodetic::from_degrees(47.3769, 8.5417, 450.0).expect("a position on Earth");
    let (sin, cos) = HEADING_DEG.to_radians().sin_cos();
    // The antenna is behind the inertial unit and above it.
    let ahead_m = way - 0.40;
    let position = start.displaced(Vector::new(ahead_m * cos, ahead_m * sin, -0.15));
    Reading::Receiver {
        position: [position.latitude_deg(), position.longitude_deg(), position.height_m],
        speed_mps: speed_mps.abs(),
        course_deg: if speed_mps < 0.0 { HEADING_DEG + 180.0 } else { HEADING_DEG },
        climb_mps: 0.0,
    }
}

/// 100 samples a second, and a fix with every twentieth.
fn events() -> impl Iterator<Item = Event> {
    (0..=(100.0 * DURATION_S) as u32).flat_map(|sample| {
        let seconds = f64::from(sample) * 0.01;
        let fix = (sample % 20 == 0).then(|| receiver(seconds));
        let readings = std::iter::once(unit(seconds)).chain(fix);
        readings.filter_map(move |reading| event(Time::from_seconds(seconds), &reading))
    })
}

fn main() {
    let solution = navigate(settings(), events()).expect("the estimator aligns within seconds");
    let [_, speed_mps, _] = motion(DURATION_S);
    let [u, v, w] = solution.velocity_body_mps().to_array();
    let yaw_deg = solution.body_to_ned.euler().yaw_rad.to_degrees();
    let bias_degps = solution.gyro_bias_radps.z().to_degrees();
    println!("forward {u:.2} m/s where {speed_mps:.2} is true, right {v:.2}, down {w:.2}");
    println!("heading {yaw_deg:.1}°, gyro bias {bias_degps:.3}°/s");
    let health = solution.health(Time::from_seconds(DURATION_S));
    println!("velocity is good: {}", health.velocity.is_ok());
}

#[test]
fn velocity_heading_and_gyro_bias_are_found() {
    use approx::assert_abs_diff_eq;

    let solution = navigate(settings(), events()).unwrap();
    let [_, speed_mps, _] = motion(DURATION_S);
    let [u, v, w] = solution.velocity_body_mps().to_array();
    assert!((u - speed_mps).abs() < 0.1 && v.abs() < 0.1 && w.abs() < 0.1, "{u} {v} {w}");
    assert_abs_diff_eq!(
        solution.body_to_ned.euler().yaw_rad.to_degrees(),
        HEADING_DEG,
        epsilon = 1.0
    );
    assert_abs_diff_eq!(solution.gyro_bias_radps.z().to_degrees(), GYRO_BIAS_DEGPS, epsilon = 0.02);
}
