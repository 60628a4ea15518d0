//! Tests of programmes of test inputs.

use super::*;
use crate::autopilot::{
    ExcitationAbort, ExcitationLimits, ExcitationProgramme, Maneuver, ProgrammeChange, TestInput,
};
use approx::assert_abs_diff_eq;

fn programme() -> ExcitationProgramme {
    let doublet = Maneuver::Doublet { amplitude: 0.1, hold_s: 0.6 };
    let step = Maneuver::Step { amplitude: -0.2, hold_s: 0.9 };
    let mut inputs = [None; ExcitationProgramme::MAX];
    inputs[0] = Some(TestInput { stick: Channel::Pedal, maneuver: doublet });
    inputs[1] = Some(TestInput { stick: Channel::Collective, maneuver: step });
    let limits = ExcitationLimits::default();
    ExcitationProgramme { inputs, first_s: 3.0, pause_s: 2.0, dead_band: 0.05, limits }
}

fn flying(programme: ExcitationProgramme) -> Bench {
    Bench::engaged(FlightControlConfig { excitation: Some(programme), ..config() })
}

/// Number of notices of a change.
fn count(bench: &Bench, wanted: ProgrammeChange) -> usize {
    let wanted = ControlNotice::TestInputs(wanted);
    bench.told.iter().filter(|told| **told == wanted).count()
}

#[test]
fn inputs_are_flown_one_after_the_other_and_reported() {
    let mut bench = flying(programme());
    let injected: Vec<Sticks> = (0..400).map(|_| bench.cycles(1).injected).collect();
    let cycles = |is: &dyn Fn(&Sticks) -> bool| injected.iter().filter(|one| is(one)).count();
    assert_eq!(cycles(&|one| (one.pedal - 0.1).abs() < 1e-9), 20);
    assert_eq!(cycles(&|one| (one.pedal + 0.1).abs() < 1e-9), 20);
    assert_eq!(cycles(&|one| (one.collective + 0.2).abs() < 1e-9), 30);
    assert_eq!(cycles(&|one| *one != Sticks::NEUTRAL), 70);
    let first = injected.iter().position(|one| one.pedal > 0.0).unwrap() as f64 * PERIOD_S;
    let second = injected.iter().position(|one| one.collective < 0.0).unwrap() as f64 * PERIOD_S;
    assert!((2.6..3.1).contains(&first) && (3.1..3.4).contains(&(second - first)));
    for (number, stick) in [(1, Channel::Pedal), (2, Channel::Collective)] {
        assert_eq!(count(&bench, ProgrammeChange::Begins { number, stick }), 1);
    }
    assert_eq!(count(&bench, ProgrammeChange::Done), 1);
    assert_eq!(bench.cycles(1).mode, Mode::Position);
}

#[test]
fn a_stick_beyond_its_dead_band_ends_them_at_once_and_the_autopilot_flies_on() {
    let mut bench = flying(programme());
    bench.cycles(110);
    let near = Channels { lateral: 1.54, ..bench.pilot_ms.unwrap() };
    bench.pilot_ms = Some(near);
    assert!(bench.cycles(1).injected.pedal != 0.0, "inside the dead band");
    bench.pilot_ms = Some(Channels { lateral: 1.57, ..near });
    let outputs = bench.cycles(1);
    assert_eq!((outputs.injected, outputs.mode), (Sticks::NEUTRAL, Mode::Position));
    assert_eq!(count(&bench, ProgrammeChange::Ended(ExcitationAbort::Stick)), 1);
    bench.pilot_ms = Some(near);
    bench.cycles(300);
    assert_eq!(bench.told.len(), 2, "no more until the next engagement: {:?}", bench.told);
}

#[test]
fn the_switch_ends_them_and_the_next_engagement_begins_again() {
    let mut bench = flying(programme());
    bench.cycles(110);
    bench.aux_ms = Some(OPEN_MS);
    let outputs = bench.cycles(1);
    assert_eq!((outputs.injected, outputs.mode), (Sticks::NEUTRAL, Mode::Manual));
    bench.cycles(20);
    bench.aux_ms = Some(CLOSED_MS);
    bench.cycles(110);
    assert_eq!(count(&bench, ProgrammeChange::Begins { number: 1, stick: Channel::Pedal }), 2);
}

#[test]
fn the_loss_of_the_pilot_and_limits_crossed_end_them() {
    let mut bench = flying(programme());
    bench.cycles(110);
    bench.pulses.receiver_failsafe = true;
    assert_eq!(bench.cycles(1).injected, Sticks::NEUTRAL);
    assert_eq!(count(&bench, ProgrammeChange::Ended(ExcitationAbort::Mode)), 1);

    let mut bench = flying(programme());
    bench.cycles(110);
    bench.solution.as_mut().unwrap().velocity_mps = Vector::new(2.6, 0.0, 0.0);
    assert_eq!(bench.cycles(1).injected, Sticks::NEUTRAL);
    assert_eq!(count(&bench, ProgrammeChange::Ended(ExcitationAbort::Speed)), 1);
}

#[test]
fn a_stick_moves_no_faster_for_them_than_it_may() {
    let mut slow = programme();
    slow.limits.stick_rate_per_s = 1.0;
    let mut bench = flying(slow);
    let mut before = 0.0;
    for _ in 0..400 {
        let pedal = bench.cycles(1).injected.pedal;
        assert_abs_diff_eq!(pedal, before, epsilon = PERIOD_S + 1e-9);
        before = pedal;
    }
    assert_eq!(count(&bench, ProgrammeChange::Done), 1);
}

#[test]
fn inputs_that_cannot_be_are_named() {
    let refused = |excitation: ExcitationProgramme, what: &str| {
        let bad = FlightControlConfig { excitation: Some(excitation), ..config() };
        let error = FlightControl::<f64>::new(bad).unwrap_err().to_string();
        assert!(error.contains(what), "{what}: {error}");
    };
    refused(ExcitationProgramme { first_s: f64::NAN, ..programme() }, "first_s");
    refused(ExcitationProgramme { dead_band: 0.0, ..programme() }, "dead_band");
    let limits = ExcitationLimits { stick_rate_per_s: 0.0, ..ExcitationLimits::default() };
    refused(ExcitationProgramme { limits, ..programme() }, "rate of the stick");
    let maneuver = Maneuver::Step { amplitude: 0.1, hold_s: 1.0 };
    for (input, what) in [
        (TestInput { stick: Channel::Throttle, maneuver }, "stick"),
        (
            TestInput {
                stick: Channel::Pedal,
                maneuver: Maneuver::Step { amplitude: 0.9, hold_s: 1.0 },
            },
            "amplitude",
        ),
    ] {
        let mut bad = programme();
        bad.inputs[1] = Some(input);
        refused(bad, what);
    }
}
