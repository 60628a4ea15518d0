#![doc = include_str!("../README.md")]

mod aid_sections;
mod aids;
mod allan;
mod apart;
mod auxiliary;
mod axes;
mod batch;
mod clock;
mod clock_steps;
pub mod columns;
mod comparisons;
pub mod consistency;
mod contents;
mod controls;
mod csv_writer;
mod dataset;
mod distribution;
mod error;
mod events;
mod finding;
mod findings;
mod fitness;
mod fix_gate;
mod gps;
mod imu;
mod inconsistent;
mod kept;
mod level;
mod lever_arm;
pub mod limits;
pub mod magnetic_field;
mod manifest;
mod number;
mod open;
mod ordered;
mod paragraph;
mod plausibility;
mod possible_motion;
mod rates;
mod records;
mod reference;
mod relative;
mod remarks;
mod replay;
mod sample_file;
mod samples;
mod sampling;
mod score;
mod series;
mod settings;
mod size;
mod smoothing;
mod solution;
pub mod statistics;
mod survey;
mod table;
mod trajectory;
mod truth;
pub mod utc;
mod verdict;
mod vibration_lines;
mod write;

pub use aid_sections::{RangefinderSection, SecondAntennaSection};
pub use allan::{AllanPoint, allan_deviation};
pub use apart::{Apart, set_harms};
pub use auxiliary::pressure_altitude_m;
pub use axes::{AccelUnit, Axes, GyroUnit, Reading};
pub use batch::Join;
pub use clock::Rows;
pub use clock_steps::ClockSteps;
pub use comparisons::{ChannelTally, FixTally};
pub use consistency::innovations;
pub use contents::{Contents, GapContents, GpsContents, ImuContents, SensorContents, Share};
pub use controls::ControlFile;
pub use dataset::{Dataset, Source};
pub use error::LogError;
pub use events::Events;
pub use finding::{Finding, FindingKind, Harm, Sensor, SetupFinding, Severity, sentences};
pub use fix_gate::{Dimensions, FixGate, HIGHEST_LATITUDE_DEG, StatedFix, is_unknown};
pub use imu::{field_fault, motion_fault, remark_faults};
pub use kept::{Keep, thin};
pub use level::Level;
pub use manifest::{
    GpsSection, HeadingReference, ImuSection, Manifest, Point, ReferenceSection, SolutionPoint,
    SolutionSection,
};
pub use paragraph::paragraph;
pub use plausibility::{alternative, denied_aid};
pub use reference::{Reference, ReferenceMoment};
pub use relative::{RelativeError, RelativePoint, relative_error};
pub use remarks::Remarks;
pub use replay::{Outage, Run, UnusedReadings};
pub use sample_file::SampleFile;
pub use samples::Samples;
pub use sampling::SampleRates;
pub use score::{
    Axis, AxisScore, ErrorPoint, Score, Statistics, axis_errors, axis_sigmas, outage_drift, score,
};
pub use settings::Declination;
pub use smoothing::SmoothedRun;
pub use solution::{
    COLUMNS as SOLUTION_COLUMNS, ExtraColumns, SolutionWriter, solution_row, write_solution,
};
pub use statistics::median_interval_s;
pub use survey::Survey;
pub use trajectory::{Alignment, LocalAxes, Trajectory};
pub use truth::Truth;
pub use verdict::Verdict;
pub use vibration_lines::VibrationLine;
// Readers and writers of whole files, for crates that depend on this one alone.
pub use hovernav_toml::{WholeFile, copy_whole, open_file, write_whole};
