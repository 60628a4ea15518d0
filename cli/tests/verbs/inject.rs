//! `hovernav inject`, as a user runs it.

use std::path::Path;
use std::process::{Command, Output};

use crate::common::{HELI, said};

fn inject(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hovernav")).arg("inject").args(arguments).output().unwrap()
}

#[test]
fn a_copy_has_its_fault_and_the_reference_untouched() {
    let out = tempfile::tempdir().unwrap();
    let dir = out.path().join("copy");
    let done = inject(&[HELI, "--fault", "gap=2@100", "--out", dir.to_str().unwrap()]);
    assert!(done.status.success(), "{}", said(&done.stderr));
    assert!(said(&done.stdout).contains("gap=2@100 from 100.000 s to 102.000 s"));
    let read = |dir: &Path, file| std::fs::read(dir.join(file)).unwrap();
    assert_eq!(read(&dir, "reference.csv"), read(Path::new(HELI), "reference.csv"));
    assert!(read(&dir, "imu.csv").len() < read(Path::new(HELI), "imu.csv").len());
}

#[test]
fn the_list_names_every_fault() {
    let listed = inject(&["--fault", "list"]);
    assert!(listed.status.success());
    let listed = said(&listed.stdout);
    for entry in hovernav_sim::faults::CATALOGUE {
        assert!(listed.lines().any(|line| line.starts_with(entry.name)), "{}", entry.name);
    }
}

#[test]
fn bad_usage_ends_with_two_and_a_word_of_what_was_expected() {
    for (arguments, words) in [
        (&[HELI, "--fault", "shake=4", "--out", "x"][..], "expected one of vibration"),
        (&[HELI, "--fault", "vibration=-1", "--out", "x"], "expected 0 to 20"),
        (&[HELI, "--fault", "gap"], "expected --out DIR"),
        (&["--fault", "gap", "--out", "x"], "expected a LOG"),
        (&[HELI, "--out", "x"], "--fault"),
        (&[HELI, "--fault", "gap", "--seeds", "3", "--out", "x"], "--campaign"),
    ] {
        let refused = inject(arguments);
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}");
        assert!(said(&refused.stderr).contains(words), "{}", said(&refused.stderr));
    }
}

#[test]
fn what_cannot_be_done_ends_with_one() {
    let refused = inject(&[HELI, "--fault", "gap", "--out", HELI]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(said(&refused.stderr).contains("the log itself"), "{}", said(&refused.stderr));
}

#[test]
fn a_campaign_writes_its_tables() {
    let out = tempfile::tempdir().unwrap();
    let dir = out.path().to_str().unwrap();
    let done = inject(&[HELI, "--campaign", "--fault", "gap", "--seeds", "2", "--out", dir]);
    assert!(done.status.success(), "{}", said(&done.stderr));
    let results = std::fs::read_to_string(out.path().join("results.csv")).unwrap();
    // A header, the flight without fault, and two seeds.
    assert_eq!(results.lines().count(), 4);
    let summary = std::fs::read_to_string(out.path().join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["tool"], "hovernav");
    assert!(out.path().join("table.md").exists() && out.path().join("runs.svg").exists());
}
