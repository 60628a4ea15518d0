//! The command in pipes and scripts, and with wrong input.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use approx::assert_abs_diff_eq;
use serde_json::Value;

use crate::common::{self, HELI, hovernav, place, refusal, succeeds, text};

#[test]
fn a_reader_that_has_gone_causes_no_panic() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_hovernav"))
        .args(["info", HELI])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    drop(child.stdout.take());
    let run = child.wait_with_output().expect("it ends");
    assert!(run.status.success() && run.stderr.is_empty(), "{run:?}");
}

#[cfg(unix)]
#[test]
fn an_error_that_nobody_reads_keeps_its_exit_status() {
    for (arguments, status) in [
        (&["info", "not-there"][..], 1),
        (&["estimate", "not-there", "nor-this"], 1),
        (&["info", "--no-such-option"], 2),
    ] {
        let (gone, ours) = std::os::unix::net::UnixStream::pair().expect("a pair of sockets");
        drop(gone);
        let mut command = Command::new(env!("CARGO_BIN_EXE_hovernav"));
        let run = command.args(arguments).stderr(std::os::fd::OwnedFd::from(ours)).output();
        assert_eq!(run.expect("the command runs").status.code(), Some(status), "{arguments:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_standard_output_cannot_take_is_reported() {
    for arguments in [&["info", HELI][..], &["config", "dataset.toml"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
        let mut command = Command::new(env!("CARGO_BIN_EXE_hovernav"));
        let run = command.args(arguments).stdout(full).output().expect("the command runs");
        let message = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(1), "{message}");
        assert!(message.starts_with("hovernav: cannot write to standard output: "), "{message}");
    }
}

#[test]
fn info_is_one_json_object_for_programs() {
    let info: Value = serde_json::from_str(&succeeds(&["info", HELI, "--json"])).expect("JSON");
    assert_eq!(info["sensors"]["imu"]["samples"], 9899);
    assert_eq!(info["format"], "dataset directory");
    assert_abs_diff_eq!(
        info["sensors"]["gps"]["rate_hz"].as_f64().expect("a rate"),
        1.0,
        epsilon = 0.01
    );
}

#[test]
fn the_json_of_info_has_what_its_text_shows() {
    let info: Value = serde_json::from_str(&succeeds(&["info", HELI, "--json"])).expect("JSON");
    let shown = succeeds(&["info", HELI]);
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("a number: {info:#}"));
    let lines = info["imu"]["lines"].as_array().expect("lines of vibration");
    let first = format!("{:.2} Hz", number(&lines[0]["frequency_hz"]));
    assert!(shown.contains(&first), "{first}\n{shown}");
    let fastest = format!("fastest     {:.1} m/s", number(&info["gps"]["fastest_mps"]));
    assert!(shown.contains(&fastest), "{fastest}\n{shown}");
    assert_eq!(info["imu"]["magnetic_field"]["samples"], 9899);
    assert_eq!(info["gps"]["antenna_lever_arm_m"][0], -0.35);
    assert_abs_diff_eq!(number(&info["gps"]["extent_m"][0][1]), 84.6, epsilon = 0.05);
    assert!(info["missing"].is_array() && info["setup"].is_array() && info["findings"].is_array());
}

#[test]
fn info_states_no_speed_of_a_receiver_without_velocities() {
    let dir = place("no-velocities");
    for name in ["dataset.toml", "imu.csv"] {
        fs::copy(Path::new(HELI).join(name), dir.join(name)).expect("a copy");
    }
    let fixes = fs::read_to_string(Path::new(HELI).join("gps.csv")).expect("fixes");
    let names: Vec<&str> = fixes.lines().next().expect("names").split(',').collect();
    let kept = |line: &str| {
        let fields = line.split(',').zip(&names).filter(|(_, name)| !name.ends_with("_mps"));
        fields.map(|(field, _)| field).collect::<Vec<_>>().join(",") + "\n"
    };
    fs::write(dir.join("gps.csv"), fixes.lines().map(kept).collect::<String>()).expect("fixes");
    let shown = succeeds(&["info", text(&dir)]);
    assert!(shown.contains("fastest     not stated"), "{shown}");
    let info: Value =
        serde_json::from_str(&succeeds(&["info", text(&dir), "--json"])).expect("JSON");
    assert!(info["gps"]["fastest_mps"].is_null(), "{info:#}");
}

#[test]
fn quiet_writes_files_and_no_words() {
    let out = place("quiet");
    let said = succeeds(&["-q", "estimate", HELI, "--no-report", "--out", text(&out)]);
    assert!(said.is_empty() && out.join("solution.csv").exists(), "{said}");
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_instead_of_waited_for() {
    let dir = place("devices");
    std::os::unix::fs::symlink("/dev/zero", dir.join("imu.csv")).expect("a link");
    assert!(refusal(&["info", text(&dir)]).contains("imu.csv: found a pipe or a device"));
    let pipe = dir.join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status().expect("mkfifo runs");
    assert!(made.success());
    assert!(refusal(&["info", text(&pipe)]).contains("expected a file"));
    assert!(refusal(&["score", text(&pipe), HELI]).contains("expected a file"));
    for file in ["dataset.toml", "imu.csv", "gps.csv", "controls.csv", "reference.csv"] {
        let files = ["dataset.toml", "imu.csv", "gps.csv", "controls.csv", "reference.csv"];
        let keep = |part: &str, content| (part != file).then_some(content);
        let dataset = common::changed(HELI, "devices-within", &files, keep);
        let made = Command::new("mkfifo").arg(dataset.join(file)).status().expect("mkfifo runs");
        assert!(made.success());
        let out = dataset.join("out");
        for arguments in [
            &["estimate", text(&dataset), "--no-report", "--out", text(&out)][..],
            &["convert", text(&dataset), "--out", text(&out)],
        ] {
            let refused = refusal(arguments);
            let expected = format!("{file}: found a pipe or a device, expected a file");
            assert!(refused.contains(&expected), "{refused}");
        }
    }
}

#[cfg(unix)]
#[test]
fn results_in_the_place_of_devices_and_pipes_end_with_a_sentence() {
    for (target, expected) in [
        ("/dev/full", Some("No space left on device")),
        ("/dev/zero", None),
        ("pipe", Some("summary.json: found a pipe that nothing reads, expected a file")),
    ] {
        let out = place("devices-out");
        let summary = out.join("summary.json");
        match target {
            "pipe" => {
                let made = Command::new("mkfifo").arg(&summary).status().expect("mkfifo runs");
                assert!(made.success());
            }
            device => std::os::unix::fs::symlink(device, &summary).expect("a link"),
        }
        let arguments = ["estimate", "--no-report", "--out", text(&out), HELI];
        match expected {
            Some(expected) => {
                let said = refusal(&arguments);
                assert!(said.contains(expected), "{target}: {said}");
            }
            None => assert!(!succeeds(&arguments).is_empty()),
        }
    }
}

#[test]
fn results_go_to_standard_output_and_warnings_to_standard_error() {
    let out = place("warnings");
    let warned = out.join("log");
    succeeds(&["convert", HELI, "--out", text(&warned)]);
    let imu = fs::read_to_string(warned.join("imu.csv")).expect("samples");
    let repeated: String = imu.lines().map(|line| format!("{line}\n{line}\n")).skip(1).collect();
    let names = imu.lines().next().unwrap_or_default();
    fs::write(warned.join("imu.csv"), format!("{names}\n{repeated}")).expect("samples");
    let [estimated, copied] = ["estimate", "copy"].map(|name| out.join(name));
    for arguments in [
        &["estimate", text(&warned), "--out", text(&estimated), "--no-report"][..],
        &["convert", text(&warned), "--out", text(&copied)],
    ] {
        let run = hovernav(arguments);
        assert!(run.status.success(), "{run:?}");
        let [out, err] =
            [run.stdout, run.stderr].map(|text| String::from_utf8(text).expect("text"));
        assert!(!out.is_empty() && !out.contains("warning: "), "{out}");
        // A warning that decides the verdict is a result.
        let (shown, start) = match out.contains("  - imu.csv: ") {
            true => (&out, "  - imu.csv: "),
            false => (&err, "warning: imu.csv: "),
        };
        assert!(shown.contains(start) && shown.contains("same time"), "{out}\n{err}");
        let quiet = hovernav(&[arguments, &["--quiet"]].concat());
        assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty(), "{quiet:?}");
    }
}

#[test]
fn several_logs_make_a_table_and_a_directory_each() {
    let out = place("several");
    let nowhere = out.join("nowhere");
    let arguments = ["estimate", "--no-report", "--out", text(&out), HELI, HELI];
    let said = succeeds(&arguments);
    assert_eq!(said.lines().count(), 3, "{said}");
    assert!(out.join("heli-hover/solution.csv").exists());
    assert!(out.join("heli-hover-2/summary.json").exists());
    // A failed log does not stop the others, but it changes the exit status.
    let run = hovernav(&[&arguments[..5], &[text(&nowhere)]].concat());
    assert_eq!(run.status.code(), Some(1));
    assert_eq!(String::from_utf8(run.stdout).expect("text").lines().count(), 2);
}

#[cfg(feature = "manual")]
#[test]
fn shells_and_man_know_every_verb() {
    let dir = place("man");
    succeeds(&["man", text(&dir)]);
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert!(succeeds(&["completions", shell]).contains("estimate"), "{shell}");
    }
    let page = std::fs::read_to_string(dir.join("hovernav-score.1")).expect("a page");
    assert!(page.contains("TUM"), "{page}");
    assert_eq!(hovernav(&["completions", "cmd"]).status.code(), Some(2));
}

#[cfg(feature = "export")]
#[test]
fn what_an_earlier_run_left_is_removed_and_what_is_anybodys_is_named() {
    let out = place("stale");
    let foreign = "a page of somebody's own";
    fs::write(out.join("report.html"), foreign).expect("writable");
    let estimate = ["estimate", HELI, "--out", text(&out)];
    let run = hovernav(&[&estimate[..], &["--no-report"]].concat());
    let told = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(told.contains("report.html was not written by this run"), "{told}");
    assert_eq!(fs::read_to_string(out.join("report.html")).expect("still there"), foreign);

    succeeds(&[&estimate[..], &["--export", "kml,mcap"]].concat());
    for name in ["report.html", "solution.kml", "solution.mcap", "solution.foxglove-layout.json"] {
        assert!(out.join(name).exists(), "{name}");
    }
    fs::write(out.join("notes.txt"), foreign).expect("writable");
    let run = hovernav(&[&estimate[..], &["--no-report", "--export", "tum"]].concat());
    let told = String::from_utf8_lossy(&run.stderr).into_owned();
    for name in ["report.html", "solution.kml", "solution.mcap", "solution.foxglove-layout.json"] {
        assert!(!out.join(name).exists() && told.contains(name), "{name}: {told}");
    }
    for name in ["solution.csv", "solution.tum", "summary.json", "notes.txt"] {
        assert!(out.join(name).exists(), "{name}");
    }
}
