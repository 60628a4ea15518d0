//! Shared code of the workspace's tests and of the tools that measure it.
//!
//! A test that needs data or a program which may be missing calls [`shared`], [`installed`], [`python`] or [`skip`].
//! With `HOVERNAV_STRICT=1` in the environment, as in CI, a skip is a failure.

mod python;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

pub use python::python;

/// Directory of the shared data, next to the checkout. It may be missing.
pub const SHARED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");

/// Names of the flights in `datasets` of the shared data.
pub const FLIGHTS: [&str; 7] = [
    "car-rtk",
    "quad-ardupilot-5hz",
    "quad-gps-glitch",
    "quad-gps-glitch-aided",
    "quad-hover-aided",
    "quad-p4rtk-vibration",
    "uav-thor75-1hz",
];

/// Path of a file or folder of the shared data.
///
/// `None`, after [`skip`], where it is missing.
///
/// # Panics
/// As [`skip`].
#[must_use]
#[track_caller]
pub fn shared(relative: impl AsRef<Path>) -> Option<PathBuf> {
    let path = Path::new(SHARED).join(relative);
    if !path.exists() {
        skip(format_args!("{} is missing", path.display()));
    }
    path.exists().then_some(path)
}

/// Whether `program` starts with `--version`; [`skip`] where it does not.
///
/// # Panics
/// As [`skip`].
#[must_use]
#[track_caller]
pub fn installed(program: &str) -> bool {
    let mut command = Command::new(program);
    let starts =
        command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !starts {
        skip(format_args!("{program} is not installed"));
    }
    starts
}

/// Size of a campaign: `all` with `HOVERNAV_LONG=1` in the environment, as in `.ci/more`, else its sample, `daily`.
#[must_use]
pub fn sample<T>(daily: T, all: T) -> T {
    let long = std::env::var_os("HOVERNAV_LONG").is_some_and(|value| value == "1");
    if long { all } else { daily }
}

/// Prints that a test or a part of it is skipped, with the reason.
///
/// # Panics
/// With `HOVERNAV_STRICT=1` in the environment.
#[track_caller]
pub fn skip(reason: impl Display) {
    let strict = std::env::var_os("HOVERNAV_STRICT").is_some_and(|value| value == "1");
    assert!(!strict, "skipped, but HOVERNAV_STRICT=1: {reason}");
    println!("skipped: {reason}");
}
