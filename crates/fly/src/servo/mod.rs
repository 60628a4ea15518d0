//! Pulses through the operating system: packets of a microcontroller, GPIO lines with edges timed by the kernel,
//! and the kernel's PWM outputs.

#[cfg(target_os = "linux")]
mod gpio;
#[cfg(target_os = "linux")]
mod pwm;
mod recording;
mod stream;
mod stream_output;

#[cfg(target_os = "linux")]
pub use gpio::{GpioCapture, GpioError};
#[cfg(target_os = "linux")]
pub use pwm::{PwmAction, PwmError, PwmOutput};
pub use recording::RecordingOutput;
pub use stream::StreamCapture;
pub use stream_output::StreamOutput;
