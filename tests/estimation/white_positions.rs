//! A receiver that reports no velocity, and whose position errors are white: a simulator, or radio beacons.

use hovernav::earth::Geodetic;
use hovernav::ekf::{Estimator, EstimatorConfig, Mechanisms};
use hovernav::event::Event;
use hovernav::frames::{Vector, wrap_angle};
use hovernav::gps::Fix;
use hovernav::imu::ImuSample;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, HorizontalVertical, fly};

const NOISE_M: HorizontalVertical = HorizontalVertical { horizontal: 0.5, vertical: 0.75 };
const NONE: HorizontalVertical = HorizontalVertical { horizontal: 0.0, vertical: 0.0 };

/// Largest errors after 60 s of a flight without another source of heading: horizontal velocity, m/s, and heading,
/// degrees.
fn worst(rate_hz: f64, seed: u64, mechanisms: Mechanisms) -> [f64; 2] {
    let dmu = DmuConfig::default();
    let gps = GpsConfig {
        rate_hz,
        position_noise_m: NOISE_M,
        position_wander_m: NONE,
        ..GpsConfig::default()
    };
    let place = Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap();
    let plan = FlightPlan::test_flight(place, 0.7 * seed as f64);
    let recording = fly(&plan.build().unwrap(), &dmu, &gps, seed).unwrap();
    let mut config = EstimatorConfig::default();
    config.ekf.mechanisms = mechanisms;
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    let mut estimator = Box::new(Estimator::new(config));
    let mut fixes = recording.fixes.iter().peekable();
    let mut worst = [0.0_f64; 2];
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            let stated = Vector::new(NOISE_M.horizontal, NOISE_M.horizontal, NOISE_M.vertical);
            let fix = Fix { position_sigma_m: Some(stated), ..Fix::at(fix.time, fix.position) };
            estimator.push(&Event::Gps(fix), |_| {});
        }
        estimator.push(&Event::Imu(ImuSample { attitude: None, ..*sample }), |_| {});
        let Some(solution) = estimator.solution().filter(|_| sample.time.seconds() > 60.0) else {
            continue;
        };
        let [north, east, _] = (solution.velocity_mps - truth.velocity_mps).to_array();
        let yaw_rad = solution.body_to_ned.euler().yaw_rad - truth.body_to_ned.euler().yaw_rad;
        worst[0] = worst[0].max(north.hypot(east));
        worst[1] = worst[1].max(wrap_angle(yaw_rad).to_degrees().abs());
    }
    worst
}

#[test]
fn they_are_not_taken_for_motion() {
    // For comparison: without the mechanism, the errors are up to 2.9 m/s and 12°.
    let without = Mechanisms { position_scatter: false, ..Mechanisms::ALL };
    for (rate_hz, seed) in [(5.0, 1), (5.0, 2), (10.0, 3), (10.0, 4)] {
        let [velocity_mps, heading_deg] = worst(rate_hz, seed, Mechanisms::ALL);
        assert!(velocity_mps < 1.0 && heading_deg < 6.0, "{velocity_mps:.1} {heading_deg:.0}");
        assert!(worst(rate_hz, seed, without)[0] > velocity_mps);
    }
}
