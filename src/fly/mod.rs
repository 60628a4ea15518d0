//! Flying for real: the configuration of a flight computer and the loop that runs on it. Needs `std`;
//! the loop needs the feature `fly`, and Linux.

#[cfg(all(feature = "fly", target_os = "linux"))]
mod cabin;
mod config;
#[cfg(all(feature = "fly", target_os = "linux"))]
mod downlink;
#[cfg(all(feature = "fly", target_os = "linux"))]
mod flight;
#[cfg(all(feature = "fly", target_os = "linux"))]
mod report;
mod sections;
#[cfg(all(feature = "fly", target_os = "linux"))]
mod servos;
mod timing;

pub use config::{FlyConfig, FlyConfigError};
pub use sections::{
    AccelerationSign, CaptureSection, DmuMode, DmuSection, LineSection, MavlinkSection,
    ReceiverProtocol, ReceiverSection, RecordSection, ServoSection, SiteSection,
};
pub use timing::Durations;
#[cfg(all(feature = "fly", target_os = "linux"))]
pub use {
    downlink::DownlinkCounts,
    flight::{FlyError, Told, fly},
    report::FlightReport,
};
