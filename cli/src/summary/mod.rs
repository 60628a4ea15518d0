//! `summary.json` of a filter run, for programs, for the page and for the terminal.

#[cfg(feature = "record")]
mod reproduction;
mod run;
mod words;

pub use run::{OutageDrift, RunSummary};
