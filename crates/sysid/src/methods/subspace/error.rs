//! Why no model came out.

use thiserror::Error;

/// Why no model came out.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SubspaceError {
    /// The record is too short for the horizon.
    #[error(
        "experiment `{experiment}`: {samples} samples are too few for a horizon of {horizon}; \
         {needed} are needed"
    )]
    TooShort {
        /// The experiment's name.
        experiment: String,
        /// Samples there are.
        samples: usize,
        /// The horizon asked for.
        horizon: usize,
        /// The fewest samples that horizon works with.
        needed: usize,
    },
    /// The order does not fit the horizon.
    #[error(
        "order {order} does not fit a horizon of {horizon}: between 1 and {largest} can be found"
    )]
    Order {
        /// States asked for.
        order: usize,
        /// The horizon.
        horizon: usize,
        /// Most states the horizon can show.
        largest: usize,
    },
    /// An input moves too little, or only as other inputs do.
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
    /// The arithmetic broke down.
    #[error("experiment `{experiment}`: {step} has no finite result")]
    Breakdown {
        /// The experiment's name.
        experiment: String,
        /// Which step.
        step: &'static str,
    },
}
