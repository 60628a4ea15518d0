//! What the tests of the workspace share.
//!
//! A test that needs data or a program which may be missing calls [`shared`] or [`skip`]. With
//! `HOVERNAV_STRICT=1` in the environment, as in CI, a skip is a failure.

use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Path of a file or folder of the shared data, which lie next to the checkout.
///
/// `None`, after [`skip`], where it is missing.
///
/// # Panics
/// As [`skip`].
#[must_use]
#[track_caller]
pub fn shared(relative: impl AsRef<Path>) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(relative);
    if !path.exists() {
        skip(format_args!("{} is missing", path.display()));
    }
    path.exists().then_some(path)
}

/// Prints that a test, or a part of one, is skipped, and why.
///
/// # Panics
/// With `HOVERNAV_STRICT=1` in the environment.
#[track_caller]
pub fn skip(reason: impl Display) {
    let strict = std::env::var_os("HOVERNAV_STRICT").is_some_and(|value| value == "1");
    assert!(!strict, "skipped, but HOVERNAV_STRICT=1: {reason}");
    println!("skipped: {reason}");
}
