//! What every configuration of the autopilot is checked with.

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
        write!(f, "autopilot: {}: found {}, expected {}", self.what, self.found, self.expected)
    }
}

impl core::error::Error for ConfigError {}

/// Refuses a value that is NaN or infinite.
pub(super) fn finite(what: &'static str, found: f64) -> Result<(), ConfigError> {
    if found.is_finite() {
        Ok(())
    } else {
        Err(ConfigError { what, found, expected: "a finite number" })
    }
}

/// Refuses a value outside `lowest` to `highest`, and NaN.
pub(super) fn within(
    what: &'static str,
    found: f64,
    lowest: f64,
    highest: f64,
    expected: &'static str,
) -> Result<(), ConfigError> {
    if found >= lowest && found <= highest {
        Ok(())
    } else {
        Err(ConfigError { what, found, expected })
    }
}
