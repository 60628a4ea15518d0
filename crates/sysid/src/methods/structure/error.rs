//! Why equations are refused.

use thiserror::Error;

/// Why a text is not a [`Structure`](super::Structure).
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum StructureError {
    /// A line is neither an equation nor a list of names.
    #[error("{structure}, line {line}: found `{found}`, expected {expected}")]
    Line {
        /// The structure's name.
        structure: String,
        /// The line, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What should.
        expected: &'static str,
    },
    /// A parameter's start lies outside its own bounds, or is not finite.
    #[error("{structure}: parameter `{parameter}` does not start inside its bounds")]
    Bounds {
        /// The structure's name.
        structure: String,
        /// The parameter.
        parameter: String,
    },
    /// A parameter no equation uses.
    #[error("{structure}: no equation uses the parameter `{parameter}`")]
    Unused {
        /// The structure's name.
        structure: String,
        /// The parameter.
        parameter: String,
    },
    /// Nothing to identify.
    #[error("{structure}: it needs a state and an output")]
    Empty {
        /// The structure's name.
        structure: String,
    },
}
