//! Validity checks of configurations.

use hovernav::frames::Vector;

/// Highest sensor rate and vibration frequency that can be simulated, Hz.
const FASTEST_HZ: f64 = 20_000.0;

/// An invalid value in a sensor configuration.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{sensor}: {what} is {found}, expected {expected}")]
pub struct ConfigError {
    /// The sensor.
    pub sensor: &'static str,
    /// The value, in the unit of its field or in SI units.
    pub what: &'static str,
    /// Value found.
    pub found: f64,
    /// Values expected.
    pub expected: &'static str,
}

pub(super) type Checked = Result<(), ConfigError>;

fn check(
    holds: bool,
    sensor: &'static str,
    what: &'static str,
    found: f64,
    expected: &'static str,
) -> Checked {
    if holds { Ok(()) } else { Err(ConfigError { sensor, what, found, expected }) }
}

pub(super) fn frequency(sensor: &'static str, what: &'static str, hz: f64) -> Checked {
    let possible = hz > 0.0 && hz <= FASTEST_HZ;
    check(possible, sensor, what, hz, "above 0 and at most 20000 Hz")
}

/// Checks a time constant, range or bandwidth, which is infinite if the sensor has no such limit.
pub(super) fn positive(sensor: &'static str, what: &'static str, value: f64) -> Checked {
    check(value > 0.0, sensor, what, value, "above 0")
}

/// Checks a standard deviation, or a size that may be zero.
pub(super) fn size(sensor: &'static str, what: &'static str, value: f64) -> Checked {
    check(value >= 0.0 && value.is_finite(), sensor, what, value, "0 or above")
}

pub(super) fn finite(sensor: &'static str, what: &'static str, value: f64) -> Checked {
    check(value.is_finite(), sensor, what, value, "a finite value")
}

pub(super) fn finite_vector<F>(
    sensor: &'static str,
    what: &'static str,
    vector: Vector<F>,
) -> Checked {
    vector.to_array().into_iter().try_for_each(|value| finite(sensor, what, value))
}
