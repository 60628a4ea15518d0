//! Set-points and the references that follow them.

use super::*;
use crate::ekf::Solution;
use crate::time::Time;
use approx::assert_abs_diff_eq;

fn at(position: Geodetic, velocity_mps: Vector<Ned>) -> Solution {
    Solution { velocity_mps, ..Solution::at_rest(Time::ZERO, position) }
}

/// A stop from 3 m/s, then a return from a position jump of 4 m. Acceleration and jerk stay within their bounds,
/// and the commanded velocity does not overshoot.
#[test]
fn neither_velocity_nor_acceleration_asked_for_jumps() {
    let place = Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap();
    let config = GuidanceConfig::default();
    for period_s in [0.01, 0.0303, 0.2, 0.5] {
        let mut guidance = Guidance::new(config, period_s);
        let mut solution = at(place, Vector::new(3.0, -1.0, 0.5));
        guidance.engage(&solution, 0.0);
        let trusted = Trusted { position: true, heading: true, sink_mps: None };
        let mut before = guidance.reference;
        let steps = (40.0 / period_s) as usize;
        for step in 0..steps {
            if step == steps / 2 {
                assert!(guidance.station.is_some(), "{period_s} s: {before:?}");
                assert!(before.velocity_mps.norm() < 0.01, "{period_s} s: {before:?}");
                solution.position = place.displaced(Vector::new(4.0, 0.0, 0.0));
            }
            let now = guidance.step(&solution, 0.0, trusted);
            let [north, east, down] = (now.acceleration_mps2 - before.acceleration_mps2).to_array();
            let most = HARDEST_JERK_MPS3 * period_s + 1e-9;
            assert!(north.hypot(east) <= most && down.abs() <= most);
            let [north, east, down] = now.acceleration_mps2.to_array();
            assert!(north.hypot(east) <= config.acceleration_mps2 + 1e-9);
            assert!(down.abs() <= config.climb_acceleration_mps2 + 1e-9);
            before = now;
            assert!(now.velocity_mps.x() > -1.06, "{period_s} s: {:?}", now.velocity_mps);
        }
        assert!((before.velocity_mps - Vector::new(-1.0, 0.0, 0.0)).norm() < 0.02);
    }
}

/// At 5 m/s and 1 m/s² a turn is at most 0.16 rad/s: the commanded velocity stays along the heading.
#[test]
fn a_turn_in_forward_flight_is_as_fast_as_the_velocity_can_turn() {
    let place = Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap();
    let trusted = Trusted { position: true, heading: true, sink_mps: None };
    let mut guidance = Guidance::new(GuidanceConfig::default(), 0.02);
    guidance.engage(&at(place, Vector::ZERO), 0.0);
    let (right_mps, down_mps) = (0.0, 0.0);
    let turn = SetPoint::Velocity { forward_mps: 5.0, right_mps, down_mps, yaw_rate_radps: 0.5 };
    guidance.accept(turn).unwrap();
    let mut yaw_rad = 0.0;
    for step in 0..3_000 {
        let mut solution = at(place, guidance.reference().0);
        solution.body_to_ned = crate::frames::Rotation::from_euler(crate::frames::EulerAngles {
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad,
        });
        let asked = guidance.step(&solution, yaw_rad, trusted);
        yaw_rad = asked.heading_rad;
        if step > 1_000 {
            assert_abs_diff_eq!(asked.yaw_rate_radps, 0.16, epsilon = 0.01);
            let [north, east, _] = asked.velocity_mps.to_array();
            let along = north * yaw_rad.cos() + east * yaw_rad.sin();
            assert!(along > 4.9, "{along} m/s along the heading");
        }
    }
}

#[test]
fn a_heading_that_is_held_goes_along_with_its_revision_and_a_given_one_stays() {
    let place = Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap();
    let trusted = Trusted { position: true, heading: true, sink_mps: None };
    let mut guidance = Guidance::new(GuidanceConfig::default(), 0.02);
    let mut solution = at(place, Vector::ZERO);
    solution.heading_revision_rad = -0.3;
    guidance.engage(&solution, 3.1);
    assert_abs_diff_eq!(guidance.step(&solution, 3.1, trusted).heading_rad, 3.1, epsilon = 1e-9);
    // The revision changes by another 0.1 rad while the heading crosses ±π; no turn is commanded.
    solution.heading_revision_rad = -0.2;
    let asked = guidance.step(&solution, wrap_angle(3.2), trusted);
    assert!((asked.heading_rad - wrap_angle(3.2)).abs() < 1e-9, "{asked:?}");
    assert!(asked.yaw_rate_radps.abs() < 1e-9, "{asked:?}");
    let given = SetPoint::Position { position: place, heading_rad: Some(1.0) };
    guidance.accept(given).unwrap();
    for _ in 0..1_000 {
        solution.heading_revision_rad += 0.001;
        guidance.step(&solution, 0.0, trusted);
    }
    assert!((guidance.reference().1 - 1.0).abs() < 1e-9, "{:?}", guidance.reference());
}
