//! Common functions of the tests of the command.
#![allow(dead_code, reason = "without some features no test uses all of it")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use serde_json::Value;

/// The helicopter flight in the repository.
pub const HELI: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../datasets/heli-hover");

/// Runs the command.
pub fn hovernav(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hovernav")).args(arguments).output().expect("the command runs")
}

/// Standard output of the command, which must succeed.
#[track_caller]
pub fn succeeds(arguments: &[&str]) -> String {
    let run = hovernav(arguments);
    assert!(run.status.success(), "{run:?}");
    String::from_utf8(run.stdout).expect("text")
}

/// The one line on standard error of a command that fails with exit status 1.
#[track_caller]
pub fn refusal(arguments: &[&str]) -> String {
    let run = hovernav(arguments);
    assert_eq!(run.status.code(), Some(1), "{run:?}");
    let message = String::from_utf8(run.stderr).expect("text");
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}

/// Asserts that the command refuses `arguments` with a message that contains `expected`.
#[track_caller]
pub fn assert_refused(arguments: &[&str], expected: &str) {
    let message = refusal(arguments);
    assert!(message.contains(expected), "{message}");
}

/// An empty directory with this name, for one test only.
pub fn place(name: &str) -> PathBuf {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&place);
    fs::create_dir_all(&place).expect("a directory can be made");
    place
}

/// The directory with the autopilot that `design` computes for the 60-class helicopter. The search runs once per test
/// program, because it is slow.
pub fn designed() -> &'static Path {
    static DESIGNED: LazyLock<PathBuf> = LazyLock::new(|| {
        let out = place(concat!("designed-", env!("CARGO_CRATE_NAME")));
        succeeds(&["design", "raptor60", "--out", text(&out), "--no-report"]);
        out
    });
    &DESIGNED
}

/// Configuration `examples/loop.toml` with every path in `directory`. The directory then contains a designed autopilot,
/// and the records are in its folder `records`.
pub fn example(directory: &Path, records: &str) -> String {
    let at = |name: &str| directory.join(name).display().to_string();
    fs::create_dir(directory.join("design")).unwrap();
    fs::copy(designed().join("autopilot.toml"), at("design/autopilot.toml")).unwrap();
    include_str!("../../../examples/loop.toml")
        .replace("/tmp/hovernav-", &at("line-"))
        .replace("../out/raptor60/autopilot.toml", "design/autopilot.toml")
        .replace("\"out/records\"", &format!("\"{}\"", at(records)))
}

/// The output of a program as text.
pub fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

pub fn text(path: &Path) -> &str {
    path.to_str().expect("the path is text")
}

/// The `summary.json` in `out`.
pub fn summary(out: &Path) -> Value {
    let text = fs::read_to_string(out.join("summary.json")).expect("a summary");
    serde_json::from_str(&text).expect("valid JSON")
}

/// Asserts that a summary has the keys that every summary has, and the keys in `more`.
#[track_caller]
pub fn assert_keys(summary: &Value, more: &[&str]) {
    const ALWAYS: [&str; 8] = [
        "tool",
        "version",
        "input",
        "duration_s",
        "wall_s",
        "imu_samples",
        "gps_fixes_used",
        "gps_fixes_rejected",
    ];
    for key in ALWAYS.iter().chain(more) {
        assert!(!summary[key].is_null(), "{key}");
    }
}

/// A copy of the dataset files for which `change` returns a new text.
pub fn changed(
    dataset: &str,
    name: &str,
    files: &[&str],
    change: impl Fn(&str, String) -> Option<String>,
) -> PathBuf {
    let dir = place(name);
    for part in files {
        let content = fs::read_to_string(Path::new(dataset).join(part)).expect("readable");
        if let Some(content) = change(part, content) {
            fs::write(dir.join(part), content).expect("writable");
        }
    }
    dir
}
