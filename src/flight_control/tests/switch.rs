//! Tests of a switch that is closed at the start, and of a switch that bounces.

use super::*;

fn engagements(bench: &Bench) -> usize {
    bench.told.iter().filter(|told| **told == ControlNotice::Engaged).count()
}

#[test]
fn a_switch_that_is_closed_at_a_restart_says_once_that_it_must_be_opened() {
    let mut bench = Bench::new(config());
    bench.aux_ms = Some(CLOSED_MS);
    assert_eq!(bench.cycles(200).mode, Mode::Manual);
    assert_eq!(bench.told, [ControlNotice::SwitchMustBeReset]);
    assert!(bench.control.is_refused(), "telemetry shows that the switch has to be opened");
    let words = ControlNotice::SwitchMustBeReset.to_string();
    assert!(words.contains("open the switch to engage again"), "{words}");
    bench.aux_ms = Some(OPEN_MS);
    bench.cycles(5);
    assert!(!bench.control.is_refused());
    bench.aux_ms = Some(CLOSED_MS);
    assert_eq!(bench.cycles(10).mode, Mode::Position);
}

#[test]
fn a_bouncing_switch_is_locked_out_after_three_engagements() {
    let mut bench = Bench::new(config());
    bench.cycles(20);
    // Ten attempts in nine seconds.
    for _ in 0..10 {
        bench.aux_ms = Some(CLOSED_MS);
        bench.cycles(15);
        bench.aux_ms = Some(OPEN_MS);
        bench.cycles(15);
    }
    assert_eq!(engagements(&bench), 3, "{:?}", bench.told);
    assert!(bench.told(ControlNotice::SwitchBounces));
    let words = ControlNotice::SwitchBounces.to_string();
    assert!(words.contains("3 engagements") && words.contains("open for 3 s"), "{words}");
    // A closed switch does not end the lockout, however long it is closed.
    bench.aux_ms = Some(CLOSED_MS);
    assert_eq!(bench.cycles(300).mode, Mode::Manual);
    bench.aux_ms = Some(OPEN_MS);
    bench.cycles(105);
    assert!(!bench.control.is_refused());
    bench.aux_ms = Some(CLOSED_MS);
    assert_eq!(bench.cycles(10).mode, Mode::Position);
}

#[test]
fn engagements_with_steady_flight_between_them_are_never_locked_out() {
    let mut bench = Bench::new(config());
    bench.cycles(20);
    for _ in 0..10 {
        bench.aux_ms = Some(CLOSED_MS);
        assert_eq!(bench.cycles(150).mode, Mode::Position);
        bench.aux_ms = Some(OPEN_MS);
        bench.cycles(10);
    }
    assert_eq!(engagements(&bench), 10);
}
