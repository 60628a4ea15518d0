//! Errors of designs.

use std::path::PathBuf;

use hovernav_model::ModelError;
use hovernav_toml::TomlError;

/// Reasons why a design is impossible.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The model is invalid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A model of the design is invalid.
    #[error("{model}: {source}")]
    At {
        /// Name of the model.
        model: String,
        /// The reason.
        source: Box<DesignError>,
    },
    /// The shape of a matrix does not match the rest of the problem.
    #[error("{matrix}: found {rows}x{columns}, expected {expected_rows}x{expected_columns}")]
    Shape {
        /// The matrix.
        matrix: &'static str,
        /// Rows found.
        rows: usize,
        /// Columns found.
        columns: usize,
        /// Rows expected.
        expected_rows: usize,
        /// Columns expected.
        expected_columns: usize,
    },
    /// A matrix contains NaN or an infinity.
    #[error("{matrix}: found NaN or an infinity, expected finite numbers")]
    NotFinite {
        /// The matrix.
        matrix: &'static str,
    },
    /// A weight or covariance is not symmetric.
    #[error("{matrix}: found a matrix that is not symmetric, expected a symmetric one")]
    NotSymmetric {
        /// The matrix.
        matrix: &'static str,
    },
    /// A weight or covariance is not positive definite or semidefinite, as the problem requires.
    #[error("{matrix}: found the eigenvalue {eigenvalue}, expected none {bound}")]
    NotDefinite {
        /// The matrix.
        matrix: &'static str,
        /// Lowest eigenvalue of the matrix.
        eigenvalue: f64,
        /// `"below 0"` or `"at or below 0"`.
        bound: &'static str,
    },
    /// A matrix that must be inverted is singular.
    #[error("{matrix} is singular")]
    Singular {
        /// The matrix.
        matrix: &'static str,
    },
    /// A mode that does not decay is not controllable.
    #[error(
        "the mode {re} {im:+}i does not decay and no input controls it (the matrix [λI - A, B] has \
         a singular value of {singular_value}), expected a model that can be stabilised"
    )]
    NotStabilisable {
        /// Real part of the mode.
        re: f64,
        /// Imaginary part of the mode.
        im: f64,
        /// Smallest singular value of the pencil at the mode.
        singular_value: f64,
    },
    /// The Riccati equation has no stabilising solution.
    #[error("no stabilising solution: {reason}")]
    NoStabilisingSolution {
        /// The reason, if known.
        reason: &'static str,
    },
    /// The margins of an unstable closed loop were requested.
    #[error("the closed loop has the unstable mode {re} {im:+}i, expected a stable loop")]
    UnstableLoop {
        /// Real part of the mode.
        re: f64,
        /// Imaginary part of the mode.
        im: f64,
    },
    /// A number is out of its range.
    #[error("{name}: found {}, expected {expected}", written(*value))]
    Range {
        /// The quantity.
        name: &'static str,
        /// Value found.
        value: f64,
        /// Value expected.
        expected: &'static str,
    },
    /// The unit of an input is not a stick unit.
    #[error("input {input}: found the unit {unit}, expected \"stick\" (-1 to 1) or \"percent\"")]
    InputUnit {
        /// The input.
        input: String,
        /// Unit found.
        unit: String,
    },
    /// The unit of a state differs from the unit in the design's equations, which would misinterpret its values.
    #[error("state {state}: found the unit {unit}, expected {expected}")]
    StateUnit {
        /// The state.
        state: String,
        /// Unit found.
        unit: String,
        /// Unit expected.
        expected: &'static str,
    },
    /// A file of weights contains one weight too many.
    #[error("{}: found {place}, counted from 0, expected one weight fewer", path.display())]
    Surplus {
        /// The file.
        path: PathBuf,
        /// Location of the surplus weight in the file.
        place: String,
    },
    /// A file of weights cannot be read, or is not a design.
    #[error(transparent)]
    Toml(#[from] TomlError),
}

/// Text of a number. Numbers from 1e6 on have exponential notation, because they may have 300 digits.
fn written(value: f64) -> String {
    if value.is_finite() && value.abs() >= 1e6 { format!("{value:e}") } else { value.to_string() }
}
