//! What keeps a flight from beginning.

use std::io;

use crate::servo::{GpioError, PwmError};
use hovernav::flight_control::FlightControlError;
use hovernav::servo;
use hovernav_log::{FlyConfigError, LogError};

/// What keeps a flight from beginning.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FlyError {
    /// A setting cannot be.
    #[error(transparent)]
    Config(#[from] FlyConfigError),
    /// A servo's setting cannot be.
    #[error("[servo] {0}")]
    Servo(#[from] servo::ConfigError),
    /// A setting of the autopilot cannot be.
    #[error("[autopilot] {0}")]
    Control(#[from] FlightControlError),
    /// The pilot's lines cannot be had.
    #[error("[servo.capture] {0}")]
    Gpio(#[from] GpioError),
    /// A servo's output cannot be had.
    #[error("[servo.output] {0}")]
    Pwm(#[from] PwmError),
    /// The record cannot be begun.
    #[error(transparent)]
    Record(#[from] LogError),
    /// The system gives no thread.
    #[error("no thread: {0}")]
    Thread(#[from] io::Error),
}
