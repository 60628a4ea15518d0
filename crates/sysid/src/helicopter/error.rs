//! Reasons why a flight cannot be identified.

use thiserror::Error;

use super::flight_condition::FlightCondition;
use crate::methods::prediction_error::PredictionErrorError;
use crate::record::ExperimentError;
use crate::record::preprocess::PreprocessError;

/// Reasons why a flight cannot be identified.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// No sticks were recorded.
    #[error("no controls recorded: identification needs the stick positions")]
    NoControls,
    /// Sticks and motion do not overlap in time.
    #[error(
        "sticks and motion do not overlap in time: sticks span {:.2}–{:.2} s, motion {:.2}–{:.2} s. Do they use the same clock?",
        sticks_s[0], sticks_s[1], motion_s[0], motion_s[1]
    )]
    Apart {
        /// Times of the first and last row of the sticks, s.
        sticks_s: [f64; 2],
        /// Times of the first and last solution, s.
        motion_s: [f64; 2],
    },
    /// Too few solutions for a record.
    #[error("found {found} solutions, expected at least 100")]
    NoSolution {
        /// Number of solutions.
        found: usize,
    },
    /// The model has velocities or angles, and the log has no GPS.
    #[error(
        "{model}: found no usable fix, expected at least one. Without GPS only models of rates can be identified: rates, roll, pitch, yaw"
    )]
    NoFix {
        /// The requested model.
        model: String,
    },
    /// No part of the flight is in the condition of the model.
    #[error(
        "{model}: no test point, and no {min_s} s near {condition} (at most {} m/s away, tilt below 25°, constant heading)",
        condition.within_mps
    )]
    NotFlown {
        /// The condition.
        condition: FlightCondition,
        /// The requested model.
        model: String,
        /// Shortest usable part, s.
        min_s: f64,
    },
    /// A stick of the model never moves.
    #[error(
        "{model}: no test point on {stick}: the stick never moves, or by less than a twentieth of the most moved one, so its derivatives cannot be identified"
    )]
    StillStick {
        /// The requested model.
        model: String,
        /// The stick.
        stick: String,
    },
    /// The record is invalid.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// The record is too short to filter.
    #[error(transparent)]
    Preprocess(PreprocessError),
    /// The parameter search failed.
    #[error(transparent)]
    PredictionError(#[from] PredictionErrorError),
}
