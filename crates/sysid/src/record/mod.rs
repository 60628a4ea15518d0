//! The record of a flight: uniformly sampled inputs and outputs, and their preparation for identification.

mod experiment;
pub mod preprocess;
mod test_points;
mod tones;

pub use experiment::{Experiment, ExperimentError, Offsets};
pub use hovernav::autopilot::Maneuver;
pub use test_points::{STICKS, TestPoint, find_test_points, stepped, travels};
pub use tones::{Tone, find_tones, notch_delay_s, without_tones};
