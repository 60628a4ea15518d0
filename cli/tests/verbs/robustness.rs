//! `design` with a model with covariance, and with an invalid covariance.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use crate::common::{place, refusal, succeeds, summary, text};

/// A model like an identified one: a parameter with `variance`, and a delay.
fn identified(variance: &str, covariance: &str, slopes: &str) -> String {
    let by_hand = include_str!("../../../crates/model/src/data/raptor60.toml");
    let told = format!(
        "verdict = \"good\"\nparameters = [\n    {{ name = \"Nr\", value = -4.0, unit = \"1/s\" }},\n    {{ name = \
         \"tau_ped\", value = 0.03, unit = \"s\" }},\n]\nparameter_covariance = [[{variance}, {covariance}], \
         [{covariance}, 1e-6]]\nslopes = [{slopes}]\nstates = ["
    );
    by_hand.replacen("states = [", &told, 1)
}

const SLOPE: &str = "{ parameter = \"Nr\", row = \"r\", column = \"r\", slope = 1.0 }";

/// The model and weights, in a directory with this name.
fn written(name: &str, model: &str) -> [PathBuf; 3] {
    let dir = place(name);
    let (file, weights) = (dir.join("model.toml"), dir.join("weights.toml"));
    fs::write(&file, model).expect("writable");
    fs::write(&weights, "").expect("writable");
    [dir, file, weights]
}

#[test]
fn what_the_identification_leaves_open_is_sampled_and_bounded_and_the_two_agree() {
    let [dir, model, weights] = written("robustness", &identified("0.25", "1e-5", SLOPE));
    let out = ["--weights", text(&weights), "--out", text(&dir)];
    let words = succeeds(&[&["design", text(&model)][..], &out].concat());
    assert!(
        words.contains("500 of 500 stable in every mode; margins of the weakest 5 % below"),
        "{words}"
    );
    assert!(words.contains("2 directions, deviate by less than"), "{words}");
    let found = &summary(&dir)["sampled"];
    let number = |value: &Value| value.as_f64().expect("a number");
    assert_eq!((number(&found["of"]), number(&found["directions"])), (500.0, 2.0));
    assert!(number(&found["within_proven"]) <= number(&found["stable"]));
    for mode in ["velocity", "position", "attitude"] {
        let own = &found["modes"][mode];
        assert!(number(&own["worst"]["phase_deg"]) <= number(&own["twentieth"]["phase_deg"]));
        assert!(number(&own["proven_sigmas"]) > 0.0);
    }
    let page = fs::read_to_string(dir.join("report.html")).expect("a page");
    assert!(page.contains("Uncertainty of the identification"));
    // A model without covariance is only tested with errors in every derivative.
    let words = succeeds(&[&["design", "raptor60"][..], &out].concat());
    assert!(!words.contains("drawn from the covariance") && words.contains("errors of up to 20 %"));
    assert_eq!(summary(&dir)["sampled"], Value::Null);
}

#[test]
fn a_model_of_which_little_is_known_is_warned_of() {
    let [dir, model, weights] = written("little_known", &identified("400.0", "0.0", SLOPE));
    let out = ["--weights", text(&weights), "--out", text(&dir), "--no-report"];
    let words = succeeds(&[&["design", text(&model)][..], &out].concat());
    let warning = "vehicles drawn from the covariance of the model\u{2019}s parameters are unstable in at least one";
    assert!(words.contains(warning), "{words}");
    let found = &summary(&dir)["sampled"];
    assert!(found["within_proven"].as_u64() <= found["stable"].as_u64(), "{found}");
    assert_eq!(found["modes"]["velocity"]["worst"]["phase_deg"], 0.0);
    // Even with an unlimited variance, an autopilot is designed.
    fs::write(&model, identified("1e12", "0.0", SLOPE)).expect("writable");
    let words = succeeds(&[&["design", text(&model)][..], &out].concat());
    assert!(words.contains("deviate by less than 0.00 sigmas; 0 of"), "{words}");
}

#[test]
fn a_model_that_speaks_nonsense_of_how_sure_it_is_is_refused_in_one_line() {
    let slope = |column: &str, value: &str| {
        format!("{{ parameter = \"Nr\", row = \"r\", column = \"{column}\", slope = {value} }}")
    };
    let good = identified("0.25", "1e-5", SLOPE);
    for (name, text_of, expected) in [
        ("nan", identified("0.25", "0.0", &slope("r", "nan")), "slope 1, slope: found \"NaN\""),
        ("place", identified("0.25", "0.0", &slope("13", "1.0")), "slope 1, column: found \"13\""),
        ("negative", identified("-0.25", "0.0", SLOPE), "Nr: found a variance below 0"),
        ("certain", identified("0.25", "1.0", SLOPE), "tau_ped: found a correlation beyond 1"),
        ("not_one", identified("nan", "0.0", SLOPE), "covariance: found NaN"),
        (
            "unknown",
            identified("1e30", "0.0", SLOPE),
            "found 1e30 for Nr, a standard error of 1e15",
        ),
        ("infinite", identified("inf", "0.0", SLOPE), "covariance: found inf"),
        ("cut", good[..good.find("unit = \"s\"").expect("it is there")].to_owned(), "model.toml:"),
    ] {
        let [dir, model, weights] = written(&format!("nonsense_{name}"), &text_of);
        let arguments = ["design", text(&model), "--weights", text(&weights), "--out", text(&dir)];
        let message = refusal(&arguments);
        assert!(message.contains(expected), "{name}: {message}");
    }
}
