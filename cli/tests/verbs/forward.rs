//! Forward flight, from its design to a flight.

use std::fs;

use crate::common::{assert_refused, place, succeeds, summary, text};

/// Design with margins up to 2 m/s, a flight at this speed, and its rejection at a higher one.
#[test]
fn forward_flight_is_designed_flown_and_limited_to_its_speed() {
    let (out, flight) = (place("forward_design"), place("forward_flight"));
    let weights = out.join("weights.toml");
    let no_lag = "[estimator]\nrate_s = 0.0\nattitude_s = 0.0\nvelocity_s = 0.0\n";
    fs::write(&weights, no_lag).expect("a file");
    let design = ["design", "raptor60", "--weights", text(&weights), "--out", text(&out)];
    let words = succeeds(&[&design[..], &["--at", "raptor60@2"]].concat());
    assert!(words.contains("2.0 m/s  ") && words.contains("interpolated"), "{words}");
    assert!(
        words.contains("6 dB and 45° forwards up to 2.0 m/s; autopilot.toml allows 2.0"),
        "{words}"
    );
    let found = &summary(&out)["forward_flight"];
    assert_eq!(found["fastest_mps"], 2.0);
    assert_eq!(found["points"].as_array().expect("five points").len(), 5);
    let autopilot = out.join("autopilot.toml");
    let simulate = ["simulate", "--autopilot", text(&autopilot), "--no-report", "--duration", "60"];
    let arguments = [&simulate[..], &["--out", text(&flight), "--velocity", "2@20"]].concat();
    let words = succeeds(&arguments);
    assert!(
        words.starts_with("from 20 s on at 2, 0, 0 m/s forward, right, down: within"),
        "{words}"
    );
    let flown = &summary(&flight)["flight"]["velocities"][0];
    for axis in 0..3 {
        let rms_mps = flown["deviation_rms_mps"][axis].as_f64().expect("a number");
        assert!(rms_mps < 0.3, "{flown}");
    }
    let fast = [&simulate[..], &["--velocity", "2.5,1@20"]].concat();
    assert_refused(&fast, "found a speed of 2.69 m/s, expected at most 2.00 m/s");
    assert_refused(&[&design[..], &["--at", "raptor60"]].concat(), "another speed than those");
    assert_refused(
        &[&design[..], &["--at", "raptor60@99"]].concat(),
        "found 99, expected a speed in m/s",
    );
    assert_refused(&["design", "raptor60@5", "--out", text(&out)], "expected 0, a model of hover");
}
