//! Errors and range checks of the autopilot's configuration.

use crate::health::HealthLimits;
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

/// Rejects NaN and values outside `lowest` to `highest`; both bounds are rounded to the value's type.
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

impl<T: Scalar> HealthLimits<T> {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        const EXPECTED: &str = "above 0, at most 1000";
        within("health.tilt_sigma_rad", self.tilt_sigma_rad, 1e-6, 1e3, EXPECTED)?;
        within("health.heading_sigma_rad", self.heading_sigma_rad, 1e-6, 1e3, EXPECTED)?;
        within("health.velocity_sigma_mps", self.velocity_sigma_mps, 1e-6, 1e3, EXPECTED)?;
        let vertical = self.vertical_velocity_sigma_mps;
        within("health.vertical_velocity_sigma_mps", vertical, 1e-6, 1e3, EXPECTED)?;
        within("health.position_sigma_m", self.position_sigma_m, 1e-6, 1e3, EXPECTED)?;
        within("health.age_s", self.age_s, 1e-3, 1e3, EXPECTED)?;
        within("health.dead_reckoning_s", self.dead_reckoning_s, 0.1, 1e3, "0.1 to 1000")?;
        within("health.disagreement_s", self.disagreement_s, 0.1, 1e3, "0.1 to 1000")?;
        within("health.recovery_s", self.recovery_s, 0.0, 1e3, "0 to 1000")
    }
}
