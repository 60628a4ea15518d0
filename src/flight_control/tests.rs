//! Tests of the choice between pilot and autopilot in each cycle.

use super::*;
use crate::autopilot::{Gains, HoverConfig, SteeringConfig};
use crate::controls::Channel;
use crate::frames::{EulerAngles, Rotation, Vector};
use crate::servo::{ChannelConfig, Swashplate, SwashplateKind};

const PERIOD_S: f64 = 0.03;
const CLOSED_MS: f64 = 1.9;
const OPEN_MS: f64 = 1.1;

fn place(north_m: f64, up_m: f64) -> Geodetic {
    Geodetic::from_degrees(1.35, 103.82, 50.0).unwrap().displaced(Vector::new(north_m, 0.0, -up_m))
}

fn config() -> FlightControlConfig {
    let mut gains = Gains::default();
    gains.heave.tracking_time_s = 1.0;
    gains.heave.proportional = 0.1;
    gains.roll_pitch.measured = [[0.1, 0.0, 0.2, 0.0, 0.0, 0.05], [0.0, 0.1, 0.0, 0.2, -0.05, 0.0]];
    gains.attitude.measured = [[0.1, 0.0, 0.2, 0.0], [0.0, 0.1, 0.0, 0.2]];
    gains.yaw.measured = [[0.2, 0.1]];
    FlightControlConfig::new(HoverConfig::new(PERIOD_S, gains))
}

/// Decisions are the same in both precisions, and widths differ by less than a servo's resolution.
fn agree(double: &ControlOutputs, single: &ControlOutputs) {
    let decided =
        |of: &ControlOutputs| (of.mode, of.signal, of.switch_on, of.readiness.failed_bits());
    assert_eq!(decided(double), decided(single));
    for (a, b) in double.widths_ms.to_array().into_iter().zip(single.widths_ms.to_array()) {
        assert!((a - b).abs() < 1e-5 || a.is_nan() && b.is_nan(), "{double:?} {single:?}");
    }
}

/// A flight in which each input can be made faulty. The same flight also runs in single precision, with the same
/// result.
struct Bench {
    control: FlightControl,
    single: FlightControl<f32>,
    now: Time,
    solution: Option<Solution>,
    stale: bool,
    pulses: PilotPulses,
    pilot_ms: Option<Channels<f64>>,
    aux_ms: Option<f64>,
    fix_age_s: f64,
    late_cycles: u8,
    told: Vec<ControlNotice>,
    last: Option<ControlOutputs>,
}

impl Bench {
    fn new(config: FlightControlConfig) -> Self {
        Self {
            control: FlightControl::new(config).unwrap(),
            single: FlightControl::new(config).unwrap(),
            now: Time::ZERO,
            solution: Some(Solution {
                body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(2.0, 1.0, 40.0)),
                position_sigma_m: Vector::new(1.0, 1.0, 1.0),
                velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
                attitude_sigma_rad: [0.01, 0.01, 0.03],
                ..Solution::at_rest(Time::ZERO, place(0.0, 10.0))
            }),
            stale: false,
            pulses: PilotPulses::default(),
            pilot_ms: Some(Channels { lateral: 1.53, ..Channels::from_fn(|_| 1.5) }),
            aux_ms: Some(OPEN_MS),
            fix_age_s: 0.5,
            late_cycles: 0,
            told: Vec::new(),
            last: None,
        }
    }

    fn cycles(&mut self, count: usize) -> ControlOutputs {
        for _ in 0..count {
            self.now = self.now + PERIOD_S;
            if let Some(solution) = self.solution.as_mut().filter(|_| !self.stale) {
                solution.time = self.now;
            }
            if let Some(widths_ms) = self.pilot_ms {
                for channel in Channel::ALL {
                    self.pulses.channels[channel].push(widths_ms[channel], self.now).unwrap();
                }
            }
            if let Some(width_ms) = self.aux_ms {
                self.pulses.aux.push(width_ms, self.now).unwrap();
            }
            let inputs = ControlInputs {
                now: self.now,
                solution: self.solution.as_ref(),
                fix_age_s: Some(self.fix_age_s),
                pulses: &self.pulses,
                servos_good: true,
                late_cycles: self.late_cycles,
            };
            let told_before = self.told.len();
            let outputs = self.control.step(&inputs, |notice| self.told.push(notice));
            let solution = self.solution.as_ref().map(Solution::cast);
            let inputs = ControlInputs {
                now: self.now,
                solution: solution.as_ref(),
                fix_age_s: inputs.fix_age_s,
                pulses: &self.pulses,
                servos_good: inputs.servos_good,
                late_cycles: self.late_cycles,
            };
            let mut told = Vec::new();
            let single = self.single.step(&inputs, |notice| told.push(notice));
            agree(&outputs, &single);
            let kinds = |told: &[ControlNotice]| -> Vec<_> {
                told.iter().map(core::mem::discriminant).collect()
            };
            assert_eq!(kinds(&self.told[told_before..]), kinds(&told));
            self.last = Some(outputs);
        }
        self.last.unwrap()
    }

    /// A bench in which the autopilot flies.
    fn engaged(config: FlightControlConfig) -> Self {
        let mut bench = Self::new(config);
        bench.cycles(20);
        bench.aux_ms = Some(CLOSED_MS);
        assert_eq!(bench.cycles(10).mode, Mode::Position, "{:?}", bench.told);
        assert!(bench.told.contains(&ControlNotice::Engaged));
        bench.told.clear();
        bench
    }

    fn told(&self, wanted: ControlNotice) -> bool {
        self.told.contains(&wanted)
    }
}

#[test]
fn the_pilots_pulses_pass_to_the_last_bit_until_the_switch_is_closed_and_after_it_is_opened() {
    let mut bench = Bench::engaged(config());
    bench.aux_ms = Some(OPEN_MS);
    assert_eq!(bench.cycles(1).mode, Mode::Manual);
    assert!(bench.told(ControlNotice::Released));
    let later = bench.cycles(400);
    assert_eq!(later.widths_ms, bench.pilot_ms.unwrap());
    let mut manual = Bench::new(config());
    assert_eq!(manual.cycles(1).widths_ms, manual.pilot_ms.unwrap());
}

#[test]
fn a_lost_channel_is_not_taken_for_a_switch_that_was_opened() {
    let mut bench = Bench::engaged(config());
    bench.aux_ms = None;
    assert_eq!(bench.cycles(10).mode, Mode::Manual);
    assert_eq!(bench.told, [ControlNotice::SwitchLost]);
}

#[test]
fn limits_of_the_autopilot_are_none_of_the_pilots() {
    let mut narrow = config();
    narrow.hover.limits.highest = Sticks::from_array([0.02; 4]);
    let mut bench = Bench::new(narrow);
    let full = Channels { pedal: 2.05, ..bench.pilot_ms.unwrap() };
    bench.pilot_ms = Some(full);
    assert_eq!(bench.cycles(3).widths_ms, full);
}

#[test]
fn taking_over_and_giving_back_moves_no_control_by_a_step() {
    let mut bench = Bench::new(config());
    bench.cycles(20);
    let mut before = bench.last.unwrap().sticks.unwrap();
    for aux_ms in [CLOSED_MS, OPEN_MS, CLOSED_MS, OPEN_MS] {
        bench.aux_ms = Some(aux_ms);
        for _ in 0..60 {
            let sticks = bench.cycles(1).sticks.unwrap();
            assert!(sticks.farthest_from(before) < 0.03, "{before:?} to {sticks:?}");
            before = sticks;
        }
    }
}

#[test]
fn what_is_not_ready_is_refused_by_name_and_stays_refused_until_the_switch_is_opened() {
    let mut bench = Bench::new(config());
    bench.fix_age_s = 9.0;
    bench.cycles(20);
    bench.aux_ms = Some(CLOSED_MS);
    assert_eq!(bench.cycles(10).mode, Mode::Manual);
    let readiness = bench.told.iter().find_map(|told| match told {
        ControlNotice::Refused(readiness) => Some(*readiness),
        _ => None,
    });
    let failed: Vec<String> = readiness.unwrap().failed().map(ToString::to_string).collect();
    assert_eq!(failed, ["age of the last fix, s: 9.000, at most 2.5"]);
    bench.fix_age_s = 0.5;
    assert_eq!(bench.cycles(50).mode, Mode::Manual, "the switch was not closed now");
    bench.aux_ms = Some(OPEN_MS);
    bench.cycles(3);
    bench.aux_ms = Some(CLOSED_MS);
    assert_eq!(bench.cycles(10).mode, Mode::Position);
}

#[test]
fn losing_the_aux_channel_alone_is_manual() {
    let mut bench = Bench::engaged(config());
    bench.aux_ms = None;
    assert_eq!(bench.cycles(5).mode, Mode::Manual);
    bench.aux_ms = Some(CLOSED_MS);
    assert_eq!(
        bench.cycles(50).mode,
        Mode::Manual,
        "the switch returns closed, but was not closed now"
    );
}

#[test]
fn without_a_pilot_it_holds_then_descends_and_a_pilot_who_is_back_finds_it_holding() {
    for by_word in [false, true] {
        let mut bench = Bench::engaged(config());
        if by_word {
            bench.pulses.receiver_failsafe = true;
        } else {
            (bench.pilot_ms, bench.aux_ms) = (None, None);
        }
        assert_eq!(bench.cycles(60).mode, Mode::Position);
        assert!(bench.told(ControlNotice::PilotLost) && !bench.told(ControlNotice::DescentStarted));
        bench.cycles(300);
        assert!(bench.told(ControlNotice::DescentStarted));
        bench.pulses.receiver_failsafe = false;
        bench.pilot_ms = Some(Channels::from_fn(|_| 1.5));
        bench.aux_ms = Some(CLOSED_MS);
        assert_eq!(bench.cycles(5).mode, Mode::Position);
        assert!(bench.told(ControlNotice::PilotSignalRestored));
        bench.aux_ms = Some(OPEN_MS);
        assert_eq!(bench.cycles(2).mode, Mode::Manual);
    }
}

#[test]
fn an_estimate_that_ends_gives_the_sticks_to_the_pilot_and_to_trim_without_one() {
    let mut bench = Bench::engaged(config());
    bench.stale = true;
    let outputs = bench.cycles(20);
    // There is only one notice: the pilot, who has the sticks again, needs no notice of trim or of the switch.
    assert_eq!(bench.told, [ControlNotice::HandedBack(HandedBack::NoAttitude)]);
    assert_eq!(outputs.mode, Mode::Manual);
    bench.stale = false;
    assert_eq!(bench.cycles(100).mode, Mode::Manual, "the switch has not been opened");

    let mut bench = Bench::engaged(config());
    (bench.pilot_ms, bench.aux_ms, bench.stale) = (None, None, true);
    assert_eq!(bench.cycles(40).mode, Mode::Neutral);
}

#[test]
fn a_blind_autopilot_hands_over_without_a_jump_there_and_back() {
    let mut bench = Bench::engaged(config());
    let solution = bench.solution.as_mut().unwrap();
    solution.velocity_mps = Vector::new(1.5, 0.0, 0.0);
    let held = bench.cycles(60).sticks.unwrap();
    let pilot = bench.last.unwrap().pilot.unwrap();
    assert!(held.farthest_from(pilot) > 0.05, "the two differ: {held:?}, {pilot:?}");
    bench.stale = true;
    let mut before = held.farthest_from(pilot);
    for cycle in 0..80 {
        let apart = bench.cycles(1).sticks.unwrap().farthest_from(pilot);
        if bench.told(ControlNotice::HandedBack(HandedBack::NoAttitude)) {
            assert!(apart <= before + 1e-9, "{before} to {apart} in cycle {cycle}");
        }
        before = apart;
    }
    assert!(before < 0.01, "the pilot has the sticks");
}

#[test]
fn a_stick_moved_far_and_a_loop_that_is_late_give_the_sticks_back_in_the_same_cycle() {
    let mut bench = Bench::engaged(config());
    bench.pilot_ms = Some(Channels { pedal: 1.8, ..bench.pilot_ms.unwrap() });
    assert_eq!(bench.cycles(1).mode, Mode::Manual);
    assert!(bench.told(ControlNotice::HandedBack(HandedBack::Override)));

    let mut bench = Bench::engaged(config());
    bench.late_cycles = 2;
    assert_eq!(bench.cycles(1).mode, Mode::Position);
    bench.late_cycles = 3;
    assert_eq!(bench.cycles(1).mode, Mode::Manual);
    assert!(bench.told(ControlNotice::HandedBack(HandedBack::Late)));
}

#[test]
fn sticks_that_steer_move_it_and_only_a_hard_one_overrides() {
    let mut config = config();
    config.steering = Some(SteeringConfig::default());
    config.hover.transfer.override_travel = 0.8;
    let mut bench = Bench::engaged(config);
    bench.pilot_ms = Some(Channels { longitudinal: 1.75, ..bench.pilot_ms.unwrap() });
    let holding = bench.last.unwrap().sticks.unwrap();
    let moving = bench.cycles(60);
    assert_eq!(moving.mode, Mode::Position);
    assert!(moving.sticks.unwrap().farthest_from(holding) > 0.02, "it asks for speed");
    bench.pilot_ms = Some(Channels { longitudinal: 1.95, ..bench.pilot_ms.unwrap() });
    assert_eq!(bench.cycles(1).mode, Mode::Manual);
}

/// Guidance would reject the velocity of a full stick, and the vehicle would keep an earlier one.
#[test]
fn sticks_that_ask_for_more_than_guidance_permits_are_refused() {
    let steering = SteeringConfig::default();
    for faster in [
        SteeringConfig { speed_mps: 5.1, ..steering },
        SteeringConfig { climb_mps: 1.6, ..steering },
        SteeringConfig { yaw_rate_radps: 0.7, ..steering },
    ] {
        let config = FlightControlConfig { steering: Some(faster), ..config() };
        let error = config.check().unwrap_err();
        assert!(error.to_string().starts_with("steering."), "{error}");
    }
    FlightControlConfig { steering: Some(steering), ..config() }.check().unwrap();
}

#[test]
fn a_mixed_swashplate_is_fed_by_the_pilot_and_by_the_autopilot_alike() {
    let swashplate = Swashplate { kind: SwashplateKind::Ccpm120, ..Swashplate::default() };
    let mut bench = Bench::engaged(FlightControlConfig { swashplate, ..config() });
    let outputs = bench.last.unwrap();
    let channels = Channels::<ChannelConfig>::default();
    let throttle_ms = bench.pilot_ms.unwrap().throttle;
    assert_eq!(
        outputs.widths_ms,
        swashplate.widths_ms(&channels, outputs.sticks.unwrap(), throttle_ms)
    );
    bench.aux_ms = Some(OPEN_MS);
    let manual = bench.cycles(400);
    assert_eq!(
        manual.widths_ms,
        swashplate.widths_ms(&channels, manual.pilot.unwrap(), throttle_ms)
    );
}

#[test]
fn a_throttle_that_is_held_stays_where_it_was_at_engagement() {
    let mut bench = Bench::engaged(FlightControlConfig { hold_throttle: true, ..config() });
    bench.pilot_ms = Some(Channels { throttle: 1.8, ..bench.pilot_ms.unwrap() });
    assert_eq!(bench.cycles(3).widths_ms.throttle, 1.5);
    bench.aux_ms = Some(OPEN_MS);
    assert_eq!(bench.cycles(3).widths_ms.throttle, 1.8);
}

#[test]
fn the_throttle_stays_where_the_pilot_left_it_while_the_autopilot_flies_without_one() {
    for by_word in [false, true] {
        let mut bench = Bench::engaged(config());
        bench.pilot_ms = Some(Channels { throttle: 1.7, ..bench.pilot_ms.unwrap() });
        assert_eq!(bench.cycles(3).widths_ms.throttle, 1.7, "it is passed through");
        if by_word {
            bench.pulses.receiver_failsafe = true;
        } else {
            (bench.pilot_ms, bench.aux_ms) = (None, None);
        }
        assert_eq!(bench.cycles(60).widths_ms.throttle, 1.7, "holding");
        bench.cycles(300);
        assert!(bench.told(ControlNotice::DescentStarted));
        assert_eq!(bench.last.unwrap().widths_ms.throttle, 1.7, "descending");
        bench.stale = true;
        let blind = bench.cycles(40);
        assert_eq!(blind.mode, Mode::Neutral);
        assert!(blind.widths_ms.throttle.is_nan(), "no command: the failsafe width");
    }
}

#[test]
fn settings_that_cannot_be_are_named() {
    let mut bad = config();
    bad.failsafe.descent_mps = f64::NAN;
    assert!(
        FlightControl::<f64>::new(bad).unwrap_err().to_string().contains("failsafe.descent_mps")
    );
    let geofence = Geofence { centre: place(0.0, 0.0), radius_m: 1.0, height_m: 40.0 };
    let bad = FlightControlConfig { geofence: Some(geofence), ..config() };
    assert!(FlightControl::<f64>::new(bad).unwrap_err().to_string().contains("geofence.radius_m"));
}

mod geofence;
mod programme;
mod switch;
