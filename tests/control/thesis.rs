//! The control design printed by Paw (2005), reproduced.

use hovernav_design::thesis::PrintedDesign;
use hovernav_design::{DISTURBED, DisturbanceResponse, TABLE_6_1};
use hovernav_testing::shared;
use serde_json::Value;

fn reference() -> Option<Value> {
    let text = std::fs::read_to_string(shared("reference/thesis.json")?).unwrap();
    Some(serde_json::from_str(&text).unwrap())
}

fn respond(state: &str, size: f64) -> DisturbanceResponse {
    PrintedDesign::new().unwrap().respond(state, size, 20.0, 0.01).unwrap()
}

/// Asserts that a number agrees within 1 %, or within the last digit if the number is given to `digits`.
#[track_caller]
fn assert_near(found: f64, expected: f64, digits: i32, what: &str) {
    let allowed = (0.01 * expected.abs()).max(0.51 * 10f64.powi(-digits));
    assert!((found - expected).abs() <= allowed, "{what}: {found}, expected {expected}");
}

#[test]
fn the_nine_continuous_responses_come_out_within_one_percent() {
    let Some(reference) = reference() else { return };
    for (state, size) in TABLE_6_1 {
        let expected = &reference["closed_loop_disturbances"][state];
        let response = respond(state, size);
        let settled = response.settled_s().unwrap();
        println!("{state} {size}: settled at {settled:.2} s, {}", expected["settle_s"]);
        assert_near(settled, expected["settle_s"].as_f64().unwrap(), 2, state);
        for (name, peak) in DISTURBED.into_iter().zip(response.peaks()) {
            let what = format!("peak of {name} after {state}");
            assert_near(peak, expected["peaks"][name].as_f64().unwrap(), 3, &what);
        }
        for (name, value) in DISTURBED.into_iter().zip(response.states[800]) {
            let what = format!("{name} 8 s after {state}");
            assert_near(value, expected["at8"][name].as_f64().unwrap(), 5, &what);
        }
    }
}

#[test]
fn every_disturbance_of_table_6_1_is_all_but_gone_after_8_s() {
    for (state, size) in TABLE_6_1 {
        let response = respond(state, size);
        let recovered = response.recovered_s(0.1).unwrap();
        assert!(recovered <= 8.0, "{state}: {recovered} s");
    }
}

#[test]
fn the_heave_poles_and_the_ranks_are_those_printed() {
    let design = PrintedDesign::new().unwrap();
    for pole in design.heave_poles().unwrap() {
        assert_eq!((pole.re * 100.0).round() / 100.0, -5.65);
        assert_eq!((pole.im.abs() * 100.0).round() / 100.0, 1.46);
    }
    let ranks = design.reach().unwrap().map(|(inputs, outputs)| [inputs.rank, outputs.rank]);
    assert_eq!(ranks, [[6, 6], [2, 2]]);
}

#[test]
fn held_at_33_hz_the_printed_gains_are_violently_unstable() {
    let [roll_pitch, heave] = PrintedDesign::new().unwrap().spectral_radii(1.0 / 33.0).unwrap();
    assert_eq!((roll_pitch * 10.0).round() / 10.0, 7.9);
    assert_eq!((heave * 10.0).round() / 10.0, 24.7);
}
