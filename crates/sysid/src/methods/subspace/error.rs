//! Reasons for a failed subspace identification.

use thiserror::Error;

/// Reasons for a failed subspace identification.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SubspaceError {
    /// The record is too short for the horizon.
    #[error(
        "experiment `{experiment}`: found {samples} samples, expected at least {needed} for a horizon of \
         {horizon}"
    )]
    TooShort {
        /// The experiment's name.
        experiment: String,
        /// Number of samples.
        samples: usize,
        /// The requested horizon.
        horizon: usize,
        /// Smallest number of samples for that horizon.
        needed: usize,
    },
    /// The order does not fit the horizon.
    #[error("order {order} does not fit a horizon of {horizon}: expected 1 to {largest}")]
    Order {
        /// The requested number of states.
        order: usize,
        /// The horizon.
        horizon: usize,
        /// Largest number of states for the horizon.
        largest: usize,
    },
    /// An input moves too little, or only together with other inputs.
    #[error(
        "experiment `{experiment}`: input `{input}` does not excite: it is constant, too smooth, or \
         a combination of the other inputs"
    )]
    NotExciting {
        /// The experiment's name.
        experiment: String,
        /// The input.
        input: String,
    },
    /// An output never changes.
    #[error("experiment `{experiment}`: output `{output}` is constant")]
    ConstantOutput {
        /// The experiment's name.
        experiment: String,
        /// The output.
        output: String,
    },
    /// The computation failed numerically.
    #[error("experiment `{experiment}`: {step} has no finite result")]
    Breakdown {
        /// The experiment's name.
        experiment: String,
        /// Failed step.
        step: &'static str,
    },
}
