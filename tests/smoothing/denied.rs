//! A flight with a large gyro error for a short time. There the fixes contradict the smoothed solution, and the
//! filter's own solution is used. A flight without a fault is smoothed throughout.

use hovernav::earth::Geodetic;
use hovernav::ekf::{EstimatorConfig, Solution};
use hovernav::frames::Vector;
use hovernav::imu::Motion;
use hovernav_dataset::{Dataset, Reference};
use hovernav_replay::smooth;
use hovernav_score::{Axis, score};
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, fly};
use hovernav_testing::shared;

/// A flight of 100 s with a yaw gyro whose error is `error_radps` from 50 s to 51 s.
fn flight(error_radps: f64) -> (Dataset, EstimatorConfig) {
    let field = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
    let forward = |speed_mps| Vector::new(speed_mps, 0.0, 0.0);
    let mut plan = FlightPlan::hover_at(field, 0.7).hold(10.0);
    for _ in 0..6 {
        plan = plan.accelerate(forward(6.0), 4.0).turn(1.5, 0.4).accelerate(forward(-6.0), 4.0);
    }
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let trajectory = plan.build().unwrap();
    let recording = fly(&trajectory, &dmu, &gps, 7).unwrap();
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    config.aiding.attitude = false;
    config.aiding.magnetometer = false;
    let mut dataset = Dataset { imu: recording.imu, fixes: recording.fixes, ..Dataset::default() };
    for sample in &mut dataset.imu {
        if let Motion::Rates { angular_rate_radps, .. } = &mut sample.motion
            && (50.0..51.0).contains(&sample.time.seconds())
        {
            *angular_rate_radps += Vector::new(0.0, 0.0, error_radps);
        }
    }
    (dataset, config)
}

#[test]
fn a_flight_without_fault_is_smoothed_throughout() {
    let (dataset, config) = flight(0.0);
    assert_eq!(smooth(&dataset, &config, |_| ()).inconsistent, []);
}

#[test]
fn where_the_fixes_deny_it_the_filter_s_own_solution_stands() {
    let (dataset, config) = flight(1.2);
    let run = smooth(&dataset, &config, |_| ());
    println!("{:#?}", run.inconsistent);
    let [denied] = &run.inconsistent[..] else { panic!("{:?}", run.inconsistent) };
    assert!(denied.start.seconds() < 51.0 && denied.end.seconds() > 51.0, "{denied:?}");
    let mut replaced = 0;
    for (smoothed, causal) in run.solutions.iter().zip(&run.forward.solutions) {
        if denied.covers(smoothed.time) {
            assert_eq!(smoothed, causal);
            replaced += 1;
        }
    }
    assert!(replaced > 300, "{replaced}");
}

#[test]
fn a_launch_that_the_filter_was_refused_over_is_not_smoothed_away() {
    let Some(place) = shared("datasets/uav-thor75-1hz") else { return };
    let mut dataset = Dataset::open(&place).unwrap();
    let config = dataset.settings().unwrap();
    let reference = Reference::open(&place, &dataset.manifest).unwrap().unwrap();
    let run = smooth(&dataset, &config, |_| ());
    let first = dataset.imu[0].time;
    let level = |solutions: &[Solution]| {
        let scored = score(solutions, &reference, first);
        let rmse = |axis| scored.axis(axis).unwrap().statistics.rmse;
        rmse(Axis::VelocityNorth).hypot(rmse(Axis::VelocityEast))
    };
    let (causal, smoothed) = (level(&run.forward.solutions), level(&run.solutions));
    println!("horizontal velocity: {causal:.3} to {smoothed:.3} m/s");
    assert!(smoothed < causal, "{causal} to {smoothed}");
}
