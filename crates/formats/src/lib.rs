#![doc = include_str!("../README.md")]
#![cfg_attr(
    not(all(feature = "ulog", feature = "dataflash", feature = "tlog")),
    allow(
        dead_code,
        unused_variables,
        reason = "shared code has parts that only some readers use"
    )
)]

mod assembly;
#[cfg(any(feature = "ros2", feature = "text"))]
mod axes;
mod bag;
mod choice;
mod comparison;
#[cfg(any(feature = "dataflash", feature = "ros2", feature = "ulog"))]
mod damages;
#[cfg(feature = "dataflash")]
mod dataflash;
mod difference;
mod directory;
mod estimation;
mod format;
#[cfg(feature = "text")]
mod init;
mod inputs;
mod integrals;
mod latency;
mod log;
mod onboard;
mod open;
#[cfg(any(feature = "dataflash", feature = "tlog", feature = "ulog"))]
mod primitive;
#[cfg(feature = "raw")]
mod raw;
#[cfg(any(feature = "dataflash", feature = "ulog"))]
mod receivers;
mod recognise;
#[cfg(feature = "ros2")]
mod ros2;
mod scoring;
mod size;
mod summary;
#[cfg(feature = "text")]
mod text;
#[cfg(feature = "tlog")]
mod tlog;
#[cfg(feature = "ulog")]
mod ulog;
#[cfg(feature = "ros2")]
mod unpacking;
mod utc;
mod window;

pub use comparison::{Comparison, Difference, NamedTrajectory};
pub use difference::OnboardDifference;
pub use estimation::{Changes, Estimated, Judged, Pass};
pub use format::Format;
#[cfg(feature = "text")]
pub use init::Proposal;
pub use log::{Log, Options};
pub use onboard::{InnovationSize, InnovationSizes, Onboard, OnboardInnovation, OnboardMoment};
pub use open::{open, open_bytes};
pub use scoring::{Scored, Scoring, open_trajectory};
pub use size::bytes_of;
#[cfg(feature = "record")]
pub use summary::ReproductionSummary;
pub use summary::{AlignmentSummary, OutageDrift, RunSummary};
#[cfg(feature = "text")]
pub use text::trajectory;
