//! The interface for other programs: files, columns and exit status of the command.

use std::fs;
use std::path::PathBuf;

use crate::common::{
    HELI, assert_keys, changed, hovernav, place, refusal, succeeds, summary, text,
};

/// A copy of the helicopter's first minute, with one `file` changed by `change`.
fn damaged(name: &str, file: &str, change: impl Fn(String) -> String) -> PathBuf {
    changed(HELI, name, &["imu.csv", "gps.csv", "dataset.toml"], |part, mut content| {
        if part == "imu.csv" {
            content = content.lines().take(2000).map(|line| format!("{line}\n")).collect();
        }
        Some(if part == file { change(content) } else { content })
    })
}

#[test]
fn terminal_summary_and_page_state_the_same_verdict() {
    let log = damaged("verdict", "gps.csv", |content| {
        // No fixes for 20 s in the middle.
        let is_out = |line: &str| {
            let time = line.split(',').next().and_then(|time| time.parse::<f64>().ok());
            time.is_some_and(|time| (20.0..40.0).contains(&time))
        };
        content.lines().filter(|line| !is_out(line)).map(|line| format!("{line}\n")).collect()
    });
    let out = place("verdict_out");
    let words = succeeds(&["estimate", text(&log), "--out", text(&out)]);
    let summary = summary(&out);
    let verdict = &summary["verdict"];
    assert_eq!(verdict["level"], "care", "{words}");
    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    let said = verdict["words"].as_str().expect("words");
    assert!(words.starts_with(said) && page.contains(said), "{words}");
    let reason = verdict["reasons"][0].as_str().expect("a reason");
    assert!(reason.contains("outage") && words.contains(&format!("  - {reason}")), "{words}");
    assert_eq!(words.matches(reason).count(), 1, "{words}");
    // The page escapes quotes and similar characters; the first words of the reason contain none of them.
    assert!(page.contains(&reason[..30]), "{reason}");
    let findings = summary["findings"].as_array().expect("findings");
    let outage = findings.iter().find(|one| one["kind"] == "outage").expect("an outage");
    assert!(outage["harm"]["growth"].as_f64().is_some_and(|growth| growth > 2.0), "{outage}");
    assert!(outage["harm"]["one_sigmas"].is_null(), "{outage}");
}

#[test]
fn an_estimate_leaves_the_files_others_rely_on() {
    let out = place("estimate");
    succeeds(&["estimate", HELI, "--out", text(&out)]);
    let summary = summary(&out);
    assert_keys(&summary, &["warnings"]);
    let axes = [
        "north_m",
        "east_m",
        "down_m",
        "horizontal_m",
        "vn_mps",
        "ve_mps",
        "vd_mps",
        "u_mps",
        "v_mps",
        "w_mps",
        "roll_deg",
        "pitch_deg",
        "yaw_deg",
    ];
    for axis in axes {
        for statistic in ["rmse", "median", "p95", "max"] {
            assert!(summary["error"][axis][statistic].is_f64(), "{axis} {statistic}");
        }
    }
    let solution = fs::read_to_string(out.join("solution.csv")).expect("a solution");
    let header = "t_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,yaw_deg,u_mps,\
                  v_mps,w_mps,p_radps,q_radps,r_radps,sigma_n_m,sigma_e_m,sigma_d_m,sigma_vn_mps,\
                  sigma_ve_mps,sigma_vd_mps,sigma_roll_deg,sigma_pitch_deg,sigma_yaw_deg,\
                  gyro_bias_x_radps,gyro_bias_y_radps,gyro_bias_z_radps,accel_bias_x_mps2,\
                  accel_bias_y_mps2,accel_bias_z_mps2";
    assert_eq!(solution.lines().next(), Some(header));
    assert!(solution.lines().count() > 9800);
    assert!(!solution.contains("NaN") && !solution.contains("inf"));
    assert!(fs::metadata(out.join("report.html")).expect("a page").len() > 1_000_000);
}

#[test]
fn the_helicopters_errors_stay_within_what_validation_promises() {
    let out = place("promise");
    for (arguments, limits) in [
        (
            &["--no-report"][..],
            &[
                ("vn_mps", 0.080),
                ("ve_mps", 0.085),
                ("vd_mps", 0.11),
                ("roll_deg", 0.42),
                ("pitch_deg", 0.45),
                ("yaw_deg", 1.2),
            ][..],
        ),
        (&["--no-report", "--smooth"], &[("vn_mps", 0.065), ("ve_mps", 0.065), ("vd_mps", 0.09)]),
    ] {
        succeeds(&[&["estimate", HELI, "--out", text(&out)], arguments].concat());
        let summary = summary(&out);
        for (axis, limit) in limits {
            let rmse = summary["error"][axis]["rmse"].as_f64().expect("scored");
            assert!(rmse <= *limit, "{axis} {rmse} with {arguments:?}");
        }
        for (axis, inside) in summary["within_3_sigma"].as_object().expect("scored") {
            assert!(inside.as_f64().expect("a number") >= 0.98, "{axis} {inside}");
        }
    }
}

#[test]
fn bad_input_is_refused_in_one_line_that_names_the_place() {
    let out = place("refused");
    let no_gps = damaged("no_gps", "gps.csv", |text| text.lines().take(1).collect());
    let text_in_number =
        damaged("text", "imu.csv", |text| text.replacen(",0.0047937,", ",abc,", 1));
    let no_column = damaged("column", "imu.csv", |text| text.replacen("gyro_y_radps", "gyro_q", 1));
    let empty = damaged("empty", "imu.csv", |_| String::new());
    for (log, expected) in [
        (PathBuf::from("nowhere"), "nowhere: no such file or directory, expected a log"),
        (no_gps, "gps.csv: found no usable fix"),
        (text_in_number, "imu.csv:2: column gyro_y_radps: found \"abc\", expected a number"),
        (no_column, "imu.csv:1: expected column gyro_x_radps,gyro_y_radps"),
        (empty, "imu.csv: the file is empty"),
    ] {
        let message = refusal(&["estimate", text(&log), "--out", text(&out)]);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn what_is_not_there_is_reported_with_what_was_expected() {
    let out = place("not_there");
    let csv = format!("{HELI}/imu.csv");
    for (arguments, expected) in [
        (&["estimate", &csv][..], "imu.csv: found one file of a dataset, expected its directory"),
        (&["score", "nowhere", HELI], "nowhere: no such file or directory, expected a trajectory"),
        (&["score", HELI, HELI], "heli-hover: found neither solution.csv nor mapping.toml"),
        #[cfg(feature = "record")]
        (&["report", &csv], "imu.csv: at byte 0: found \"t_s,gyro\", expected an MCAP file"),
    ] {
        let message = refusal(arguments);
        assert!(message.contains(expected), "{message}");
    }
    if cfg!(feature = "lab") {
        let message = refusal(&["design", "nowhere"]);
        assert!(
            message.contains("nowhere: no such file, expected a model.toml, or thesis"),
            "{message}"
        );
        let inject = ["inject", HELI, "--fault", "outage=10@1000", "--out", text(&out)];
        let expected = "found a start at 1000 s, expected a time within the log, ";
        assert!(refusal(&inject).contains(expected));
    }
    let far = ["estimate", HELI, "--no-report", "--outage", "2000:5", "--out", text(&out)];
    assert!(succeeds(&far).contains("outside the log"));
}

#[test]
fn numbers_out_of_range_are_wrong_usage() {
    for arguments in [
        &["estimate", HELI, "--gps-rate", "-1"][..],
        &["score", "a", "b", "--skip", "-1"],
        #[cfg(feature = "lab")]
        &["campaign", "--outages", "7"],
        #[cfg(feature = "lab")]
        &["campaign", "--wind", "-2"],
        #[cfg(feature = "lab")]
        &["simulate", "--duration", "-5"],
        #[cfg(feature = "fly")]
        &["play", HELI, "--dmu", "port", "--speed", "0"],
    ] {
        let run = hovernav(arguments);
        let message = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(2), "{arguments:?}: {message}");
        let found = format!("found \"{}\", expected", arguments[arguments.len() - 1]);
        assert!(message.contains(&found), "{arguments:?}: {message}");
    }
}

#[test]
fn what_can_be_mended_is_mended_with_a_warning() {
    let out = place("mended");
    let mute = |text: String| text.replacen(",0.0047937,", ",nan,", 1);
    let twice = |text: String| {
        let lines: Vec<&str> = text.lines().collect();
        [&lines[..500], &lines[499..]].concat().join("\n")
    };
    let hole = |text: String| {
        let lines: Vec<&str> = text.lines().collect();
        [&lines[..1000], &lines[1100..]].concat().join("\n")
    };
    for (log, expected) in [
        (damaged("mute", "imu.csv", mute), "a value is missing"),
        (damaged("twice", "imu.csv", twice), "same time as the row before"),
        (damaged("hole", "imu.csv", hole), "gap"),
        (
            damaged("pole", "gps.csv", |text| text.replacen("1.3521", "99.3521", 1)),
            "not a position on Earth",
        ),
    ] {
        succeeds(&["estimate", text(&log), "--out", text(&out), "--no-report"]);
        let warnings = summary(&out)["warnings"].to_string();
        assert!(warnings.contains(expected), "{warnings}");
        let solution = fs::read_to_string(out.join("solution.csv")).expect("a solution");
        assert!(!solution.contains("NaN") && solution.lines().count() > 1500);
    }
}

#[test]
fn wrong_usage_exits_with_two() {
    for arguments in [
        &["estimate"][..],
        &["estimate", HELI, "--outage", "5"],
        &["estimate", HELI, "--gps-rate", "-1"],
        &["fly-me-to-the-moon"],
    ] {
        assert_eq!(hovernav(arguments).status.code(), Some(2), "{arguments:?}");
    }
}

#[cfg(feature = "lab")]
#[test]
fn a_simulated_flight_is_a_dataset_that_can_be_estimated() {
    let (log, out) = (place("simulated"), place("simulated_out"));
    let run =
        hovernav(&["simulate", "--out", text(&log), "--flight", "test-points", "--seed", "3"]);
    assert!(run.status.success(), "{run:?}");
    assert_keys(&summary(&log), &["warnings", "error"]);
    assert!(fs::metadata(log.join("report.html")).expect("a page").len() > 1_000_000);
    succeeds(&["estimate", text(&log), "--out", text(&out), "--no-report"]);
    assert!(summary(&out)["error"]["vn_mps"]["rmse"].as_f64().expect("scored") < 0.3);
    succeeds(&["info", text(&log)]);
}
