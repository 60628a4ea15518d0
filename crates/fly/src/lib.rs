#![doc = include_str!("../README.md")]

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
