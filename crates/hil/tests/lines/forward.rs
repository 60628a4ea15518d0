//! Forward flight over the lines: the pilot steers, the autopilot flies.

use hovernav_sim::velocity_deviation_mps;

use crate::common::{Setup, all_flown};

/// Speed at full stick, m/s.
const SPEED_MPS: f64 = 5.0;
/// Time from a movement of the stick until the speed is reached, s: acceleration at 1 m/s², and the vehicle's delay.
const REACHED_S: f64 = 10.0;

#[test]
fn a_stick_held_forward_flies_at_5_m_per_s_and_released_stops() {
    let acts = ["engage@8:60", "stick-longitudinal=0.6@12:26"];
    let flights = all_flown(&[()], |()| Setup {
        pilot: "steer",
        keys: format!("[autopilot.steering]\nspeed_mps = {SPEED_MPS:.1}\n"),
        ..Setup::new(60.0, &acts)
    });
    let flown = &flights[0];
    assert_eq!(flown.crashed_s, None, "{:#?}", flown.record.events);
    let truths = || flown.samples.iter().map(|sample| sample.truth);
    let rms = |from_s: f64, to_s: f64, forward_mps: f64| {
        velocity_deviation_mps(truths(), from_s..to_s, [forward_mps, 0.0, 0.0]).unwrap()
    };
    let cruise = rms(12.0 + REACHED_S, 38.0, SPEED_MPS);
    let stopped = rms(38.0 + REACHED_S, 60.0, 0.0);
    println!("at {SPEED_MPS} m/s within {cruise:?} m/s RMS, then at rest within {stopped:?}");
    assert!(cruise.iter().all(|mps| *mps <= 0.4), "{cruise:?}");
    assert!(stopped.iter().all(|mps| *mps <= 0.4), "{stopped:?}");
    assert!(flown.statistics().engaged_s > 51.0, "{:#?}", flown.record.events);
}
