//! Why nothing could be identified.

use thiserror::Error;

use crate::record::ExperimentError;

/// Why nothing could be identified.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PredictionErrorError {
    /// A model is put together from parts that lack one of its parameters or noises.
    #[error("{structure}: no part holds {name}")]
    NotInParts {
        /// The structure's name.
        structure: String,
        /// The parameter or noise.
        name: String,
    },
    /// An experiment lacks a signal the structure names.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// No experiments, or sampled at different periods.
    #[error("{structure}: found sample periods {periods_s:?} s, expected one period for all")]
    Periods {
        /// The structure's name.
        structure: String,
        /// The experiments' periods, s.
        periods_s: Vec<f64>,
    },
    /// Every parameter is held.
    #[error("{structure}: no parameter is free")]
    NothingFree {
        /// The structure's name.
        structure: String,
    },
    /// More unknowns than numbers measured.
    #[error("{structure}: {unknowns} unknowns against {numbers} measured numbers")]
    TooShort {
        /// The structure's name.
        structure: String,
        /// Parameters, noises, initial states, offsets and biases.
        unknowns: usize,
        /// Samples times outputs.
        numbers: usize,
    },
    /// One start per process noise is needed, positive and finite.
    #[error("{structure}: found process noise {found:?}, expected {expected} positive numbers")]
    ProcessNoise {
        /// The structure's name.
        structure: String,
        /// What was given.
        found: Vec<f64>,
        /// How many noises the structure has.
        expected: usize,
    },
    /// At its starts the structure has no stable predictor: something unstable is neither measured nor
    /// driven by noise.
    #[error("{structure}: no stable predictor at the start values")]
    Start {
        /// The structure's name.
        structure: String,
    },
    /// At the end of the search the parameters' information cannot be inverted.
    #[error("{structure}: the data cannot tell the parameters apart")]
    Singular {
        /// The structure's name.
        structure: String,
    },
}
