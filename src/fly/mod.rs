//! Flying for real: the configuration of a flight computer and the loop that runs on it. Needs `std`;
//! the loop needs the feature `fly`.

#[cfg(feature = "fly")]
mod cabin;
mod config;
#[cfg(feature = "fly")]
mod downlink;
#[cfg(feature = "fly")]
mod flight;
#[cfg(feature = "fly")]
mod report;
mod sections;
#[cfg(feature = "fly")]
mod servos;
mod timing;

pub use config::{FlyConfig, FlyConfigError};
#[cfg(feature = "fly")]
pub use {
    downlink::DownlinkCounts,
    flight::{FlyError, Told, fly},
    report::FlightReport,
};
pub use sections::{
    AccelerationSign, CaptureSection, DmuMode, DmuSection, LineSection, MavlinkSection,
    ReceiverProtocol, ReceiverSection, RecordSection, ServoSection, SiteSection,
};
pub use timing::Durations;
