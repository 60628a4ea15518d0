#![doc = include_str!("../README.md")]

mod comparisons;
mod inconsistent;
mod kept;
mod run;
mod smoothing;

pub use comparisons::{ChannelTally, FixTally};
pub use inconsistent::InconsistentSpan;
pub use kept::{Keep, thin};
pub use run::{Run, UnusedReadings, estimate, estimate_each};
pub use smoothing::{SmoothedRun, smooth, smooth_keeping, smoothing_bytes};
