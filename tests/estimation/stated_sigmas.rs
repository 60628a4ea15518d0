//! A receiver that states its velocity to be better than it is: the filter finds out, refuses next to nothing,
//! and never takes itself for lost.

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Channel, Estimator, EstimatorConfig, Notice, Verdict};
use hovernav::event::Event;
use hovernav::frames::Vector;
use hovernav::gps::Fix;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, fly};

/// Vertical velocities refused, the largest one-sigma of the tilt after 20 s, degrees, and how often the filter was
/// reopened, over a flight whose vertical velocity of 0.5 m/s one-sigma is stated as `stated_mps`.
fn flown(seed: u64, stated_mps: f64) -> (usize, f64, usize) {
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let place = Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap();
    let plan = FlightPlan::test_flight(place, 0.9 * seed as f64);
    let recording = fly(&plan.build().unwrap(), &dmu, &gps, seed).unwrap();
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    let mut estimator = Box::new(Estimator::<Full, 28>::new(config));
    let (mut refused, mut tilt_deg, mut reopened) = (0, 0.0, 0);
    let mut fixes = recording.fixes.iter().peekable();
    for sample in &recording.imu {
        let mut notify = |notice| {
            let Notice::Updated(report) = notice else { return };
            reopened += usize::from(report.any_reopened());
            refused += report
                .innovations()
                .filter(|axis| axis.channel == Channel::VelocityDown)
                .filter(|axis| axis.verdict == Verdict::Rejected)
                .count();
        };
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            let stated =
                Fix { velocity_sigma_mps: Some(Vector::new(0.2, 0.2, stated_mps)), ..*fix };
            estimator.push(&Event::Gps(stated), &mut notify);
        }
        estimator.push(&Event::Imu(*sample), &mut notify);
        if sample.time.seconds() > 20.0
            && let Some(solution) = estimator.solution()
        {
            let [roll, pitch, _] = solution.attitude_sigma_rad;
            tilt_deg = f64::max(tilt_deg, roll.max(pitch).to_degrees());
        }
    }
    (refused, tilt_deg, reopened)
}

#[test]
fn a_vertical_velocity_stated_too_good_is_found_out_and_locks_nobody_out() {
    for seed in 1..=10 {
        let (refused, tilt_deg, reopened) = flown(seed, 0.2);
        println!("seed {seed}: {refused} of 300 refused, tilt known to {tilt_deg:.2}°");
        assert!(refused <= 3, "seed {seed}: {refused} refused");
        assert!(reopened == 0 && tilt_deg < 1.5, "seed {seed}: {reopened} times, {tilt_deg}°");
    }
}

#[test]
fn what_is_stated_rightly_is_believed() {
    for seed in 1..=4 {
        let (refused, _, reopened) = flown(seed, 0.5);
        assert_eq!((refused, reopened), (0, 0), "seed {seed}");
    }
}
