//! Reasons for rejecting equations.

use thiserror::Error;

/// Reasons why a text is not a valid [`Structure`](super::Structure).
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
        /// Text found.
        found: String,
        /// Text expected.
        expected: &'static str,
    },
    /// A parameter's initial value lies outside its own limits, or is not finite.
    #[error("{structure}: the initial value of parameter `{parameter}` is outside its limits")]
    Bounds {
        /// The structure's name.
        structure: String,
        /// The parameter.
        parameter: String,
    },
    /// A parameter that no equation uses.
    #[error("{structure}: no equation uses the parameter `{parameter}`")]
    Unused {
        /// The structure's name.
        structure: String,
        /// The parameter.
        parameter: String,
    },
    /// No states or no outputs.
    #[error("{structure}: expected at least one state and one output")]
    Empty {
        /// The structure's name.
        structure: String,
    },
}
