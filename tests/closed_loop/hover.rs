//! The complete closed loop of the nonlinear 60-class helicopter.

use approx::assert_abs_diff_eq;
use hovernav::autopilot::{Mode, Reason, SetPoint};
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::frames::{Vector, wrap_angle};
use hovernav_dataset::Dataset;
use hovernav_replay::estimate;
use hovernav_sim::{Feedback, Flight, FlightConfig, FlightEvent, FlightSample, WindConfig};

use crate::{STATES, STOP, allowed_s, autopilot, disturbances, settled_s};

/// The loops alone, without sensor errors and wind.
fn calm(duration_s: f64, events: Vec<(f64, FlightEvent)>) -> Flight {
    let config = FlightConfig {
        feedback: Feedback::Truth,
        wind: WindConfig::calm(),
        engage_s: 0.5,
        duration_s,
        events,
        ..FlightConfig::new(autopilot())
    };
    let flight = config.fly().unwrap();
    assert_eq!(flight.crashed_s, None);
    flight
}

/// phi, theta, psi, p, q, r, u, v, w.
fn states(sample: &FlightSample) -> [f64; 9] {
    let truth = &sample.truth;
    let angles = truth.body_to_ned.euler();
    let [p, q, r] = truth.angular_rate_radps.to_array();
    let [u, v, w] = (truth.body_to_ned.inverse() * truth.velocity_mps).to_array();
    [angles.roll_rad, angles.pitch_rad, angles.yaw_rad, p, q, r, u, v, w]
}

fn seconds(sample: &FlightSample) -> f64 {
    sample.truth.time.seconds()
}

#[test]
fn each_disturbance_of_table_6_1_is_back_at_trim_in_time() {
    for (name, size, disturbance) in disturbances() {
        let flight = calm(
            24.0,
            vec![(1.0, FlightEvent::SetPoint(STOP)), (10.0, FlightEvent::Disturb(disturbance))],
        );
        let (before, after): (Vec<_>, Vec<_>) =
            flight.samples.iter().partition(|sample| seconds(sample) < 9.999);
        let trim = states(before.last().unwrap());
        let state = STATES.iter().position(|state| *state == name).unwrap();
        let away = after.iter().map(|sample| states(sample)[state] - trim[state]);
        let settled = settled_s(away, 1.0 / 33.0, 0.02 * size);
        println!("60-class, {name} {size}: {settled:.2} s");
        assert!(settled <= allowed_s(name), "{name}: {settled} s");
    }
}

#[test]
fn it_moves_from_hover_to_hover_and_turns_on_the_way() {
    let start = FlightConfig::new(autopilot()).start;
    let goal = start.displaced(Vector::new(15.0, -20.0, -5.0));
    let order = SetPoint::Position { position: goal, heading_rad: Some(-2.0) };
    let flight = calm(60.0, vec![(3.0, FlightEvent::SetPoint(order))]);
    let last = flight.samples.last().unwrap().truth;
    assert!(last.position.displacement_from(&goal).norm() < 0.3);
    assert!(wrap_angle(last.body_to_ned.euler().yaw_rad + 2.0).abs() < 0.02);
    let fastest = flight.samples.iter().map(|m| m.truth.velocity_mps.norm()).fold(0.0, f64::max);
    assert!(fastest > 2.0 && fastest < 6.0, "{fastest}");
}

#[test]
fn it_flies_slowly_forward_and_stops_where_commanded() {
    let forward = SetPoint::Velocity {
        forward_mps: 4.0,
        right_mps: 0.0,
        down_mps: -0.5,
        yaw_rate_radps: 0.1,
    };
    let flight = calm(
        50.0,
        vec![(2.0, FlightEvent::SetPoint(forward)), (20.0, FlightEvent::SetPoint(SetPoint::Hold))],
    );
    let at = |s: f64| flight.samples.iter().find(|sample| seconds(sample) >= s).unwrap();
    let cruise = at(19.5).truth;
    assert_abs_diff_eq!(cruise.velocity_mps.x().hypot(cruise.velocity_mps.y()), 4.0, epsilon = 0.3);
    assert_abs_diff_eq!(cruise.velocity_mps.z(), -0.5, epsilon = 0.1);
    assert_abs_diff_eq!(cruise.angular_rate_radps.z(), 0.1, epsilon = 0.02);
    let end = flight.samples.last().unwrap().truth;
    assert!(end.velocity_mps.norm() < 0.05);
    assert!(end.position.displacement_from(&at(40.0).truth.position).norm() < 0.3);
}

#[test]
fn the_pilot_takes_over_in_flight_and_the_autopilot_after_him() {
    let mut config = FlightConfig::new(autopilot());
    config.duration_s = 40.0;
    // The stick moves 0.3 from the pilot's last position; then the switch is opened and closed.
    config.events = vec![
        (25.0, FlightEvent::PilotSticks(Sticks { lateral: 0.3, ..Sticks::NEUTRAL })),
        (25.4, FlightEvent::PilotSticks(Sticks::NEUTRAL)),
        (26.0, FlightEvent::Engage(false)),
        (26.5, FlightEvent::Engage(true)),
    ];
    let flight = config.fly().unwrap();
    assert_eq!(flight.crashed_s, None);
    let changes: Vec<_> = flight.transitions.iter().map(|t| (t.to, t.reason)).collect();
    assert_eq!(
        changes,
        [
            (Mode::Position, Reason::Switch),
            (Mode::Manual, Reason::Override),
            (Mode::Position, Reason::Switch),
        ]
    );
    for pair in flight.samples.windows(2) {
        let (before, after) = (pair[0].sticks.to_array(), pair[1].sticks.to_array());
        let changed = pair[0].mode != pair[1].mode;
        let moved = before.iter().zip(after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(!changed || moved < 1e-9, "a bump of {moved} at {}", seconds(&pair[1]));
    }
}

#[test]
fn a_gps_outage_of_20_s_is_survived_and_followed_by_a_hover() {
    for seed in 1..4 {
        let mut config = FlightConfig { seed, duration_s: 120.0, ..FlightConfig::new(autopilot()) };
        config.gps.outages_s = vec![60.0..80.0];
        let flight = config.fly().unwrap();
        println!("outage, seed {seed}: {:?}", flight.transitions);
        assert_eq!(flight.crashed_s, None);
        assert_eq!(flight.samples.last().unwrap().mode, Mode::Position);
        assert!(flight.transitions.iter().any(|t| t.to == Mode::Attitude));
        let tilt = flight.samples.iter().map(|m| {
            let angles = m.truth.body_to_ned.euler();
            angles.roll_rad.abs().max(angles.pitch_rad.abs())
        });
        assert!(tilt.fold(0.0, f64::max) < 0.4);
    }
}

#[test]
fn a_frozen_receiver_is_not_flown_after() {
    for seed in 1..4 {
        let mut config = FlightConfig { seed, duration_s: 120.0, ..FlightConfig::new(autopilot()) };
        config.gps.frozen_s = vec![60.0..75.0];
        let flight = config.fly().unwrap();
        println!("frozen, seed {seed}: {:?}", flight.transitions);
        assert_eq!(flight.crashed_s, None);
        let frozen = flight.samples.iter().filter(|m| (63.0..74.0).contains(&seconds(m)));
        assert!(frozen.clone().all(|m| !m.mode.holds_velocity()));
        assert!(frozen.clone().all(|m| m.mode != Mode::Neutral));
        assert_eq!(flight.samples.last().unwrap().mode, Mode::Position);
    }
}

#[test]
fn a_seed_is_a_flight() {
    let config = FlightConfig { duration_s: 30.0, ..FlightConfig::new(autopilot()) };
    let (one, two) = (config.fly().unwrap(), config.fly().unwrap());
    assert_eq!(one.samples, two.samples);
    let other = FlightConfig { seed: 2, ..config }.fly().unwrap();
    assert_ne!(one.samples.last(), other.samples.last());
}

#[test]
fn the_record_replayed_gives_what_the_autopilot_flew_on() {
    let config = FlightConfig { duration_s: 40.0, ..FlightConfig::new(autopilot()) };
    let flight = config.fly().unwrap();
    let (dataset, truth) = flight.dataset();
    let dir = tempfile::tempdir().unwrap();
    dataset.write(dir.path(), &truth).unwrap();
    let mut read = Dataset::open(dir.path()).unwrap();
    assert_eq!(read.controls.len(), flight.samples.len());
    let settings = read.settings().unwrap();
    let replayed = estimate(&read, &settings, |_| {}).solutions;
    // A solution is replayed as of the sample, before a fix or height of the same sample.
    let aided = |time| {
        flight.fixes.iter().any(|fix| fix.time == time)
            || flight.baro.iter().any(|(measured, _)| *measured == time)
    };
    let flown = flight.samples.iter().filter_map(|sample| sample.solution);
    let mut compared = 0;
    for flown in flown.filter(|solution| !aided(solution.time)) {
        let again = replayed.iter().find(|solution| solution.time == flown.time).unwrap();
        assert!((again.velocity_mps - flown.velocity_mps).norm() < 1e-9, "{}", flown.time);
        compared += 1;
    }
    assert!(compared > 600, "{compared}");
}

#[test]
fn a_hover_that_starts_at_the_ellipsoid_has_room_below_it() {
    for seed in 11..14 {
        let mut config = FlightConfig::new(autopilot());
        config.start_at(Geodetic::from_degrees(48.0, 11.0, 0.0).unwrap());
        (config.seed, config.duration_s) = (seed, 120.0);
        assert_eq!(config.fly().unwrap().crashed_s, None, "seed {seed}");
    }
}
