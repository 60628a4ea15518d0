//! Why a flight behind lines cannot be.

use hovernav::{autopilot, servo};
use hovernav_fly::play::PlayError;
use hovernav_model::helicopter::HelicopterError;
use hovernav_sim::ConfigError;

/// Why a live flight cannot be flown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveFlightError {
    /// A sensor, servo or wind that cannot be.
    #[error(transparent)]
    Sensor(#[from] ConfigError),
    /// An airframe that cannot be.
    #[error(transparent)]
    Helicopter(#[from] HelicopterError),
    /// A pilot's skill that cannot fly.
    #[error(transparent)]
    Pilot(#[from] autopilot::ConfigError),
    /// A servo's setting that cannot be.
    #[error("[servo] {0}")]
    Servo(#[from] servo::ConfigError),
    /// A line that cannot be had.
    #[error(transparent)]
    Line(#[from] PlayError),
}
