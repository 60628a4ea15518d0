//! The estimator's own check of units, signs and axes, on real logs. It suspects only logs that the reader suspects
//! too.

use hovernav::ekf::{Estimator, EstimatorConfig, Notice};
use hovernav::setup::SetupFault;
use hovernav_formats::{Options, open};
use hovernav_testing::shared;

/// Faults that the estimator reports in the log `name`, as read.
fn suspects(name: &str) -> Option<Vec<SetupFault>> {
    let dataset = open(&shared(name)?, &Options::default()).unwrap().dataset;
    let mut estimator = Box::new(Estimator::new(EstimatorConfig::default()));
    let mut suspects = Vec::new();
    for event in dataset.events() {
        estimator.push(&event, |notice| {
            if let Notice::SetupSuspect { fault, .. } = notice {
                suspects.push(fault);
            }
        });
    }
    Some(suspects)
}

#[test]
fn real_logs_with_right_sensors_are_not_suspect() {
    for name in [
        "logs/px4-quad-vibration-2025.ulg",
        "logs/px4-quad-motor-failure.ulg",
        "logs/sample_log_small.ulg",
        "logs/sample_appended_multiple.ulg",
        "logs/sample_logging_tagged_and_default_params.ulg",
        "logs/ardupilot-short.bin",
        "cases/clock-step-back-60s.ulg",
        "cases/gps-0-no-fix-gps-1-good.bin",
        "cases/imu-0-marked-unhealthy.bin",
        "cases/null-island.bin",
        "cases/null-island.ulg",
        "cases/rosbag2-split",
        "cases/gps-insane-60s",
        "cases/position-jump-then-right",
        "cases/barometer-while-heading-unknown",
        "cases/pole-89.9",
    ] {
        let Some(found) = suspects(name) else { continue };
        assert_eq!(found, [], "{name}");
    }
}

#[test]
fn a_board_that_lies_on_its_back_is_suspect() {
    let Some(found) = suspects("logs/ardupilot-bench.bin") else { return };
    assert!(
        matches!(found[..], [SetupFault::ForceDirection { up: [_, _, z] }] if z > 0.9),
        "{found:?}"
    );
}

#[test]
fn velocities_of_zero_are_named_and_not_taken_for_a_wrong_sign() {
    let Some(found) = suspects("cases/velocity-all-zero") else { return };
    assert!(matches!(found[..], [SetupFault::VelocityZero { .. }]), "{found:?}");
}
