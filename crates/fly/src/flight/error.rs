//! Reasons why a flight cannot begin.

use std::io;

use crate::servo::{GpioError, PwmError};
use hovernav::flight_control::FlightControlError;
use hovernav::servo;
use hovernav_dataset::LogError;
use hovernav_record::FlyConfigError;

/// Reasons why a flight cannot begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FlyError {
    /// An invalid setting.
    #[error(transparent)]
    Config(#[from] FlyConfigError),
    /// An invalid setting of a servo.
    #[error("[servo] {0}")]
    Servo(#[from] servo::ConfigError),
    /// An invalid setting of the autopilot.
    #[error("[autopilot] {0}")]
    Control(#[from] FlightControlError),
    /// The pilot's lines cannot be opened.
    #[error("[servo.capture] {0}")]
    Gpio(#[from] GpioError),
    /// A servo output cannot be opened.
    #[error("[servo.output] {0}")]
    Pwm(#[from] PwmError),
    /// The record cannot be created.
    #[error(transparent)]
    Record(#[from] LogError),
    /// A thread cannot be started.
    #[error("cannot start a thread: {0}")]
    Thread(#[from] io::Error),
}
