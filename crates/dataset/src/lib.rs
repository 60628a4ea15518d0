#![doc = include_str!("../README.md")]

mod clock;
pub mod columns;
mod dataset;
mod error;
pub mod magnetic_field;
mod manifest;
mod reference;
mod sensors;
mod solution;
pub mod statistics;
mod table;
mod trajectory;
pub mod utc;

pub use clock::batch::Join;
pub use clock::steps::{ClockSteps, is_clock_step};
pub use clock::{Gap, Rows, gaps};
pub use dataset::events::Events;
pub use dataset::outage::Outage;
pub use dataset::samples::Samples;
pub use dataset::settings::Declination;
pub use dataset::{Dataset, Source};
pub use error::{LogError, spelt_out};
pub use manifest::aid_sections::{RangefinderSection, SecondAntennaSection};
pub use manifest::axes::{AccelUnit, Axes, GyroUnit, Reading};
pub use manifest::{
    GpsSection, HeadingReference, ImuSection, LONGEST_LATENCY_S, Manifest, Point, ReferenceSection,
    SolutionPoint, SolutionSection,
};
pub use reference::align::Alignment;
pub use reference::truth::Truth;
pub use reference::{Reference, ReferenceMoment};
pub use sensors::auxiliary::pressure_altitude_m;
pub use sensors::controls::ControlFile;
pub use sensors::fix_gate::{
    Dimensions, FixGate, HIGHEST_LATITUDE_DEG, StatedFix, is_unknown, is_unknown_velocity,
};
pub use sensors::imu::{field_fault, motion_fault, remark_faults};
pub use sensors::sample_file::SampleFile;
pub use solution::{COLUMNS as SOLUTION_COLUMNS, ExtraColumns, SolutionWriter, solution_row};
pub use statistics::allan::{AllanPoint, allan_deviation};
pub use statistics::median_interval_s;
pub use table::remarks::Remarks;
pub use trajectory::{LocalAxes, Trajectory};
