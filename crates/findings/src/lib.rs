#![doc = include_str!("../README.md")]

mod contents;
mod events;
mod finding;
mod fitness;
pub mod limits;
mod paragraph;
mod plausibility;
mod rates;
mod sampling;
mod survey;
mod vibration_lines;

pub use contents::{Contents, GapContents, GpsContents, ImuContents, SensorContents, Share};
pub use events::findings;
pub use events::spans::{Span, spans};
pub use finding::{Finding, FindingKind, Harm, Sensor, SetupFinding, Severity, sentences};
pub use fitness::{check_fitness, ignore, ignore_inconsistent};
pub use paragraph::paragraph;
pub use plausibility::{alternative, barometer_scale, check_setup, ensure_possible};
pub use sampling::SampleRates;
pub use survey::Survey;
pub use vibration_lines::VibrationLine;
