//! Errors and range checks of the autopilot's configuration.

use crate::scalar::{Readable, Scalar};

/// A configuration value that the autopilot cannot fly with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ConfigError {
    /// Key of the value in `autopilot.toml`.
    pub what: &'static str,
    /// The value found.
    pub found: f64,
    /// The expected range.
    pub expected: &'static str,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { what, found, expected } = self;
        write!(f, "autopilot: {what}: found {}, expected {expected}", Readable(*found))
    }
}

impl core::error::Error for ConfigError {}

/// Rejects a value that is NaN or infinite.
pub(super) fn finite<T: Scalar>(what: &'static str, found: T) -> Result<(), ConfigError> {
    if found.is_finite() {
        Ok(())
    } else {
        Err(ConfigError { what, found: found.wide(), expected: "a finite number" })
    }
}

/// Rejects NaN and values outside `lowest` to `highest`, with both bounds rounded to the value's type.
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
