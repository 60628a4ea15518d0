//! Results of a command on a full disk: only complete files, and an error with the file and the cause.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::common::{HELI, place, succeeds, text};

/// Runs the command with a file size limit of `most` bytes, a multiple of 512. This simulates a disk that is full at
/// that length.
fn on_a_full_disk(most: u64, arguments: &[&str]) -> Output {
    assert_eq!(most % 512, 0);
    // SIGXFSZ would end the command. If it is ignored, writing fails as on a full disk.
    let script = format!("trap '' XFSZ; ulimit -f {}; exec \"$@\"", most / 512);
    let mut command = Command::new("sh");
    command.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_hovernav")]);
    command.args(arguments).output().expect("sh runs")
}

/// All files below `directory`.
fn files(directory: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.is_dir() { files.extend(self::files(&path)) } else { files.push(path) }
    }
    files
}

/// Runs the command with each of the limits in `most`. The command must fail with status 1 and name `file` and the
/// cause. All files in `out` must then be complete.
#[track_caller]
fn leaves_nothing_cut(out: &Path, arguments: &[&str], most: &[u64], file: &str) {
    for &most in most {
        let run = on_a_full_disk(most, arguments);
        let message = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(1), "{most}: {message}");
        assert!(message.contains("File too large"), "{most}: {message}");
        assert!(message.contains(text(out)), "{most}: {message}");
        if most > 0 {
            assert!(message.contains(file), "{most}: {message}");
        }
        for left in files(out) {
            let length = fs::metadata(&left).expect("it is there").len();
            assert!(length < most, "{} is cut at {length}", left.display());
            assert!(left.extension().is_none_or(|ending| ending != "part"), "{}", left.display());
        }
    }
}

#[test]
fn an_estimate_is_written_whole_or_not_at_all() {
    let out = place("full-estimate");
    let arguments = ["estimate", HELI, "--out", text(&out)];
    leaves_nothing_cut(&out, &arguments, &[0, 1 << 16], "solution.csv");
}

#[cfg(feature = "export")]
#[test]
fn an_export_is_written_whole_or_not_at_all() {
    let exports = ["kml", "gpx", "pos", "tum", "euroc", "mcap"];
    for format in exports {
        let out = place(&format!("full-export-{format}"));
        let arguments = ["estimate", HELI, "--no-report", "--export", format, "--out", text(&out)];
        leaves_nothing_cut(&out, &arguments, &[0, 1 << 14], "solution.");
    }
}

#[test]
fn a_page_that_does_not_fit_leaves_the_one_before_it() {
    let out = place("full-page");
    let arguments = ["estimate", HELI, "--out", text(&out)];
    let before = "the page of an earlier run";
    fs::write(out.join("report.html"), before).expect("writable");
    // The rows fit on the disk, but the page with its script does not.
    let run = on_a_full_disk(3 << 20, &arguments);
    let message = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(1), "{message}");
    let expected = format!("cannot write the report {}", out.join("report.html").display());
    assert!(message.contains(&expected) && message.contains("File too large"), "{message}");
    assert_eq!(fs::read_to_string(out.join("report.html")).expect("readable"), before);
    assert!(out.join("solution.csv").exists() && !out.join("report.html.part").exists());
}

#[test]
fn a_converted_log_is_written_whole_or_not_at_all() {
    let out = place("full-convert");
    let arguments = ["convert", HELI, "--out", text(&out)];
    leaves_nothing_cut(&out, &arguments, &[0, 1 << 13], ".csv");
}

#[test]
fn settings_are_written_whole_or_not_at_all() {
    for form in ["rust", "c", "postcard"] {
        let out = place(&format!("full-emit-{form}"));
        let arguments = ["estimate", HELI, "--no-report", "--emit", form, "--out", text(&out)];
        // The solution does not fit on the disk either: the error names that file.
        leaves_nothing_cut(&out, &arguments, &[0, 512], "");
    }
}

#[cfg(feature = "lab")]
#[test]
fn a_design_and_its_page_are_written_whole_or_not_at_all() {
    let out = place("full-design");
    // With given weights, no search is needed.
    let weights = place("full-design-weights").join("weights.toml");
    fs::write(&weights, "").expect("writable");
    let arguments = ["design", "raptor60", "--weights", text(&weights), "--out", text(&out)];
    // Only the page does not fit on the disk. A design is slow, so only one limit is tested.
    leaves_nothing_cut(&out, &arguments, &[1 << 16], "report.html");
}

#[cfg(feature = "lab")]
#[test]
fn a_simulated_flight_is_written_whole_or_not_at_all() {
    let out = place("full-simulate");
    let arguments = ["simulate", "--duration", "20", "--out", text(&out)];
    leaves_nothing_cut(&out, &arguments, &[0, 1 << 12, 1 << 16], "");
}

#[cfg(feature = "lab")]
#[test]
fn a_copy_with_faults_is_written_whole_or_not_at_all() {
    let out = place("full-inject");
    let arguments = ["inject", HELI, "--fault", "outage", "--out", text(&out)];
    leaves_nothing_cut(&out, &arguments, &[0, 1 << 12], "");
}

/// The disk is full at the start of a flight, as after a restart in the air: the flight continues, with a message.
#[cfg(feature = "fly")]
#[test]
fn a_flight_without_room_for_its_record_flies_on_unless_the_record_is_required() {
    let directory = place("full-fly");
    let fly = |more: &str| {
        let ports = format!(
            "[dmu]\nport = \"no-unit\"\n[receiver]\nport = \"no-receiver\"\nprotocol = \"ubx\"\n\
             [site]\nlatitude_deg = 1.3521\nlongitude_deg = 103.8198\nheight_m = 0.0\n{more}"
        );
        let (config, record) = (directory.join("fly.toml"), directory.join("flight.mcap"));
        fs::write(&config, ports).expect("writable");
        let arguments =
            ["fly", "--config", text(&config), "--record", text(&record), "--duration", "1"];
        let run = on_a_full_disk(0, &arguments);
        let left: Vec<_> = files(&directory).into_iter().filter(|file| *file != config).collect();
        assert!(left.is_empty(), "{left:?}");
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        (run.status.code(), said, String::from_utf8_lossy(&run.stdout).into_owned())
    };
    let (status, said, report) = fly("");
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("the flight is not recorded, and goes on"), "{said}");
    assert!(report.contains("no file: the flight was not recorded"), "{report}");
    let (status, said, _) = fly("[record]\nrequired = true\n");
    assert!(status == Some(1) && said.contains("File too large"), "{said}");
}

/// A limit above the size of all results changes nothing.
#[test]
fn a_disk_with_room_changes_nothing() {
    let (there, here) = (place("roomy-there"), place("roomy-here"));
    let arguments = |out| ["estimate", HELI, "--no-report", "--out", out];
    let run = on_a_full_disk(1 << 26, &arguments(text(&there)));
    assert!(run.status.success(), "{run:?}");
    succeeds(&arguments(text(&here)));
    let solution = |out: &Path| fs::read(out.join("solution.csv")).expect("readable");
    assert!(solution(&there) == solution(&here));
}
