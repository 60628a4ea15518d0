#![doc = include_str!("../README.md")]

pub mod devices;
mod duration_histogram;
#[cfg(target_os = "linux")]
mod flight;
mod mavlink;
#[cfg(unix)]
pub mod play;
pub mod serial;
pub mod servo;

pub use duration_histogram::DurationHistogram;
#[cfg(target_os = "linux")]
pub use flight::{DownlinkCounts, FlightReport, FlyError, Notification, fly};
pub use mavlink::{FIRST_CUSTOM_MODE, Mavlink, frame as mavlink_frame};
