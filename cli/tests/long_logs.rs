//! What is written of a log, how often, and what it takes.

mod common;

use std::fs;
use std::path::Path;

use common::{HELI, hovernav, place, succeeds, text};

fn rows(out: &Path) -> Vec<String> {
    let csv = fs::read_to_string(out.join("solution.csv")).unwrap();
    csv.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn a_rate_leaves_rows_out_and_changes_none() {
    let (all, some) = (place("rate-all"), place("rate-some"));
    succeeds(&["-q", "estimate", HELI, "--no-report", "--out", text(&all)]);
    let rate = ["--rate", "1", "--export", "tum"];
    let out = ["--no-report", "--out", text(&some)];
    succeeds(&[&["-q", "estimate", HELI][..], &rate, &out].concat());
    let (all, few) = (rows(&all), rows(&some));
    assert_eq!(few.len(), 298);
    assert!(few.iter().all(|row| all.contains(row)) && few[0] == all[0]);
    let tum = fs::read_to_string(some.join("solution.tum")).unwrap();
    assert_eq!(tum.lines().filter(|line| !line.starts_with('#')).count(), few.len());
    let refused = hovernav(&["estimate", HELI, "--rate", "0"]);
    assert_eq!(refused.status.code(), Some(2));
}

/// Without memory for it nothing is begun, and both numbers are told.
#[cfg(target_os = "linux")]
#[test]
fn smoothing_is_refused_before_it_runs_out_of_memory() {
    let out = place("no-memory");
    let command = "ulimit -v 80000; exec \"$0\" -q estimate --smooth \"$1\" --out \"$2\"";
    let program = env!("CARGO_BIN_EXE_hovernav");
    let run = std::process::Command::new("sh")
        .args(["-c", command, program, HELI, text(&out)])
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&run.stderr).into_owned();
    assert_eq!(run.status.code(), Some(1), "{message}");
    let told = "smoothing 9899 samples takes 0.09 GB of memory beside the log, found 0.0";
    assert!(message.contains(told), "{message}");
    assert!(!out.join("solution.csv").exists());
}
