//! Why a flight cannot be identified from.

use thiserror::Error;

use super::kind::Kind;
use crate::methods::prediction_error::PredictionErrorError;
use crate::record::ExperimentError;
use crate::record::preprocess::PreprocessError;

/// Why a flight cannot be identified from.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// No sticks were recorded.
    #[error("no controls recorded: there is nothing to identify from")]
    NoControls,
    /// The sticks were recorded at another time than the flight.
    #[error(
        "sticks recorded from {:.2} s to {:.2} s and motion from {:.2} s to {:.2} s, no moment in common: expected one clock",
        sticks_s[0], sticks_s[1], motion_s[0], motion_s[1]
    )]
    Apart {
        /// First and last row of the sticks, s.
        sticks_s: [f64; 2],
        /// First and last solution, s.
        motion_s: [f64; 2],
    },
    /// Too few solutions for a record.
    #[error("found {found} solutions, expected at least 100")]
    NoSolution {
        /// Solutions there are.
        found: usize,
    },
    /// Nothing of the flight is near a hover.
    #[error(
        "{kind}: no test point, and no {least_s} s of flight within 2.5 m/s of standing still, level to 25° and on one heading"
    )]
    NoHover {
        /// The model asked for.
        kind: Kind,
        /// The least of it that would do, s.
        least_s: f64,
    },
    /// A stick of the model never moves.
    #[error(
        "{kind}: no test point on {stick}: it never moves by {least}, nothing can be said of it"
    )]
    StillStick {
        /// The model asked for.
        kind: Kind,
        /// The stick.
        stick: String,
        /// The least that would do, of full travel on one side.
        least: f64,
    },
    /// The record itself.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// The record is too short to be filtered.
    #[error(transparent)]
    Preprocess(PreprocessError),
    /// The search.
    #[error(transparent)]
    PredictionError(#[from] PredictionErrorError),
}
