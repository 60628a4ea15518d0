//! From a recorded flight to a model that others can read, or to one line that says why not.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hovernav_model::{StateSpace, TimeDomain};
use serde_json::Value;

const HELI: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../datasets/heli-hover");

/// The helicopter's flight with three test points on each stick, or a line that says it is missing.
fn flight() -> Option<&'static Path> {
    let flight = Path::new(HELI);
    if flight.is_dir() {
        return Some(flight);
    }
    println!("skipped: {HELI} is missing");
    None
}

fn hovernav(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hovernav")).args(arguments).output().expect("the command runs")
}

/// A place of this test's own.
fn place(name: &str) -> PathBuf {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&place);
    fs::create_dir_all(&place).expect("a directory can be made");
    place
}

fn text(path: &Path) -> &str {
    path.to_str().expect("the path is text")
}

fn summary(out: &Path) -> Value {
    let text = fs::read_to_string(out.join("summary.json")).expect("a summary");
    serde_json::from_str(&text).expect("valid JSON")
}

/// A copy of the flight without what scores it; `change` gives a file's new text, or takes it away.
fn changed(flight: &Path, name: &str, change: impl Fn(&str, String) -> Option<String>) -> PathBuf {
    let dir = place(name);
    for part in ["imu.csv", "gps.csv", "controls.csv", "dataset.toml"] {
        let content = fs::read_to_string(flight.join(part)).expect("readable");
        if let Some(content) = change(part, content) {
            fs::write(dir.join(part), content).expect("writable");
        }
    }
    dir
}

/// The one line with which the command refuses.
fn refusal(arguments: &[&str]) -> String {
    let run = hovernav(arguments);
    assert_eq!(run.status.code(), Some(1), "{run:?}");
    let said = String::from_utf8(run.stderr).expect("text");
    assert_eq!(said.lines().count(), 1, "{said}");
    said
}

#[test]
fn an_identification_leaves_a_model_a_summary_and_a_page() {
    let Some(flight) = flight() else { return };
    // Without the reference and the true parameters: neither may be needed.
    let flight = changed(flight, "identify-flight", |_, content| Some(content));
    let out = place("identify-hybrid");
    let run = hovernav(&["identify", text(&flight), "--model", "hybrid", "--out", text(&out)]);
    assert!(run.status.success(), "{run:?}");

    let summary = summary(&out);
    for key in [
        "tool",
        "version",
        "input",
        "duration_s",
        "wall_s",
        "imu_samples",
        "gps_fixes_used",
        "gps_fixes_rejected",
        "warnings",
        "model",
        "log",
    ] {
        assert!(!summary[key].is_null(), "{key}");
    }
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
    assert!((model.b()[(r, pedal)] - value("Nped")).abs() < 1e-9);
    assert!((model.a()[(r, r)] - value("Nr")).abs() < 1e-9);
    let covariance = model.covariance().expect("a covariance");
    let place = model.parameters().iter().position(|known| known.name == "Nr").expect("Nr");
    let bound = of("Nr").and_then(|found| found["bound"].as_f64()).expect("a bound");
    assert!((covariance[(place, place)].sqrt() / bound - 1.0).abs() < 1e-6);

    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    for anchor in ["parameters", "histories", "residuals", "bode", "poles", "held-gps"] {
        assert!(page.contains(&format!("<section id=\"{anchor}\">")), "{anchor}");
        let drawn = page.contains(&format!("data-figure=\"{anchor}\""));
        assert_eq!(drawn, anchor != "parameters", "{anchor}");
    }
    for told in ["Bounds of the parameters (1σ): median ±", "Insensitivity", "95 % region"] {
        assert!(page.contains(told), "{told}");
    }
    let table = String::from_utf8(run.stdout).expect("text");
    for told in ["Nped", "bound %", "insensitivity %", "noise floor", "held GPS fit %"] {
        assert!(table.contains(told), "{told}: {table}");
    }
}

#[test]
fn a_flight_without_sticks_is_refused() {
    let Some(flight) = flight() else { return };
    let dir = changed(flight, "identify-no-sticks", |part, content| {
        (part != "controls.csv").then_some(content)
    });
    let said = refusal(&["identify", text(&dir), "--out", text(&place("identify-no-sticks-out"))]);
    assert!(said.contains("controls.csv") && said.contains("nothing to identify from"), "{said}");
}

#[test]
fn a_pedal_that_never_moves_is_named() {
    let Some(flight) = flight() else { return };
    let dir = changed(flight, "identify-still-pedal", |part, content| {
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
    let said = refusal(&yaw);
    assert!(said.contains("pedal") && said.contains("no test point"), "{said}");
    // The rest of the helicopter can still be identified, and the reader is told.
    let run = hovernav(&["identify", text(&dir), "--model", "hover", "--out", text(&out)]);
    assert!(run.status.success(), "{run:?}");
    let warnings = summary(&out)["warnings"].to_string();
    assert!(warnings.contains("input `pedal` never moves"), "{warnings}");
}

#[test]
fn a_flight_too_short_is_refused() {
    let Some(flight) = flight() else { return };
    let dir = changed(flight, "identify-short", |part, content| {
        let rows = if part == "imu.csv" || part == "controls.csv" { 330 } else { usize::MAX };
        Some(content.lines().take(rows).map(|line| format!("{line}\n")).collect())
    });
    let said = refusal(&["identify", text(&dir), "--out", text(&place("identify-short-out"))]);
    assert!(said.contains("no test point"), "{said}");
}

#[test]
fn a_model_that_there_is_not_is_wrong_usage() {
    let run = hovernav(&["identify", HELI, "--model", "glider"]);
    assert_eq!(run.status.code(), Some(2), "{run:?}");
    assert!(String::from_utf8_lossy(&run.stderr).contains("expected yaw, heave"), "{run:?}");
}
