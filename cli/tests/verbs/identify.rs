//! From a recorded flight to a model file, or to a one-line error with the reason.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use hovernav_model::{StateSpace, TimeDomain};
use hovernav_testing::shared;
use serde_json::Value;

use crate::common::{
    HELI, assert_keys, changed, hovernav, place, refusal, succeeds, summary, text,
};

/// A copy of the flight, which has three test points per stick, without the reference. `change` returns a file's new
/// text, or `None` to omit the file.
fn flight(name: &str, change: impl Fn(&str, String) -> Option<String>) -> PathBuf {
    changed(HELI, name, &["imu.csv", "gps.csv", "controls.csv", "dataset.toml"], change)
}

/// The log's sticks in `info`: the flight has three test points on each.
#[test]
fn info_states_which_sticks_move_and_what_can_be_identified() {
    let info: Value = serde_json::from_str(&succeeds(&["info", HELI, "--json"])).expect("JSON");
    let sticks = info["excitation"]["sticks"].as_array().expect("four sticks");
    for stick in sticks {
        assert_eq!(stick["test_points"], 3, "{stick}");
        assert!(stick["moved_s"].as_f64().expect("a number") > 10.0, "{stick}");
        assert!(stick["band_hz"][1].as_f64().expect("a number") > 1.0, "{stick}");
    }
    let words = succeeds(&["info", HELI]);
    assert!(words.contains("\n  identify      yaw, heave, roll, pitch, rates"), "{words}");
    // Without GPS only rates are identified.
    let blind = changed(
        HELI,
        "info-without-gps",
        &["imu.csv", "controls.csv", "dataset.toml"],
        |_, own| Some(own),
    );
    let words = succeeds(&["info", text(&blind)]);
    assert!(words.contains("\n  identify      yaw, roll, pitch, rates\n"), "{words}");
}

#[test]
fn an_invalid_structure_is_refused_in_one_sentence() {
    let file = place("identify-structure").join("mine.toml");
    for (content, expected) in [("wings = 2\n", "unknown key `wings`"), ("=", "mine.toml:1")] {
        fs::write(&file, content).expect("writable");
        let message = refusal(&["identify", HELI, "--model", text(&file)]);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn an_identification_leaves_a_model_a_summary_and_a_page() {
    // Without the reference and the true parameters: the command must not need them.
    let flight = flight("identify-flight", |_, content| Some(content));
    let out = place("identify-hybrid");
    let own = ["identify", text(&flight), "--model", "hybrid", "--held-gps", "--out", text(&out)];
    let words = succeeds(&[&own[..], &["--export", "csv,matlab"]].concat());
    let responses = fs::read_to_string(out.join("responses.csv")).unwrap();
    let coherent = |line: &str| line.split(',').nth(5).and_then(|own| own.parse::<f64>().ok());
    let coherence: Vec<f64> = responses.lines().filter_map(coherent).collect();
    assert!(coherence.len() > 1_000 && coherence.iter().all(|own| (0.0..=1.0).contains(own)));
    assert!(!responses.contains("inf"), "a stick without effect has no decibels");
    assert!(fs::read_to_string(out.join("model.m")).unwrap().contains("ss(A, B, C, D)"));

    let summary = summary(&out);
    assert_keys(&summary, &["warnings", "model", "log"]);
    assert_eq!(summary["time_domain"], "continuous");
    for output in ["p", "q", "phi", "theta", "u", "v", "w", "r"] {
        let fit = summary["validation"][output]["fit_percent"].as_f64().expect(output);
        let floor = summary["validation"][output]["noise_floor_percent"].as_f64().expect(output);
        assert!(fit > 60.0 && floor <= 100.0, "{output}: {fit} {floor}");
    }
    for (output, least) in [("p", 75.0), ("q", 75.0), ("u", 75.0), ("w", 75.0), ("r", 90.0)] {
        let fit = summary["validation"][output]["fit_percent"].as_f64().expect(output);
        assert!(fit > least, "{output}: {fit}");
    }
    let better = |output: &str| {
        let fit = |of: &Value| of["validation"][output]["fit_percent"].as_f64().expect(output);
        fit(&summary) - fit(&summary["held_gps"])
    };
    assert!(better("u") > 20.0 && better("w") > 20.0, "the estimator's velocity is worth it");
    let parameters = summary["parameters"].as_array().expect("a list");
    for parameter in parameters {
        let known = parameter["status"] == "estimated" || parameter["status"] == "on its limit";
        assert_eq!(known, parameter["bound"].as_f64().is_some(), "{parameter}");
    }

    let model = StateSpace::read(&out.join("model.toml")).expect("a model");
    assert_eq!(model.time(), TimeDomain::Continuous);
    let names: Vec<&str> = model.states().iter().map(|state| &*state.name).collect();
    assert_eq!(names.len(), 10, "gusts are no part of the vehicle: {names:?}");
    let (r, pedal) = (model.state("r").expect("r"), model.input("pedal").expect("pedal"));
    let of = |name: &str| parameters.iter().find(|parameter| parameter["name"] == name);
    let value = |name: &str| of(name).and_then(|found| found["value"].as_f64()).expect("a value");
    assert_abs_diff_eq!(model.b()[(r, pedal)], value("Nped"), epsilon = 1e-9);
    assert_abs_diff_eq!(model.a()[(r, r)], value("Nr"), epsilon = 1e-9);
    let covariance = model.covariance().expect("a covariance");
    let place = model.parameters().iter().position(|known| known.name == "Nr").expect("Nr");
    let bound = of("Nr").and_then(|found| found["bound"].as_f64()).expect("a bound");
    assert_abs_diff_eq!(covariance[(place, place)].sqrt() / bound, 1.0, epsilon = 1e-6);

    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    for anchor in ["parameters", "histories", "residuals", "bode", "poles", "held-gps"] {
        assert!(page.contains(&format!("<section id=\"{anchor}\">")), "{anchor}");
        let drawn = page.contains(&format!("data-figure=\"{anchor}\""));
        assert_eq!(drawn, anchor != "parameters", "{anchor}");
    }
    for label in ["Bounds of the parameters (1σ): median ±", "Insensitivity", "95 % region"] {
        assert!(page.contains(label), "{label}");
    }
    for head in ["Nped", "bound %", "insensitivity %", "noise floor", "held GPS fit %"] {
        assert!(words.contains(head), "{head}: {words}");
    }
}

#[test]
#[ignore = "a minute: 330 s at 200 Hz"]
fn a_quadcopter_is_identified_without_flapping() {
    let Some(packed) = shared("cases/identification/sid.bin.gz") else { return };
    let truth = shared("cases/identification/truth.json").expect("beside the log");
    let truth: Value = serde_json::from_slice(&fs::read(truth).expect("it is there")).unwrap();
    let out = place("identify-quadcopter");
    let log = out.join("sid.bin");
    let unpacked = Command::new("gzip").arg("-dc").arg(packed).output().expect("gzip runs");
    fs::write(&log, unpacked.stdout).expect("it can be written");
    succeeds(&["identify", text(&log), "--no-report", "--out", text(&out)]);

    let summary = summary(&out);
    assert_eq!(summary["model"], "multirotor");
    assert_eq!(summary["verdict"], "good");
    let value = |name: &str| {
        let parameters = summary["parameters"].as_array().expect("a list");
        let own = parameters.iter().find(|own| own["name"] == name);
        own.and_then(|own| own["value"].as_f64()).expect(name)
    };
    let is = |name: &str| truth[name].as_f64().expect(name);
    for name in ["Llat", "Nr", "Nped", "Zcol"] {
        assert_relative_eq!(value(name), is(name), max_relative = 0.05);
    }
    // A positive longitudinal stick pitches the nose down.
    assert_relative_eq!(-value("Mlon"), is("Mlon_per_pitchout"), max_relative = 0.05);
    for stick in ["lat", "lon", "col", "ped"] {
        assert_abs_diff_eq!(value(&format!("lag_{stick}")), is("motor_lag_s"), epsilon = 0.008);
        assert_abs_diff_eq!(value(&format!("tau_{stick}")), is("delay_s"), epsilon = 0.005);
    }
}

#[test]
fn a_flight_without_sticks_is_refused() {
    let dir =
        flight("identify-no-sticks", |part, content| (part != "controls.csv").then_some(content));
    let message =
        refusal(&["identify", text(&dir), "--out", text(&place("identify-no-sticks-out"))]);
    assert!(
        message.contains("controls.csv") && message.contains("needs the pilot's inputs"),
        "{message}"
    );
}

#[test]
fn a_pedal_that_never_moves_is_named() {
    let dir = flight("identify-still-pedal", |part, content| {
        if part != "controls.csv" {
            return Some(content);
        }
        let still = |(index, line): (usize, &str)| match line.rsplit_once(',') {
            Some((others, _)) if index > 0 => format!("{others},0.0\n"),
            _ => format!("{line}\n"),
        };
        Some(content.lines().enumerate().map(still).collect())
    });
    let out = place("identify-still-pedal-out");
    let yaw = ["identify", text(&dir), "--model", "yaw", "--out", text(&out)];
    let message = refusal(&yaw);
    assert!(message.contains("pedal") && message.contains("no test point"), "{message}");
    // The rest of the helicopter is still identified, with a warning. The exit status is 1, because a model without
    // pedal must not be flown.
    let output = hovernav(&["identify", text(&dir), "--model", "hover", "--out", text(&out)]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert_eq!(summary(&out)["verdict"], "do not fly");
    let warnings = summary(&out)["warnings"].to_string();
    assert!(warnings.contains("input `pedal` never moves"), "{warnings}");
}

#[test]
fn a_model_of_a_flight_too_short_must_not_be_flown() {
    let dir = flight("identify-short", |part, content| {
        let rows = if part == "imu.csv" || part == "controls.csv" { 330 } else { usize::MAX };
        Some(content.lines().take(rows).map(|line| format!("{line}\n")).collect())
    });
    let message = refusal(&["identify", text(&dir), "--out", text(&place("identify-short-out"))]);
    assert!(message.contains("do not fly an autopilot based on this model"), "{message}");
}

#[test]
fn the_file_of_a_built_in_structure_gives_its_model() {
    let names = succeeds(&["identify", "--list"]);
    assert!(names.lines().count() >= 11 && names.contains("multirotor"), "{names}");
    let file = place("identify-mine").join("mine.toml");
    fs::write(&file, succeeds(&["identify", "--list", "yaw"])).unwrap();
    let values = ["yaw", text(&file)].map(|structure| {
        let out = place("identify-structure");
        let own = ["identify", HELI, "--model", structure, "--no-report", "--out", text(&out)];
        succeeds(&own);
        summary(&out)["parameters"].clone()
    });
    assert_eq!(values[0], values[1]);
    assert!(refusal(&["identify", "--list", "glider"]).contains("found `glider`"));
}

#[test]
fn a_log_without_gps_gives_the_model_of_the_rates() {
    let dir = flight("identify-no-gps", |part, content| (part != "gps.csv").then_some(content));
    let out = place("identify-no-gps-out");
    succeeds(&["identify", text(&dir), "--out", text(&out)]);
    assert_eq!(summary(&out)["model"], "rates");
    let message = refusal(&["identify", text(&dir), "--model", "heave", "--out", text(&out)]);
    assert!(message.contains("Without GPS only models of rates"), "{message}");
    let message = refusal(&["identify", text(&dir), "--held-gps", "--out", text(&out)]);
    assert!(message.contains("--held-gps needs GPS"), "{message}");
}

#[test]
fn a_model_that_there_is_not_is_wrong_usage() {
    let run = hovernav(&["identify", HELI, "--model", "glider"]);
    assert_eq!(run.status.code(), Some(2), "{run:?}");
    assert!(String::from_utf8_lossy(&run.stderr).contains("yaw, heave"), "{run:?}");
}
