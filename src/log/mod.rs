//! Logs: reading what others recorded, writing what we computed. Needs `std`.

mod auxiliary;
mod clock;
mod dataset;
mod error;
mod gps;
mod imu;
mod manifest;
mod number;
mod remarks;
mod replay;
mod settings;
mod table;

pub use auxiliary::pressure_altitude_m;
pub use clock::{Gap, gaps, median_interval_s};
pub use dataset::Dataset;
pub use error::LogError;
pub use manifest::{
    GpsSection, HeadingReference, ImuSection, Manifest, Point, ReferenceSection, SolutionSection,
};
pub use replay::{Outage, Run};
