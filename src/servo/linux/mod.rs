//! Pulses through Linux: GPIO lines whose edges the kernel dates, and the kernel's PWM outputs.

mod gpio;
mod pwm;

pub use gpio::{GpioCapture, GpioError};
pub use pwm::{PwmAction, PwmError, PwmOutput};
