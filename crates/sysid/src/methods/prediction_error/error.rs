//! Reasons for a failed identification.

use thiserror::Error;

use crate::record::ExperimentError;

/// Reasons for a failed identification.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PredictionErrorError {
    /// A model is assembled from parts that lack one of its parameters or noises.
    #[error("{structure}: no part contains {name}")]
    NotInParts {
        /// The structure's name.
        structure: String,
        /// The parameter or noise.
        name: String,
    },
    /// An experiment lacks a signal the structure names.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// No experiments, or experiments of different sample periods.
    #[error("{structure}: found sample periods {periods_s:?} s, expected one period for all")]
    Periods {
        /// The structure's name.
        structure: String,
        /// The experiments' periods, s.
        periods_s: Vec<f64>,
    },
    /// Every parameter is fixed.
    #[error("{structure}: no parameter is free")]
    NothingFree {
        /// The structure's name.
        structure: String,
    },
    /// More unknowns than measured values.
    #[error("{structure}: found {unknowns} unknowns and only {numbers} measured values")]
    TooShort {
        /// The structure's name.
        structure: String,
        /// Parameters, noises, initial states, offsets and biases.
        unknowns: usize,
        /// Samples times outputs.
        numbers: usize,
    },
    /// The process noises need one initial value each, positive and finite.
    #[error("{structure}: found process noise {found:?}, expected {expected} positive numbers")]
    ProcessNoise {
        /// The structure's name.
        structure: String,
        /// Values given.
        found: Vec<f64>,
        /// Number of noises of the structure.
        expected: usize,
    },
    /// No stable predictor exists at the initial parameters: an unstable state is neither measured nor driven by noise.
    #[error("{structure}: no stable predictor at the start values")]
    Start {
        /// The structure's name.
        structure: String,
    },
    /// At the end of the search the information matrix of the parameters is singular.
    #[error("{structure}: the data cannot separate the parameters")]
    Singular {
        /// The structure's name.
        structure: String,
    },
}
