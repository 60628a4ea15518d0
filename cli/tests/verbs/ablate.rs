//! `hovernav ablate`, as a user runs it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const LOG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../datasets/heli-hover");

fn ablate(arguments: &[&str], out: &Path) -> Output {
    let command = &mut Command::new(env!("CARGO_BIN_EXE_hovernav"));
    command.arg("ablate").args(arguments).arg("--out").arg(out).output().unwrap()
}

/// An ablation that was interrupted within a line of a run continues. Its results equal, byte for byte, those of an
/// uninterrupted ablation.
#[test]
fn an_interrupted_ablation_continues_to_the_same_results() {
    let out = tempfile::tempdir().unwrap();
    let run = |faults: &[&str], out: &Path| {
        let cuts = ["--cut", "slow_fix_errors", "--cut", "rest"];
        let arguments: Vec<&str> = [&[LOG], faults, &cuts].concat();
        let done = ablate(&arguments, out);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8(done.stdout).unwrap()
    };
    let faults = ["--fault", "outage=10@100"];
    let (whole, again) = (out.path().join("whole"), out.path().join("again"));
    let table = run(&faults, &whole);
    assert!(table.lines().any(|line| line.starts_with("| slow_fix_errors | 1 / 0 |")), "{table}");
    assert_eq!(table.lines().count(), 4, "{table}");
    let read = |out: &Path| fs::read_to_string(out.join("results.csv")).unwrap();
    let results = read(&whole);
    assert_eq!(results.lines().count(), 6);
    fs::create_dir(&again).unwrap();
    fs::write(again.join("results.csv"), &results[..results.len() - 40]).unwrap();
    assert_eq!(run(&faults, &again), table);
    assert_eq!(read(&again), results);
    assert_eq!(run(&["--fault", "none"], &whole), table);
}

#[test]
fn unknown_names_are_refused_before_anything_is_written() {
    let out = tempfile::tempdir().unwrap();
    let dir = out.path().join("none");
    for (arguments, words) in
        [(["--cut", "wind"], "found no mechanism `wind`"), (["--fault", "hail=3"], "hail")]
    {
        let refused = ablate(&[&[LOG], &arguments[..]].concat(), &dir);
        let told = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(!refused.status.success() && told.contains(words), "{told}");
        assert!(!dir.exists());
    }
    let listed = String::from_utf8(ablate(&["--cut", "list"], &dir).stdout).unwrap();
    assert!(listed.lines().any(|line| line == "heading_monitor"), "{listed}");
}
