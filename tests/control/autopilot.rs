//! Guarantees of the autopilot in every mode: no bump, the pilot's priority, and rejection of invalid inputs.

use approx::assert_abs_diff_eq;
use hovernav::autopilot::*;
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::health::Distrust;
use hovernav::time::Time;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use proptest::prelude::*;

pub const PERIOD_S: f64 = 1.0 / 33.0;

pub fn config() -> HoverConfig {
    let gains = HoverDesign::default().synthesise(&shipped::raptor60()).unwrap();
    HoverConfig::new(PERIOD_S, gains)
}

/// A vehicle that hovers, with an accurate estimate.
pub fn hovering() -> Solution {
    Solution {
        body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(3.0, 0.5, 40.0)),
        position_sigma_m: Vector::new(1.0, 1.0, 1.5),
        velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
        attitude_sigma_rad: [0.01, 0.01, 0.03],
        ..Solution::at_rest(Time::ZERO, Geodetic::from_degrees(1.35, 103.82, 50.0).unwrap())
    }
}

pub const PILOT: Sticks =
    Sticks { lateral: 0.06, longitudinal: -0.04, collective: 0.12, pedal: -0.05 };

/// An autopilot and its current time.
pub struct Bench {
    pub autopilot: HoverAutopilot,
    step: u64,
}

impl Bench {
    pub fn new() -> Self {
        Self { autopilot: HoverAutopilot::new(config()).unwrap(), step: 0 }
    }

    /// One step with an estimate whose time is the time of the step.
    pub fn step(
        &mut self,
        solution: Option<Solution>,
        pilot: Option<Sticks>,
        engage: bool,
    ) -> Outputs {
        self.step += 1;
        let now = Time::ZERO + self.step as f64 * PERIOD_S;
        let solution = solution.map(|solution| Solution { time: now, ..solution });
        self.autopilot.step(&Inputs { now, solution: solution.as_ref(), pilot, engage })
    }

    fn steps(
        &mut self,
        seconds: f64,
        solution: Option<Solution>,
        pilot: Option<Sticks>,
        engage: bool,
    ) -> Outputs {
        let count = (seconds / PERIOD_S).round() as usize;
        let mut last = self.step(solution, pilot, engage);
        for _ in 1..count {
            last = self.step(solution, pilot, engage);
        }
        last
    }

    /// The vehicle is flown by the pilot for a while, then by the autopilot.
    fn engaged() -> Self {
        let mut bench = Self::new();
        bench.steps(5.0, Some(hovering()), Some(PILOT), false);
        let outputs = bench.steps(3.0, Some(hovering()), Some(PILOT), true);
        assert_eq!(outputs.mode, Mode::Position);
        bench
    }
}

fn apart(a: Sticks, b: Sticks) -> f64 {
    let (a, b) = (a.to_array(), b.to_array());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn in_manual_the_sticks_are_the_pilots() {
    let mut bench = Bench::new();
    let outputs = bench.steps(2.0, Some(hovering()), Some(PILOT), false);
    assert_eq!(outputs.mode, Mode::Manual);
    assert!(apart(outputs.sticks, PILOT) < 1e-3);
    let moved = Sticks { lateral: 0.9, ..PILOT };
    assert!(apart(bench.step(Some(hovering()), Some(moved), false).sticks, moved) < 1e-3);
}

#[test]
fn taking_over_does_not_move_a_stick_whatever_the_motion() {
    let mut bench = Bench::new();
    bench.steps(5.0, Some(hovering()), Some(PILOT), false);
    let moving = Solution {
        velocity_mps: Vector::new(1.5, -1.0, 0.4),
        angular_rate_radps: Vector::new(0.2, -0.1, 0.1),
        body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(-6.0, 4.0, 40.0)),
        ..hovering()
    };
    let before = bench.step(Some(moving), Some(PILOT), false);
    let after = bench.step(Some(moving), Some(PILOT), true);
    assert_eq!(after.transition.unwrap().reason, Reason::Switch);
    assert!(apart(before.sticks, after.sticks) < 1e-12);
    let next = bench.step(Some(moving), Some(PILOT), true);
    assert!(apart(next.sticks, after.sticks) < 0.05, "{:?} {:?}", next.sticks, after.sticks);
}

#[test]
fn giving_back_does_not_move_a_stick_and_ends_at_the_pilots() {
    let mut bench = Bench::engaged();
    let drifting = Solution { velocity_mps: Vector::new(0.5, 0.3, 0.0), ..hovering() };
    let before = bench.steps(1.0, Some(drifting), Some(PILOT), true);
    let after = bench.step(Some(drifting), Some(PILOT), false);
    assert_eq!(after.mode, Mode::Manual);
    assert!(apart(before.sticks, after.sticks) < 1e-12);
    let end = bench.steps(1.5, Some(drifting), Some(PILOT), false);
    assert!(apart(end.sticks, PILOT) < 1e-2);
}

#[test]
fn a_moved_stick_overrides_at_once_and_for_good() {
    let mut bench = Bench::engaged();
    let pulled = Sticks { longitudinal: PILOT.longitudinal + 0.3, ..PILOT };
    let outputs = bench.step(Some(hovering()), Some(pulled), true);
    assert_eq!(outputs.mode, Mode::Manual);
    assert_eq!(outputs.transition.unwrap().reason, Reason::Override);
    let released = bench.steps(3.0, Some(hovering()), Some(PILOT), true);
    assert_eq!(released.mode, Mode::Manual);
    bench.step(Some(hovering()), Some(PILOT), false);
    assert_eq!(bench.step(Some(hovering()), Some(PILOT), true).mode, Mode::Position);
}

#[test]
fn the_pilots_moving_stick_shows_in_the_very_first_command_after_an_override() {
    let mut bench = Bench::engaged();
    let pulled = Sticks { longitudinal: PILOT.longitudinal + 0.3, ..PILOT };
    let first = bench.step(Some(hovering()), Some(pulled), true);
    let more = Sticks { longitudinal: pulled.longitudinal + 0.2, ..pulled };
    let second = bench.step(Some(hovering()), Some(more), true);
    assert!(second.sticks.longitudinal - first.sticks.longitudinal > 0.2);
}

#[test]
fn without_an_attitude_it_does_not_take_over() {
    let mut bench = Bench::new();
    let outputs = bench.steps(2.0, None, Some(PILOT), true);
    assert_eq!(outputs.mode, Mode::Manual);
    assert!(apart(outputs.sticks, PILOT) < 1e-3);
}

#[test]
fn nan_from_the_estimator_lets_the_last_good_command_decay_to_trim() {
    let mut bench = Bench::engaged();
    let drifting = Solution { velocity_mps: Vector::new(0.8, 0.5, 0.0), ..hovering() };
    let last = bench.steps(0.5, Some(drifting), Some(PILOT), true).sticks;
    let trim = bench.autopilot.learned_trim().sticks;
    let lost = Solution { velocity_mps: Vector::new(f64::NAN, 0.0, 0.0), ..drifting };
    let first = bench.step(Some(lost), Some(PILOT), true);
    assert_eq!(first.mode, Mode::Neutral);
    let transition = first.transition.unwrap();
    assert_eq!(transition.reason, Reason::Distrust(Distrust::NotFinite));
    assert_eq!(bench.autopilot.last_transition(), Some(transition));
    let mut distance = apart(last, trim);
    assert!(distance > 0.05, "{distance}");
    for _ in 0..200 {
        let sticks = bench.step(Some(lost), Some(PILOT), true).sticks;
        assert!(sticks.is_finite());
        assert!(apart(sticks, trim) <= distance);
        distance = apart(sticks, trim);
    }
    assert!(distance < 1e-3);
}

#[test]
fn it_flies_again_only_after_the_estimate_has_been_good_for_a_while() {
    let mut bench = Bench::engaged();
    assert_eq!(bench.steps(2.0, None, Some(PILOT), true).mode, Mode::Neutral);
    assert_eq!(bench.steps(0.9, Some(hovering()), Some(PILOT), true).mode, Mode::Neutral);
    let back = bench.steps(0.2, Some(hovering()), Some(PILOT), true);
    assert_eq!(back.mode, Mode::Position);
    assert_eq!(bench.autopilot.last_transition().unwrap().reason, Reason::Recovered);
}

#[test]
fn an_estimate_that_stands_still_is_stale() {
    let mut bench = Bench::engaged();
    let old = Solution { time: Time::ZERO + bench.step as f64 * PERIOD_S, ..hovering() };
    let mut last = None;
    for k in 1..20 {
        let now = old.time + f64::from(k) * PERIOD_S;
        let inputs = Inputs { now, solution: Some(&old), pilot: Some(PILOT), engage: true };
        last = bench.autopilot.step(&inputs).transition.or(last);
    }
    assert_eq!(last.unwrap().reason, Reason::Distrust(Distrust::Stale));
    assert_eq!(last.unwrap().to, Mode::Neutral);
}

#[test]
fn it_degrades_with_what_is_known_down_to_a_descent() {
    let mut bench = Bench::engaged();
    let adrift = Solution { position_sigma_m: Vector::new(30.0, 30.0, 5.0), ..hovering() };
    let outputs = bench.step(Some(adrift), Some(PILOT), true);
    assert_eq!(outputs.mode, Mode::Velocity);
    assert_eq!(outputs.transition.unwrap().reason, Reason::Distrust(Distrust::Position));
    let blind = Solution { velocity_sigma_mps: Vector::new(3.0, 3.0, 3.0), ..adrift };
    let outputs = bench.step(Some(blind), Some(PILOT), true);
    assert_eq!(outputs.mode, Mode::Attitude);
    let collective = outputs.sticks.collective;
    let patience_s = config().transfer.patience_s;
    assert_eq!(bench.steps(patience_s - 1.0, Some(blind), Some(PILOT), true).mode, Mode::Attitude);
    let outputs = bench.steps(6.0, Some(blind), Some(PILOT), true);
    assert_eq!(outputs.mode, Mode::Descent);
    assert!(outputs.sticks.collective < collective - 0.03);
    assert_eq!(bench.steps(1.5, Some(hovering()), Some(PILOT), true).mode, Mode::Position);
}

#[test]
fn a_tilted_vehicle_is_levelled_even_without_velocity() {
    let mut bench = Bench::engaged();
    let tilted = Solution {
        velocity_sigma_mps: Vector::new(3.0, 3.0, 3.0),
        body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(13.0, 0.5, 40.0)),
        ..hovering()
    };
    let trim = bench.autopilot.learned_trim().sticks;
    let outputs = bench.steps(1.0, Some(tilted), Some(PILOT), true);
    assert!(outputs.sticks.lateral < trim.lateral - 0.05, "rolled right: lateral goes left");
}

#[test]
fn trim_is_learned_from_the_pilots_hover() {
    let mut bench = Bench::new();
    bench.steps(60.0, Some(hovering()), Some(PILOT), false);
    let trim = bench.autopilot.learned_trim();
    assert!(apart(trim.sticks, PILOT) < 1e-2);
    assert_abs_diff_eq!(trim.roll_rad.to_degrees(), 3.0, epsilon = 0.1);
}

#[test]
fn set_points_that_cannot_be_flown_are_refused_and_the_old_one_stays() {
    let mut bench = Bench::engaged();
    let velocity = |forward_mps| SetPoint::Velocity {
        forward_mps,
        right_mps: 0.0,
        down_mps: 0.0,
        yaw_rate_radps: 0.0,
    };
    assert_eq!(bench.autopilot.set(velocity(2.0)), Ok(()));
    assert_eq!(bench.autopilot.set(velocity(f64::NAN)), Err(SetPointError::NotFinite));
    assert_eq!(bench.autopilot.set(velocity(50.0)), Err(SetPointError::TooFast));
    let level = bench.step(Some(hovering()), Some(PILOT), true).sticks.longitudinal;
    // Forward flight is still commanded: the nose goes down.
    let later = bench.steps(1.0, Some(hovering()), Some(PILOT), true).sticks.longitudinal;
    assert!(later < level - 0.05, "{later} {level}");
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -10.0..10.0,
        1 => prop::num::f64::ANY,
        1 => Just(f64::NAN),
    ]
}

fn any_vector<F: std::fmt::Debug>() -> impl Strategy<Value = Vector<F>> {
    prop::array::uniform3(any_number()).prop_map(Vector::from)
}

prop_compose! {
    fn any_solution()(
        velocity_mps in any_vector(),
        angular_rate_radps in any_vector(),
        angles in prop::array::uniform3(-3.0..3.0),
        velocity_sigma_mps in any_vector(),
        position_sigma_m in any_vector(),
        height_m in any_number(),
        age in prop_oneof![9 => Just(0.0), 1 => -1.0..1.0],
    ) -> Solution {
        let [roll_rad, pitch_rad, yaw_rad] = angles;
        let position = Geodetic { height_m, ..hovering().position };
        Solution {
            time: Time::ZERO + age,
            position,
            velocity_mps,
            angular_rate_radps,
            body_to_ned: Rotation::from_euler(EulerAngles { roll_rad, pitch_rad, yaw_rad }),
            velocity_sigma_mps,
            position_sigma_m,
            ..hovering()
        }
    }
}

proptest! {
    #[test]
    fn whatever_comes_in_what_goes_out_keeps_to_range_and_rate(
        inputs in prop::collection::vec(
            (
                prop::option::weighted(0.9, any_solution()),
                prop::option::weighted(0.9, prop::array::uniform4(any_number())),
                prop::bool::weighted(0.9),
            ),
            1..60,
        ),
    ) {
        let config = config_once();
        let mut autopilot = HoverAutopilot::new(*config).unwrap();
        let mut last = config.trim.sticks;
        for (k, (solution, pilot, engage)) in inputs.into_iter().enumerate() {
            let now = Time::ZERO + k as f64 * PERIOD_S;
            let solution = solution.map(|s| Solution { time: now + (s.time - Time::ZERO), ..s });
            let outputs = autopilot.step(&Inputs {
                now,
                solution: solution.as_ref(),
                pilot: pilot.map(Sticks::from_array),
                engage,
            });
            let sticks = outputs.sticks;
            // The pilot's own sticks are passed on up to the limit of a transmitter. From beyond full travel the
            // autopilot returns at its rate limit.
            for (stick, last) in sticks.to_array().into_iter().zip(last.to_array()) {
                let most = match outputs.mode {
                    Mode::Manual => FARTHEST_PILOT,
                    _ => f64::max(1.0, last.abs() - 4.0 * PERIOD_S + 1e-9),
                };
                prop_assert!((-most..=most).contains(&stick), "{stick} beyond {most}");
            }
            if outputs.mode != Mode::Manual {
                prop_assert!(apart(sticks, last) <= 4.0 * PERIOD_S + 1e-9);
            }
            last = sticks;
        }
    }
}

fn config_once() -> &'static HoverConfig {
    static CONFIG: std::sync::OnceLock<HoverConfig> = std::sync::OnceLock::new();
    CONFIG.get_or_init(config)
}
