//! Pulses through an operating system: a microcontroller's packets from any reader, GPIO lines whose
//! edges the kernel dates, and the kernel's PWM outputs.

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
