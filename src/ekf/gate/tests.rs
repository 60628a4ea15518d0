//! The choice between a sensor and the filter, and the time until the sensor is accepted.

use super::*;
use crate::ekf::settings::config::GateConfig;

/// An innovation with a one-sigma of 3.
fn off(innovation: f64) -> Off {
    Off { axes: [innovation, 0.0], variance: 9.0 }
}

/// Time, s, until a height with offset `off_m` is accepted after `right_s` of correct heights. A barometer and the
/// receiver's own vertical velocity agree with the filter throughout.
fn accepted_after_s(right_s: i64, off_m: impl Fn(f64) -> f64) -> Option<f64> {
    let (mut gates, config) = (Gates::NONE, GateConfig::default());
    (0..5 * (right_s + 300)).find_map(|step| {
        let time = Time::from_nanoseconds(step * 200_000_000);
        for group in [Group::Baro, Group::VerticalVelocity] {
            gates.is_biased(group, time, &off(0.0));
            gates.accepted(group, time, &off(0.0), 1.0);
        }
        let wrong_s = (step - 5 * right_s) as f64 * 0.2;
        if wrong_s < 0.0 {
            gates.accepted(Group::VerticalPosition, time, &off(0.0), 1.0);
            return None;
        }
        let off = off(off_m(wrong_s));
        gates.note_rejection(Group::VerticalPosition, time, &off, &config).map(|_| wrong_s)
    })
}

#[test]
fn a_level_in_dispute_is_settled_by_who_was_right_for_longer() {
    for (right_s, max_s) in [(5, 30.0), (40, 40.0), (100, 100.0), (1000, 120.0)] {
        let after_s = accepted_after_s(right_s, |_| 50.0).unwrap();
        assert!((after_s - max_s).abs() < 1.0, "{right_s} s: {after_s}");
    }
}

#[test]
fn a_height_that_drifts_away_from_a_barometer_is_not_believed() {
    assert_eq!(accepted_after_s(40, |wrong_s| 20.0 + wrong_s), None);
}

#[test]
fn a_place_that_jumps_is_believed_once_it_was_told_for_as_long_as_the_one_before() {
    for (reported_s, accepted_s) in [(3.0, 3.0), (12.0, 12.0), (100.0, 30.0)] {
        let (mut gates, config) = (Gates::NONE, GateConfig::default());
        let after_s = (0..200).find_map(|second| {
            let time = Time::ZERO + f64::from(second);
            gates.accepted(Group::HorizontalVelocity, time, &off(0.0), 1.0);
            if second == 0 {
                gates.forget_position();
            }
            let wrong_s = f64::from(second) - reported_s - 1.0;
            if wrong_s < 0.0 {
                gates.accepted(Group::HorizontalPosition, time, &off(0.0), 1.0);
                return None;
            }
            let off = off(40.0);
            gates.note_rejection(Group::HorizontalPosition, time, &off, &config).map(|_| wrong_s)
        });
        assert_eq!(after_s, Some(accepted_s));
    }
}

#[test]
fn a_height_that_jumps_after_the_heading_was_found_is_a_fault_of_the_receiver() {
    let (mut gates, config) = (Gates::NONE, GateConfig::default());
    let after_s = (0..100).find_map(|second| {
        let time = Time::ZERO + f64::from(second);
        if second == 20 {
            gates.heading_replaced = time;
        }
        gates.accepted(Group::VerticalVelocity, time, &off(0.0), 1.0);
        if second < 40 {
            gates.accepted(Group::VerticalPosition, time, &off(0.0), 1.0);
            return None;
        }
        let reset = gates.note_rejection(Group::VerticalPosition, time, &off(100.0), &config);
        reset.map(|_| second - 40)
    });
    assert_eq!(after_s, Some(30));
}

/// A position reported for `reported_s` jumps by 40 m, with a receiver that agrees in velocity throughout. Returns the
/// ambiguity, m, `seconds` after the jump, and the time, s, until the previous position is accepted again.
fn ambiguity_after(reported_s: i32, seconds: i32) -> (f32, Option<i32>) {
    let (mut gates, config) = (Gates::NONE, GateConfig::default());
    let report_fix = |gates: &mut Gates, second: i32, off_m: f64| {
        let time = Time::ZERO + f64::from(second);
        gates.accepted(Group::HorizontalVelocity, time, &off(0.0), 1.0);
        if off_m == 0.0 {
            gates.accepted(Group::HorizontalPosition, time, &off(0.0), 1.0);
            return false;
        }
        let is_reset =
            gates.note_rejection(Group::HorizontalPosition, time, &off(off_m), &config).is_some();
        if is_reset {
            gates.shift_position([off_m as f32, 0.0, 0.0]);
        }
        is_reset
    };
    let mut off_m = 40.0;
    for second in 0..reported_s + seconds {
        let is_off = second >= reported_s && off_m > 0.0;
        if report_fix(&mut gates, second, if is_off { off_m } else { 0.0 }) {
            off_m = 0.0;
        }
    }
    let ambiguity_m = gates.ambiguity_m()[0];
    let back = (0..60).find(|second| report_fix(&mut gates, reported_s + seconds + second, -40.0));
    (ambiguity_m, back)
}

#[test]
fn a_place_believed_by_its_word_alone_stays_in_dispute_for_as_long_as_the_one_before_was_told() {
    assert_eq!(ambiguity_after(300, 20), (0.0, Some(10)));
    assert_eq!(ambiguity_after(300, 31).0, 40.0);
    let (left_m, back_s) = ambiguity_after(300, 90);
    assert!((25.0..32.0).contains(&left_m) && back_s == Some(2), "{left_m} {back_s:?}");
    let (left_m, _) = ambiguity_after(300, 630);
    assert!((1.0..3.0).contains(&left_m), "{left_m}");
    // A position reported for ten seconds is outweighed sooner.
    let (left_m, _) = ambiguity_after(11, 70);
    assert!(left_m < 0.5, "{left_m}");
}

/// Gates whose receiver's positions drift north by `moved_m` each second for `seconds`, after a minute without drift.
fn drifted(seconds: i32, moved_m: f32) -> Gates {
    let mut gates = Gates::NONE;
    for second in 0..60 + seconds {
        let time = Time::ZERO + f64::from(second);
        gates.accepted(Group::HorizontalVelocity, time, &off(0.0), 1.0);
        gates.accepted(Group::HorizontalPosition, time, &off(0.0), 1.0);
        let moved_m = if second < 60 { 0.0 } else { moved_m };
        gates.shift_position([moved_m, 0.0, 0.0]);
        let drifted_m = gates.observe_position_shift(time, [moved_m, 0.0], 8.0);
        assert!(drifted_m == 0.0 || drifted_m > 8.0, "{drifted_m} m at {second} s");
    }
    gates
}

#[test]
fn a_place_that_walks_away_from_its_own_velocity_is_in_dispute_with_where_the_walk_began() {
    // At 0.3 m/s the memory of 20 s never holds more than 6 m.
    assert_eq!(drifted(200, 0.3).ambiguity_m()[0], 0.0);
    assert_eq!(drifted(8, 1.0).ambiguity_m()[0], 0.0);
    let ambiguity_m = drifted(40, 1.0).ambiguity_m()[0];
    assert!((20.0..40.0).contains(&ambiguity_m), "{ambiguity_m} m of 40");
    // Faulty samples, or a velocity that is not fused, explain the shift otherwise.
    let mut gates = drifted(8, 1.0);
    gates.suspected = Time::ZERO + 68.0;
    assert_eq!(gates.observe_position_shift(Time::ZERO + 68.0, [20.0, 0.0], 8.0), 0.0);
    let mut gates = drifted(8, 1.0);
    assert_eq!(gates.observe_position_shift(Time::ZERO + 72.0, [20.0, 0.0], 8.0), 0.0);
}

#[test]
fn a_place_that_walks_back_is_in_dispute_no_longer() {
    let mut gates = drifted(40, 1.0);
    // In 31 s the position drifts by the distance to the second hypothesis.
    let left_m: Vec<f32> = (100..131)
        .map(|second| {
            let time = Time::ZERO + f64::from(second);
            gates.accepted(Group::HorizontalVelocity, time, &off(0.0), 1.0);
            gates.accepted(Group::HorizontalPosition, time, &off(0.0), 1.0);
            gates.shift_position([-1.0, 0.0, 0.0]);
            gates.observe_position_shift(time, [-1.0, 0.0], 8.0);
            gates.ambiguity_m()[0]
        })
        .collect();
    assert!(left_m.is_sorted_by(|before, after| after <= before), "{left_m:?}");
    assert!(left_m.last() < Some(&0.2), "{left_m:?}");
}
