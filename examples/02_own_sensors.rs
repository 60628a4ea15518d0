//! Sensors without a driver in this project: their data, converted to the units and axes of the estimator.
//!
//! The inertial unit has its axes forward, left, up and sends g and degrees a second, 100 times a second. The
//! receiver sends degrees, speed and course, 5 times a second. The magnetometer sends microtesla.
//!
//! `cargo run --release --example 02_own_sensors`

use std::f64::consts::TAU;

use hovernav::earth::{Geodetic, Local, STANDARD_GRAVITY_MPS2};
use hovernav::ekf::{Estimator, EstimatorConfig, Solution};
use hovernav::event::Event;
use hovernav::frames::{Body, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;

/// A sample of the inertial unit, in its own axes and units.
struct UnitReading {
    gyro_degps: [f64; 3],
    accel_g: [f64; 3],
    field_microtesla: [f64; 3],
}

/// A fix of the receiver.
struct ReceiverReading {
    latitude_deg: f64,
    longitude_deg: f64,
    height_m: f64,
    speed_mps: f64,
    course_deg: f64,
    climb_mps: f64,
}

/// Rotates from forward, left, up to forward, right, down.
fn forward_right_down([x, y, z]: [f64; 3]) -> Vector<Body> {
    Vector::new(x, -y, -z)
}

const GAUSS_PER_MICROTESLA: f64 = 0.01;

fn imu_event(time: Time, reading: &UnitReading) -> Event {
    let motion = Motion::Rates {
        angular_rate_radps: forward_right_down(reading.gyro_degps.map(f64::to_radians)),
        specific_force_mps2: forward_right_down(reading.accel_g) * STANDARD_GRAVITY_MPS2,
    };
    let field_gauss = forward_right_down(reading.field_microtesla) * GAUSS_PER_MICROTESLA;
    Event::Imu(ImuSample {
        magnetic_field_gauss: Some(field_gauss),
        ..ImuSample::new(time, motion)
    })
}

/// Event of a fix; `None` for an invalid position.
fn gps_event(time: Time, reading: &ReceiverReading) -> Option<Event> {
    let ReceiverReading { latitude_deg, longitude_deg, height_m, .. } = *reading;
    let (sin, cos) = reading.course_deg.to_radians().sin_cos();
    Some(Event::Gps(Fix {
        position_sigma_m: Some(Vector::new(1.5, 1.5, 3.0)),
        horizontal_velocity_mps: Some([reading.speed_mps * cos, reading.speed_mps * sin]),
        down_velocity_mps: Some(-reading.climb_mps),
        velocity_sigma_mps: Some(Vector::new(0.1, 0.1, 0.2)),
        ..Fix::at(time, Geodetic::from_degrees(latitude_deg, longitude_deg, height_m)?)
    }))
}

/// A cart that rolls to and fro along heading 40°, with an error of its vertical gyro of 0.3°/s.
struct Cart {
    start: Geodetic,
    gravity_mps2: f64,
}

const HEADING_DEG: f64 = 40.0;
const GYRO_BIAS_DEGPS: f64 = 0.3;
const PERIOD_S: f64 = 30.0;
const REACH_M: f64 = 30.0;

impl Cart {
    fn new() -> Option<Self> {
        let start = Geodetic::from_degrees(47.3769, 8.5417, 450.0)?;
        Some(Self { start, gravity_mps2: Local::at(&start).gravity_mps2 })
    }

    /// Distance, m, speed, m/s, and acceleration, m/s², at `time_s`; at rest for the first five seconds.
    fn motion(time_s: f64) -> [f64; 3] {
        let rate = TAU / PERIOD_S;
        let (sin, cos) = (rate * (time_s - 5.0).max(0.0)).sin_cos();
        let acceleration = if time_s < 5.0 { 0.0 } else { REACH_M * rate * rate * cos };
        [REACH_M * (1.0 - cos), REACH_M * rate * sin, acceleration]
    }

    fn unit(&self, time_s: f64) -> UnitReading {
        let [.., acceleration] = Self::motion(time_s);
        let (sin, cos) = HEADING_DEG.to_radians().sin_cos();
        // 20 µT to the north and 43 µT down, in axes that point to 40°, left and up.
        UnitReading {
            gyro_degps: [0.0, 0.0, -GYRO_BIAS_DEGPS],
            accel_g: [acceleration, 0.0, self.gravity_mps2]
                .map(|force| force / STANDARD_GRAVITY_MPS2),
            field_microtesla: [20.0 * cos, 20.0 * sin, -43.0],
        }
    }

    fn receiver(&self, time_s: f64) -> ReceiverReading {
        let [way, speed, _] = Self::motion(time_s);
        let (sin, cos) = HEADING_DEG.to_radians().sin_cos();
        let place = self.start.displaced(Vector::new(way * cos, way * sin, 0.0));
        ReceiverReading {
            latitude_deg: place.latitude_deg(),
            longitude_deg: place.longitude_deg(),
            height_m: place.height_m,
            speed_mps: speed.abs(),
            course_deg: if speed < 0.0 { HEADING_DEG + 180.0 } else { HEADING_DEG },
            climb_mps: 0.0,
        }
    }
}

/// The solution after `seconds`, and the cart's true speed then, m/s.
fn estimate(seconds: u32) -> Option<(Solution, f64)> {
    let cart = Cart::new()?;
    let mut estimator: Estimator = Estimator::new(EstimatorConfig::default());
    for sample in 0..=100 * seconds {
        let time_s = f64::from(sample) * 0.01;
        let time = Time::ZERO + time_s;
        estimator.push(&imu_event(time, &cart.unit(time_s)), |_| {});
        if sample % 20 == 0 {
            estimator.push(&gps_event(time, &cart.receiver(time_s))?, |_| {});
        }
    }
    let [_, speed_mps, _] = Cart::motion(f64::from(seconds));
    Some((estimator.solution()?, speed_mps))
}

fn main() {
    let (solution, speed_mps) = estimate(120).expect("the estimator aligns within seconds");
    let [u, v, w] = solution.velocity_body_mps().to_array();
    let yaw_deg = solution.body_to_ned.euler().yaw_rad.to_degrees();
    let bias_degps = solution.gyro_bias_radps.z().to_degrees();
    println!("forward {u:.2} m/s where {speed_mps:.2} is true, right {v:.2}, down {w:.2}");
    println!("heading {yaw_deg:.1}°, gyro bias {bias_degps:.3}°/s");
}

#[test]
fn velocity_heading_and_gyro_bias_are_found() {
    use approx::assert_abs_diff_eq;

    let (solution, speed_mps) = estimate(120).unwrap();
    let [u, v, w] = solution.velocity_body_mps().to_array();
    assert!((u - speed_mps).abs() < 0.1 && v.abs() < 0.1 && w.abs() < 0.1, "{u} {v} {w}");
    assert_abs_diff_eq!(
        solution.body_to_ned.euler().yaw_rad.to_degrees(),
        HEADING_DEG,
        epsilon = 1.0
    );
    assert_abs_diff_eq!(solution.gyro_bias_radps.z().to_degrees(), GYRO_BIAS_DEGPS, epsilon = 0.02);
}
