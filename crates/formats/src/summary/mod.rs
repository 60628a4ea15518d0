//! `summary.json` of a filter run: its input and its results.

#[cfg(feature = "record")]
mod reproduction;
mod run;

#[cfg(feature = "record")]
pub use reproduction::ReproductionSummary;
pub use run::{AlignmentSummary, OutageDrift, RunSummary};
