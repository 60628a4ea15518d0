//! Test inputs that the autopilot adds to its commands.

use approx::assert_abs_diff_eq;
use hovernav::autopilot::*;
use hovernav::controls::Sticks;
use hovernav::ekf::Solution;
use hovernav::frames::{EulerAngles, Rotation, Vector};

use crate::autopilot::{Bench, PERIOD_S, PILOT, hovering};

fn doublet(amplitude: f64) -> Excitation {
    Excitation {
        direction: Sticks { pedal: 1.0, ..Sticks::NEUTRAL },
        maneuver: Maneuver::Doublet { amplitude, hold_s: 0.5 },
        limits: ExcitationLimits::default(),
    }
}

#[test]
fn a_test_input_is_flown_on_top_distinguished_and_over_in_time() {
    let mut bench = Bench::new();
    assert_eq!(bench.autopilot.excite(doublet(0.1)), Err(ExcitationError::NotFlying));
    bench.step(Some(hovering()), Some(PILOT), false);
    bench.step(Some(hovering()), Some(PILOT), true);
    assert!(matches!(
        bench.autopilot.excite(doublet(f64::NAN)),
        Err(ExcitationError::Value { what: "amplitude", .. })
    ));
    bench.autopilot.excite(doublet(0.1)).unwrap();
    assert_eq!(bench.autopilot.excite(doublet(0.1)), Err(ExcitationError::Busy));
    let mut injected = Vec::new();
    while bench.autopilot.is_excited() {
        let outputs = bench.step(Some(hovering()), Some(PILOT), true);
        assert!(outputs.sticks.is_finite() && outputs.aborted.is_none());
        let [.., pedal] = outputs.injected.to_array();
        assert!(pedal.abs() < 0.1 + 1e-12 && outputs.injected.lateral == 0.0);
        injected.push(outputs.injected.pedal);
    }
    assert!((injected.len() as f64 * PERIOD_S - 1.0).abs() < 2.5 * PERIOD_S, "{}", injected.len());
    assert_abs_diff_eq!(injected[3], 0.1, epsilon = 1e-12);
    assert_abs_diff_eq!(injected[25], -0.1, epsilon = 1e-12);
    let after = bench.step(Some(hovering()), Some(PILOT), true);
    assert_eq!(after.injected, Sticks::NEUTRAL);
}

#[test]
fn a_test_input_ends_at_its_limits_and_with_the_pilot() {
    let start = || {
        let mut bench = Bench::new();
        bench.step(Some(hovering()), Some(PILOT), false);
        bench.step(Some(hovering()), Some(PILOT), true);
        bench.autopilot.excite(doublet(0.1)).unwrap();
        bench.step(Some(hovering()), Some(PILOT), true);
        bench
    };
    let tilted = Solution {
        body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(25.0, 0.0, 40.0)),
        ..hovering()
    };
    let spun = Solution { angular_rate_radps: Vector::new(0.0, 0.0, 2.5), ..hovering() };
    let fast = Solution { velocity_mps: Vector::new(0.0, 2.6, 0.0), ..hovering() };
    for (solution, why) in [
        (tilted, ExcitationAbort::Tilt),
        (spun, ExcitationAbort::Rate),
        (fast, ExcitationAbort::Speed),
    ] {
        let mut bench = start();
        let outputs = bench.step(Some(solution), Some(PILOT), true);
        assert_eq!((outputs.aborted, outputs.injected), (Some(why), Sticks::NEUTRAL));
        assert!(!bench.autopilot.is_excited());
    }
    let mut bench = start();
    let outputs = bench.step(Some(hovering()), Some(PILOT), false);
    assert_eq!(outputs.mode, Mode::Manual);
    assert_eq!((outputs.aborted, outputs.injected), (Some(ExcitationAbort::Mode), Sticks::NEUTRAL));
}
