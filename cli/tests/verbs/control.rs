//! The commands that design, simulate and evaluate the autopilot, as a user runs them.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{assert_refused, designed, hovernav, place, refusal, succeeds, summary, text};

#[test]
fn the_thesis_design_is_reproduced_and_replaced() {
    let out = place("design_thesis");
    let words = succeeds(&["design", "thesis", "--out", text(&out)]);
    for expected in [
        "-38.312, 31.807, -48.756, 84.394, -21.346",
        "29.425, -26.887, -424.20, 405.19, -60.082, -71.578",
        "-5.65 ± 1.46i",
        "roll and pitch 6 and 6, yaw 2 and 2",
        "    at outputs    2.9 dB   weakest    14.9°",
        "spectral radius 7.9 in roll and pitch, 24.7 in heave",
        "transition matrix used as a continuous one",
    ] {
        assert!(words.contains(expected), "{expected} in {words}");
    }
    let summary = summary(&out);
    assert!(summary["closed_loop_spectral_radius"].as_f64().expect("a number") < 1.0);
    for stick in ["lateral", "longitudinal", "collective", "pedal"] {
        // The phase margin includes the lag of the servo.
        let phase_deg = summary["margins"][stick]["phase_deg"].as_f64().expect("a number");
        assert!(phase_deg >= 45.0, "{stick}: {phase_deg}");
    }
    assert_eq!(summary["disturbances"].as_object().expect("nine").len(), 9);
    assert!(fs::metadata(out.join("report.html")).expect("a page").len() > 1_000_000);
}

/// Asserts a complete design for a shipped model.
fn assert_can_be_flown(out: &Path) {
    let written = fs::read_to_string(out.join("autopilot.toml")).expect("an autopilot");
    assert!(written.starts_with("# Designed by hovernav"));
    assert!(summary(out)["closed_loop_spectral_radius"].as_f64().expect("a number") < 1.0);
}

// One test per model, so that they run in parallel.
#[test]
fn the_shipped_raptor60_gets_an_autopilot_that_can_be_flown() {
    assert_can_be_flown(designed());
}

#[test]
fn the_shipped_r50_gets_an_autopilot_that_can_be_flown() {
    let out = place("design_r50");
    succeeds(&["design", "r50", "--out", text(&out), "--no-report"]);
    assert_can_be_flown(&out);
}

#[test]
fn a_design_is_flown_and_its_flight_estimated() {
    let (flight, again) = (place("fly_flight"), place("fly_again"));
    let autopilot = designed().join("autopilot.toml");
    let arguments = [
        "simulate",
        "--autopilot",
        text(&autopilot),
        "--disturbance",
        "phi=0.3",
        "--disturbance",
        "u=-2@45",
        "--duration",
        "70",
        "--wind",
        "2,90,0.5",
        "--seed",
        "5",
        "--out",
    ];
    succeeds(&[&arguments[..], &[text(&flight)]].concat());
    let flown = summary(&flight);
    assert!(flown["flight"]["crashed_s"].is_null(), "{flown}");
    assert_eq!(flown["flight"]["last_mode"], "position");
    assert_eq!(flown["flight"]["disturbances"][1]["time_s"], 45.0);
    assert!(flown["error"]["vn_mps"]["rmse"].as_f64().expect("scored") < 0.3);
    assert!(fs::metadata(flight.join("report.html")).expect("a page").len() > 1_000_000);

    succeeds(&["estimate", text(&flight), "--out", text(&again), "--no-report"]);
    // Angles are recorded in degrees; the results agree to that rounding.
    for axis in ["north_m", "vd_mps", "roll_deg", "yaw_deg"] {
        let error = |summary: &Value| summary["error"][axis]["rmse"].as_f64().expect("scored");
        let (simulated, estimated) = (error(&flown), error(&summary(&again)));
        assert!((simulated - estimated).abs() < 1e-6, "{axis}: {simulated} {estimated}");
    }

    let same = place("fly_same");
    succeeds(&[&arguments[..], &[text(&same), "--no-report"]].concat());
    for file in ["imu.csv", "gps.csv", "controls.csv", "reference.csv"] {
        let read = |dir: &Path| fs::read(dir.join(file)).expect("readable");
        assert!(read(&flight) == read(&same), "{file} differs with the same seed");
    }
}

#[test]
fn what_cannot_be_designed_or_flown_is_refused_with_the_reason() {
    let dir = place("refusals");
    let write = |name: &str, text: &str| {
        let path = dir.join(name);
        fs::write(&path, text).expect("writable");
        path
    };
    let shipped = include_str!("../../../crates/model/src/data/thesis.toml");
    let no_pedal = shipped.replace("0.043484, -6.5782]", "0.0, 0.0]");
    let discrete = shipped
        .replace("time_domain = \"continuous\"", "time_domain = \"discrete\"\nperiod_s = 0.03");
    for (model, expected) in [
        (write("no_pedal.toml", &no_pedal), "no input controls it"),
        (write("discrete.toml", &discrete), "the model is discrete, expected a continuous model"),
        (write("broken.toml", "name = 3"), "broken.toml:1"),
        (dir.join("nowhere.toml"), "nowhere.toml"),
    ] {
        assert_refused(&["design", text(&model), "--out", text(&dir)], expected);
    }
    let weights = write(
        "weights.toml",
        "[yaw]\nstates = [1.0, -10.0]\nintegral = 1.0\nstick = 1.0\ndecay_per_s = 0.0\n",
    );
    let design = ["design", "raptor60", "--out", text(&dir), "--weights", text(&weights)];
    assert_refused(&design, "weights.toml: yaw.states: found -10, expected above 0");

    let good = fs::read_to_string(designed().join("autopilot.toml")).expect("an autopilot");
    let (start, end) = good.split_once("proportional = ").expect("a PID gain");
    let (_, end) = end.split_once('\n').expect("a line");
    let nan = write("nan.toml", &format!("{start}proportional = nan\n{end}"));
    assert_refused(
        &["simulate", "--autopilot", text(&nan), "--out", text(&dir)],
        "gains.heave: found NaN",
    );
    assert_refused(
        &["campaign", "--autopilot", text(&nan), "--out", text(&dir)],
        "gains.heave: found NaN",
    );
    assert_refused(
        &["simulate", "--disturbance", "p=1@500", "--duration", "60", "--out", text(&dir)],
        "disturbance at 500 s",
    );
    let sweep = ["simulate", "--excite", "lateral=sweep@30", "--fault", "jam-pedal@40"];
    assert_refused(
        &[&sweep[..], &["--duration", "70", "--out", text(&dir)]].concat(),
        "end of a test input at 90 s: found a flight of 70 s",
    );
}

#[test]
fn a_model_that_is_not_to_be_flown_by_is_refused_by_everything_that_flies_it() {
    let dir = place("unflyable");
    let model = dir.join("model.toml");
    let shipped = include_str!("../../../crates/model/src/data/raptor60.toml");
    let verdict = "verdict = \"do not fly\"\nreasons = [\"Lb has the wrong sign\"]\nstates = [";
    fs::write(&model, shipped.replacen("states = [", verdict, 1)).expect("writable");
    for verb in ["simulate", "campaign"] {
        assert_refused(
            &[verb, "--model", text(&model), "--out", text(&dir)],
            "\"do not fly\" (Lb has the wrong sign), expected a flyable model; design an autopilot for it \
             with `hovernav design --force` and pass that with --autopilot",
        );
    }
    let design = ["design", text(&model), "--out", text(&dir)];
    assert_refused(&design, "--force designs for it anyway");
    // With given weights, no search is needed.
    let weights = dir.join("weights.toml");
    fs::write(&weights, "").expect("writable");
    let words = succeeds(&[&design[..], &["--weights", text(&weights), "--force"]].concat());
    assert!(words.contains("raptor60-hover is \"do not fly\": Lb has"), "{words}");
    let page = fs::read_to_string(dir.join("report.html")).expect("a page");
    assert!(page.contains("Do not fly: the design is based on a model"));
}

#[test]
fn an_identified_model_without_its_verdict_is_refused_and_one_by_hand_is_not() {
    let dir = place("no_verdict");
    let model = dir.join("model.toml");
    let by_hand = include_str!("../../../crates/model/src/data/raptor60.toml");
    let parameters = "parameters = [{ name = \"Nr\", value = -4.0, unit = \"1/s\" }]\nstates = [";
    let with_parameters = by_hand.replacen("states = [", parameters, 1);
    let identified =
        with_parameters.replacen("states = [", "parameter_covariance = [[0.01]]\nstates = [", 1);
    fs::write(&model, &identified).expect("writable");
    let design = ["design", text(&model), "--no-report", "--out", text(&dir)];
    let expected = "found the covariance of identified parameters and no verdict";
    assert_refused(&design, expected);
    assert_refused(&["simulate", "--model", text(&model), "--out", text(&dir)], expected);
    // One of the results of an identification is sufficient to recognise an identified model.
    let slopes =
        "slopes = [{ parameter = \"Nr\", row = \"r\", column = \"r\", slope = 1.0 }]\nstates = [";
    fs::write(&model, with_parameters.replacen("states = [", slopes, 1)).expect("writable");
    assert_refused(&design, "found the slopes of identified parameters and no verdict");
    let source = "source = \"identified by prediction error from 242 s of a flight, not ";
    fs::write(&model, by_hand.replacen("source = \"", source, 1)).expect("writable");
    assert_refused(&design, "found a source that states identification and no verdict");
    let good = identified.replacen("states = [", "verdict = \"good\"\nstates = [", 1);
    let weights = dir.join("weights.toml");
    fs::write(&weights, "").expect("writable");
    for flyable in [&with_parameters, &good] {
        fs::write(&model, flyable).expect("writable");
        succeeds(&[&design[..], &["--weights", text(&weights)]].concat());
    }
}

#[test]
fn a_model_with_a_sign_that_no_helicopter_has_is_refused_unless_forced() {
    let dir = place("wrong_sign");
    let model = dir.join("model.toml");
    let weights = dir.join("weights.toml");
    fs::write(&weights, "").expect("writable");
    let design = ["design", text(&model), "--weights", text(&weights), "--out", text(&dir)];
    let by_hand = include_str!("../../../crates/model/src/data/raptor60.toml");
    let expected = "B, row w, column collective: found Zcol 9.56839882414713, expected it below 0: with a positive \
                    collective stick it sinks; ";
    fs::write(&model, by_hand.replacen("-9.56839882414713", "9.56839882414713", 1))
        .expect("writable");
    assert_refused(&design, &format!("{expected}--force designs for it anyway"));
    assert_refused(&["simulate", "--model", text(&model), "--out", text(&dir)], expected);
    for (from, to, expected) in [
        ("102.68219389546671", "-102.68219389546671", "A, row p, column b: found Lb -102.6"),
        ("81.06488991747372", "-81.06488991747372", "A, row q, column a: found Ma -81.0"),
        ("59.836975673827496", "-59.836975673827496", "B, row r, column pedal: found Nped -59.8"),
        (
            "states = [",
            "verdict = \"good\"\nparameters = [{ name = \"Nr\", value = 3.7, unit = \"1/s\" }]\n\
             parameter_covariance = [[0.01]]\nstates = [",
            "parameters: found Nr 3.7, expected it below 0",
        ),
    ] {
        fs::write(&model, by_hand.replacen(from, to, 1)).expect("writable");
        assert_refused(&design, expected);
    }
    // The matrices of the last model are equal to those of the vehicle.
    let words = succeeds(&[&design[..], &["--force"]].concat());
    assert!(words.contains("the model must not be flown: parameters: found Nr 3.7"), "{words}");
    let page = fs::read_to_string(dir.join("report.html")).expect("a page");
    assert!(page.contains("Do not fly: the design is based on a model"));
}

#[test]
fn a_notch_is_counted_in_the_margins_and_its_phase_reported() {
    let dir = place("notch");
    let weights = dir.join("weights.toml");
    fs::write(&weights, "").expect("writable");
    let design = ["design", "raptor60", "--weights", text(&weights), "--no-report"];
    let phase = |further: &[&str]| {
        let out = [&design[..], &["--out", text(&dir)], further].concat();
        let words = succeeds(&out);
        (summary(&dir), words)
    };
    let (without, _) = phase(&[]);
    let (with, words) = phase(&["--notch", "25:5", "--imu-rate", "200"]);
    assert!(words.contains("notch at 25 Hz in samples of 200 Hz: delay 1.3 ms"), "{words}");
    for (name, cost) in with["notch"]["loops"].as_object().expect("loops") {
        let lost_deg = cost["phase_lost_deg"].as_f64().expect("a number");
        let margin = |of: &Value| of["margins"][name]["phase_deg"].as_f64().expect("a margin");
        assert!((margin(&without) - margin(&with) - lost_deg).abs() < 0.3, "{name}: {lost_deg}");
    }
    assert!(words.contains("delay of the estimator: 6.5 ms in rates"), "{words}");
    assert_eq!(hovernav(&["design", "raptor60", "--notch", "25:0"]).status.code(), Some(2));
}

#[test]
fn a_weight_too_many_is_refused() {
    let dir = place("surplus");
    let weights = dir.join("weights.toml");
    let yaw = "integral = 1.0\nstick = 1.0\ndecay_per_s = 0.0\n";
    fs::write(&weights, format!("[yaw]\nstates = [1.0, 2.0, 3.0]\n{yaw}")).expect("writable");
    assert_refused(
        &["design", "raptor60", "--weights", text(&weights), "--out", text(&dir)],
        "found yaw.states.2, counted from 0, expected one weight fewer",
    );
}

#[test]
fn a_flight_that_crashes_fails_after_its_record_is_written() {
    let dir = place("crashes");
    let told = "the vehicle crashed at ";
    let lost = ["simulate", "--wind", "calm", "--fault", "power-loss@35", "--no-report"];
    assert_refused(&[&lost[..], &["--duration", "90", "--out", text(&dir)]].concat(), told);
    assert!(summary(&dir)["flight"]["crashed_s"].as_f64().expect("it crashed") > 35.0);
    assert!(dir.join("reference.csv").exists() && dir.join("controls.csv").exists());
}

#[test]
fn an_autopilot_that_is_unstable_in_a_mode_is_not_written_unless_forced() {
    let dir = place("unstable_mode");
    // Heave and roll are coupled: stable with velocity hold, unstable with attitude hold alone.
    let model = dir.join("coupled.toml");
    let shipped = include_str!("../../../crates/model/src/data/raptor60.toml");
    let coupled = shipped.replacen("0.07815841890740173", "60.0", 1).replacen(
        "-0.6226718036949341",
        "-6.0",
        1,
    );
    fs::write(&model, coupled).expect("writable");
    let weights = dir.join("weights.toml");
    let weak = "[attitude]\nstates = [1e-6, 1e-6, 1e-6, 1e-6]\nintegrals = [1e-9, 1e-9]\n\
                sticks = [1.0, 1.0]\ndecay_per_s = 0.0\n\
                [estimator]\nrate_s = 0.0\nattitude_s = 0.0\nvelocity_s = 0.0\n";
    fs::write(&weights, weak).expect("writable");
    let design =
        ["design", text(&model), "--weights", text(&weights), "--no-report", "--out", text(&dir)];
    fs::write(dir.join("autopilot.toml"), "of an earlier design").expect("writable");
    assert_refused(&design, "the loops are unstable in the mode attitude: no autopilot.toml");
    assert!(!dir.join("autopilot.toml").exists(), "the file of an earlier design must be removed");
    assert!(summary(&dir)["modes"]["attitude"].is_null());
    succeeds(&[&design[..], &["--force"]].concat());
    assert!(dir.join("autopilot.toml").exists());
}

#[test]
fn a_weight_that_is_none_is_refused_with_its_key_and_a_delay_that_is_omitted_is_reported() {
    let dir = place("weights");
    let weights = dir.join("weights.toml");
    let design = |model: &str| {
        ["design", model, "--weights", text(&weights), "--no-report", "--out", text(&dir)]
            .map(str::to_owned)
    };
    let pitch = "[roll_pitch]\nstates = [1, 1, 10, 15, 0.6, 0.6]\nintegrals = [0.2, 0.2]\nsticks = [10, 10]\n";
    for (written, expected) in [
        ("period_s = 1e300\n".to_owned(), "period_s: found"),
        ("period_s = 0.5\n".to_owned(), "period_s: found 0.5, expected 0.001 to 0.2 s"),
        ("servo_s = nan\n".to_owned(), "servo_s: found NaN"),
        (format!("{pitch}decay_per_s = nan\n"), "roll_pitch.decay_per_s: found NaN"),
        (format!("{pitch}decay_per_s = 1e300\n"), "roll_pitch.decay_per_s: found 1"),
        (
            "[heave]\nfrequency_radps = 3\ndamping = 1\nderivative_s = inf\nderivative_filter_s = 0.05\n"
                .to_owned(),
            "heave.derivative_s: found inf",
        ),
    ] {
        fs::write(&weights, &written).expect("writable");
        let arguments = design("raptor60");
        let message = refusal(&arguments.each_ref().map(String::as_str));
        assert!(message.contains("weights.toml") && message.contains(expected), "{written}: {message}");
    }
    let late = dir.join("late.toml");
    let shipped = include_str!("../../../crates/model/src/data/raptor60.toml");
    let delay = "parameters = [{ name = \"tau_ped\", value = 0.4, unit = \"s\" }]\nstates = [";
    fs::write(&late, shipped.replacen("states = [", delay, 1)).expect("writable");
    // Without this line, the lag of the tail servo is the delay of the model, up to the limit of the design.
    fs::write(&weights, "tail_servo_s = 0.0133\n").expect("writable");
    let arguments = design(text(&late));
    let words = succeeds(&arguments.each_ref().map(String::as_str));
    assert!(
        words.contains("the model delays pedal by 400 ms, but the design includes only 44 ms"),
        "{words}"
    );
}

#[test]
fn test_points_that_are_flown_are_found_and_give_the_heave() {
    let dir = place("test_points");
    let (flown, found) = (dir.join("flown"), dir.join("found"));
    succeeds(&[
        "simulate",
        "--test-points",
        "--wind",
        "1,135,0.3",
        "--seed",
        "5",
        "--no-report",
        "--out",
        text(&flown),
    ]);
    succeeds(&["identify", text(&flown), "--model", "heave", "--no-report", "--out", text(&found)]);
    let model = fs::read_to_string(found.join("model.toml")).expect("a model");
    let (_, after) = model.split_once("name = \"Zw\", value = ").expect("a heave damping");
    let zw_per_s: f64 =
        after.split(',').next().and_then(|value| value.trim().parse().ok()).unwrap();
    // The true value of the vehicle is -0.80 1/s.
    assert!((-1.3..-0.3).contains(&zw_per_s), "{zw_per_s}");
}

#[test]
fn wrong_usage_exits_with_two() {
    for arguments in [
        &["design"][..],
        &["simulate", "--disturbance", "x=1"],
        &["simulate", "--disturbance", "p=nan"],
        &["simulate", "--disturbance", "phi=90"],
        &["simulate", "--wind", "-3"],
        &["simulate", "--place", "1.3,103.8,50,7"],
        &["simulate", "--place", "1.3,103.8,50,abc"],
        &["simulate", "--disturbance", "p=1@-5"],
        &["simulate", "--excite", "pedal=3211@-1"],
        &["simulate", "--excite", "all=3211:0"],
        &["simulate", "--flight", "tour", "--disturbance", "p=1"],
        &["campaign", "--shard", "3/2"],
        &["campaign", "--flights", "0"],
    ] {
        assert_eq!(hovernav(arguments).status.code(), Some(2), "{arguments:?}");
    }
}
