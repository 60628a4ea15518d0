//! What every configuration of the autopilot is checked with.

use crate::scalar::{Readable, Scalar};

/// A value no autopilot can fly with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConfigError {
    /// Which value: its key in `autopilot.toml`.
    pub what: &'static str,
    /// What was found.
    pub found: f64,
    /// What would have been right.
    pub expected: &'static str,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { what, found, expected } = self;
        write!(f, "autopilot: {what}: found {}, expected {expected}", Readable(*found))
    }
}

impl core::error::Error for ConfigError {}

/// Refuses a value that is NaN or infinite.
pub(super) fn finite<T: Scalar>(what: &'static str, found: T) -> Result<(), ConfigError> {
    if found.is_finite() {
        Ok(())
    } else {
        Err(ConfigError { what, found: found.wide(), expected: "a finite number" })
    }
}

/// Refuses a value outside `lowest` to `highest`, both as near as its type has them, and NaN.
pub(super) fn within<T: Scalar>(
    what: &'static str,
    found: T,
    lowest: f64,
    highest: f64,
    expected: &'static str,
) -> Result<(), ConfigError> {
    if found >= T::of(lowest) && found <= T::of(highest) {
        Ok(())
    } else {
        Err(ConfigError { what, found: found.wide(), expected })
    }
}
