//! The real-time side: serial ports that come back, servo pulses through Linux, MAVLink, the 33 Hz
//! loop of a flight computer, and emulated devices to try all of it on without hardware.

pub mod devices;
#[cfg(target_os = "linux")]
mod flight;
mod mavlink;
#[cfg(unix)]
pub mod play;
pub mod serial;
pub mod servo;

#[cfg(target_os = "linux")]
pub use flight::{DownlinkCounts, DurationHistogram, FlightReport, FlyError, Notification, fly};
pub use mavlink::Mavlink;
