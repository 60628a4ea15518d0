//! Commands that read a flight record.
#![cfg(all(feature = "fly", feature = "lab"))]

#[path = "../../../tests/record/flight.rs"]
mod flight;

use std::fs;
use std::path::PathBuf;

use crate::common::{place, refusal, succeeds, summary, text};
use hovernav_record::{Entry, Recorder};

/// A directory of this test, with the record of a flight in it.
fn recorded(name: &str) -> (PathBuf, PathBuf) {
    let place = place(&format!("record-{name}"));
    let path = place.join("flight.mcap");
    let header = flight::header();
    let mut recorder = Recorder::create(&path, &header).expect("a record");
    flight::fly(&header, &mut recorder, 30.0);
    recorder.push(flight::START + 30.0, Entry::Controls([0.5, 0.0, -0.25, 0.0]));
    let status = recorder.finish();
    assert_eq!((status.lost_raw, status.lost_decoded), (0, 0));
    (place, path)
}

#[test]
fn an_estimate_of_a_record_says_that_it_is_what_flew() {
    let (place, path) = recorded("estimate");
    let out = place.join("out");
    let words = succeeds(&["estimate", text(&path), "--out", text(&out), "--no-report"]);
    let flown = &summary(&out)["flown"];
    assert_eq!(flown["identical"], true, "{flown}");
    let samples = flown["compared"].as_u64().expect("a number");
    assert!(samples > 700, "{samples}");
    let sentence = format!("flown solution reproduced bit for bit ({samples} samples)");
    assert!(words.contains(&sentence), "{words}");
    // With other settings, no reproduction is expected.
    let thinned =
        ["estimate", text(&path), "--out", text(&out), "--no-report", "--gps-rate", "0.5"];
    succeeds(&thinned);
    assert!(summary(&out)["flown"].is_null());
}

/// Without sufficient memory, nothing is read, and the error contains both numbers.
#[cfg(target_os = "linux")]
#[test]
fn a_record_that_memory_will_not_hold_is_not_reported_on() {
    let (place, path) = recorded("large");
    let record = fs::OpenOptions::new().write(true).open(&path).expect("the record");
    record.set_len(1 << 30).expect("room for nothing");
    let out = place.join("out");
    let command = "ulimit -v 200000; exec \"$0\" report \"$1\" --out \"$2\"";
    let program = env!("CARGO_BIN_EXE_hovernav");
    let run = std::process::Command::new("sh")
        .args(["-c", command, program, text(&path), text(&out)])
        .output()
        .expect("a shell");
    let message = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(1), "{message}");
    let told = "reading takes about 2.15 GB of memory, found 0.";
    assert!(message.contains(told) && !out.exists(), "{message}");
}

#[test]
fn info_reports_sensors_losses_and_events() {
    let (_, path) = recorded("info");
    let words = succeeds(&["info", text(&path)]);
    assert!(words.lines().all(|line| line.chars().count() <= 80), "{words}");
    for part in [
        "\n  imu ",
        "\n  gps ",
        "\nrecord\n",
        "ended\n",
        "2026-09-21 14:13:20 UTC",
        "no room   for 0 raw and 0 decoded entries",
        "\n  dmu_lost ",
        "\n  aligned ",
    ] {
        assert!(words.contains(part), "{part} in {words}");
    }
}

#[test]
fn a_converted_record_is_a_dataset_like_any_other() {
    let (place, path) = recorded("convert");
    let (dataset, out) = (place.join("dataset"), place.join("out"));
    succeeds(&["convert", text(&path), "--out", text(&dataset)]);
    for file in ["dataset.toml", "imu.csv", "gps.csv", "controls.csv"] {
        assert!(dataset.join(file).exists(), "{file}");
    }
    succeeds(&["estimate", text(&dataset), "--out", text(&out), "--no-report"]);
    let (of_dataset, of_record) = (summary(&out), {
        succeeds(&["estimate", text(&path), "--out", text(&out), "--no-report"]);
        summary(&out)
    });
    // The tables are ordered by time and the record by the loop, so the alignments may differ by one sample.
    for key in ["imu_samples", "gps_fixes_used"] {
        assert_eq!(of_dataset[key], of_record[key], "{key}");
    }
    let error = refusal(&["convert", text(&dataset), "--out", text(&dataset)]);
    assert!(error.contains("the log itself, expected another directory"), "{error}");
}

#[test]
fn a_file_that_is_no_record_is_refused_with_its_name_and_the_byte() {
    let (place, path) = recorded("refused");
    let cut = place.join("cut.mcap");
    fs::write(&cut, &fs::read(&path).expect("readable")[..100]).expect("writable");
    let error = refusal(&["info", text(&cut)]);
    assert!(error.starts_with("hovernav: ") && error.contains("cut.mcap: at byte "), "{error}");
}
