//! Flying for real: the configuration of a flight computer and the loop that runs on it. Needs `std`.

mod config;
mod timing;

pub use config::{
    AccelerationSign, DmuMode, DmuSection, FlyConfig, FlyConfigError, ReceiverProtocol,
    ReceiverSection, RecordSection, SiteSection,
};
pub use timing::Durations;
