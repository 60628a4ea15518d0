//! The real-time loop of a flight computer.

mod cabin;
mod downlink;
mod report;
mod run;
mod servos;
mod timing;

pub use downlink::DownlinkCounts;
pub use report::FlightReport;
pub use run::{FlyError, Told, fly};
pub use timing::Durations;
