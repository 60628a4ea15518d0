//! Reasons why a live flight cannot be flown.

use hovernav::{autopilot, servo};
use hovernav_fly::play::PlayError;
use hovernav_sim::{ConfigError, FlightError};

/// Reasons why a live flight cannot be flown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveFlightError {
    /// Invalid settings of a sensor, servo or the wind.
    #[error(transparent)]
    Sensor(#[from] ConfigError),
    /// An invalid vehicle.
    #[error(transparent)]
    Vehicle(#[from] FlightError),
    /// Invalid settings of the pilot's skill.
    #[error(transparent)]
    Pilot(#[from] autopilot::ConfigError),
    /// Invalid settings of the servos.
    #[error("[servo] {0}")]
    Servo(#[from] servo::ConfigError),
    /// A line that cannot be created.
    #[error(transparent)]
    Line(#[from] PlayError),
}
