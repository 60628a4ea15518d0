//! Health of the estimate for a controller: frozen sensors and contradicting fixes are noticed, and good flights give
//! no alarm.

use std::path::Path;

use hovernav::earth::Geodetic;
use hovernav::ekf::{Estimator, Solution};
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::health::{Distrust, Health, HealthLimits, HealthMonitor, Trust};
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_sim::faults::{Fault, Log};

/// Health at each sample of `heli-hover` with these faults, by time, s.
fn healths(faults: &[&str]) -> Vec<(f64, Health)> {
    let log = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let faults: Vec<Fault> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
    let dir = tempfile::tempdir().unwrap();
    Log::open(log).unwrap().with_faults(&faults, 3).unwrap().write(dir.path()).unwrap();
    let mut dataset = Dataset::open(dir.path()).unwrap();
    let mut estimator = Estimator::new(dataset.settings().unwrap());
    let mut monitor = HealthMonitor::new(HealthLimits::default());
    let mut healths = Vec::new();
    for event in dataset.events() {
        monitor.observe(&event);
        estimator.push(&event, |notice| monitor.observe_notice(&notice));
        if let Event::Imu(sample) = event {
            let health = monitor.assess(estimator.solution().as_ref(), sample.time);
            healths.push((sample.time.seconds(), health));
        }
    }
    healths
}

fn within(healths: &[(f64, Health)], from_s: f64, to_s: f64) -> impl Iterator<Item = &Health> {
    healths
        .iter()
        .filter(move |(time_s, _)| (from_s..to_s).contains(time_s))
        .map(|(_, health)| health)
}

#[test]
fn a_good_flight_gives_no_alarm() {
    for faults in [&[][..], &["vibration=2"][..], &["packet-loss=5"][..]] {
        let healths = healths(faults);
        for health in within(&healths, 30.0, 300.0) {
            assert_eq!(health.tilt, Ok(()), "{faults:?}");
            assert_eq!(health.velocity, Ok(()), "{faults:?}");
            assert_eq!(health.position, Ok(()), "{faults:?}");
            assert_eq!(health.dead_reckoning_since, None, "{faults:?}");
        }
    }
}

#[test]
fn a_frozen_receiver_is_noticed_within_three_seconds_and_forgiven_after() {
    let healths = healths(&["frozen-fix@100"]);
    for health in within(&healths, 103.5, 119.0) {
        assert_eq!(health.velocity, Err(Distrust::Frozen));
        assert_eq!(health.position, Err(Distrust::Frozen));
        assert_eq!(health.position_trust(), Trust::Lost);
        assert_eq!(health.tilt, Ok(()));
    }
    assert!(within(&healths, 127.0, 140.0).all(|health| health.position.is_ok()));
}

#[test]
fn a_frozen_inertial_unit_is_noticed_within_a_quarter_of_a_second() {
    let healths = healths(&["stuck=all@100:2"]);
    assert!(within(&healths, 100.25, 102.0).all(|health| health.tilt.is_err()));
    assert!(within(&healths, 103.0, 110.0).all(|health| health.tilt.is_ok()));
}

#[test]
fn fixes_that_deny_the_estimate_cost_it_its_position() {
    let healths = healths(&["glitch-step=60@100:15"]);
    assert!(within(&healths, 101.5, 104.0).all(|health| health.position_trust() > Trust::Valid));
    for health in within(&healths, 105.0, 114.0) {
        assert_eq!(health.position, Err(Distrust::Disagreement));
        assert_eq!(health.velocity, Ok(()));
    }
    assert!(within(&healths, 120.0, 130.0).all(|health| health.position.is_ok()));
}

#[test]
fn dead_reckoning_is_reported_with_its_start() {
    let healths = healths(&["outage=20@100"]);
    for health in within(&healths, 103.5, 119.5) {
        let since_s = health.dead_reckoning_since.unwrap().seconds();
        assert!((98.5..100.5).contains(&since_s), "{since_s}");
        assert!(health.velocity_trust() > Trust::Valid);
    }
    assert!(within(&healths, 125.0, 130.0).all(|health| health.dead_reckoning_since.is_none()));
}

#[test]
fn what_was_not_good_enough_has_to_be_well_within_its_limit() {
    let mut monitor = HealthMonitor::new(HealthLimits::default());
    let solution = Solution {
        body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(3.0, 0.5, 40.0)),
        position_sigma_m: Vector::new(1.0, 1.0, 1.5),
        velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
        attitude_sigma_rad: [0.01, 0.01, 0.03],
        ..Solution::at_rest(Time::ZERO, Geodetic::from_degrees(1.35, 103.82, 50.0).unwrap())
    };
    let mut trust_at = |sigma_mps: f64| {
        let velocity_sigma_mps = Vector::new(sigma_mps, 0.1, 0.1);
        let solution = Solution { velocity_sigma_mps, ..solution };
        monitor.assess(Some(&solution), Time::ZERO).velocity_trust()
    };
    let sigmas = [0.1, 0.6, 0.79, 0.81, 0.7, 0.62, 0.79, 0.3];
    let expected = [
        Trust::Valid,
        Trust::Degraded,
        Trust::Degraded,
        Trust::Lost,
        Trust::Lost,
        Trust::Degraded,
        Trust::Degraded,
        Trust::Valid,
    ];
    assert_eq!(sigmas.map(&mut trust_at), expected);
    assert_eq!(monitor.assess(None, Time::ZERO).attitude_trust(), Trust::Lost);
}
