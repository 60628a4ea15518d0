//! Why a design is refused.

use std::path::PathBuf;

use hovernav_model::ModelError;
use hovernav_toml::TomlError;

/// Why a design could not be made.
#[derive(Debug, thiserror::Error)]
pub enum DesignError {
    /// The model is refused.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A matrix has another shape than the rest of the problem asks for.
    #[error("{matrix}: found {rows}x{columns}, expected {expected_rows}x{expected_columns}")]
    Shape {
        /// Which matrix.
        matrix: &'static str,
        /// Rows found.
        rows: usize,
        /// Columns found.
        columns: usize,
        /// Rows asked for.
        expected_rows: usize,
        /// Columns asked for.
        expected_columns: usize,
    },
    /// A matrix holds NaN or an infinity.
    #[error("{matrix}: found NaN or an infinity, expected finite numbers")]
    NotFinite {
        /// Which matrix.
        matrix: &'static str,
    },
    /// A weight or covariance is not symmetric.
    #[error("{matrix}: found a matrix that is not symmetric, expected a symmetric one")]
    NotSymmetric {
        /// Which matrix.
        matrix: &'static str,
    },
    /// A weight or covariance is not as definite as it must be.
    #[error("{matrix}: found the eigenvalue {eigenvalue}, expected none {bound}")]
    NotDefinite {
        /// Which matrix.
        matrix: &'static str,
        /// Its lowest eigenvalue.
        eigenvalue: f64,
        /// `"below 0"` or `"at or below 0"`.
        bound: &'static str,
    },
    /// A matrix that must be inverted is singular.
    #[error("{matrix} is singular")]
    Singular {
        /// Which matrix.
        matrix: &'static str,
    },
    /// A mode that does not die away cannot be reached by the inputs.
    #[error(
        "the mode {re} {im:+}i does not die away and no input moves it (the matrix [λI - A, B] has \
         a singular value of {singular_value}), expected a model that can be stabilised"
    )]
    NotStabilisable {
        /// Real part of the mode.
        re: f64,
        /// Imaginary part.
        im: f64,
        /// Smallest singular value of the pencil there.
        singular_value: f64,
    },
    /// The Riccati equation has no solution that stabilises.
    #[error("no stabilising solution: {reason}")]
    NoStabilisingSolution {
        /// Why, as far as it is known.
        reason: &'static str,
    },
    /// The closed loop whose margins are asked for is not stable.
    #[error("the closed loop has the unstable mode {re} {im:+}i, expected a stable loop")]
    UnstableLoop {
        /// Real part of the mode.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A number is out of its range.
    #[error("{name}: found {}, expected {expected}", written(*value))]
    Range {
        /// Which.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// An input counts in a unit that no stick has.
    #[error("input {input}: found the unit {unit}, expected \"stick\" (-1 to 1) or \"percent\"")]
    InputUnit {
        /// The input.
        input: String,
        /// Its unit.
        unit: String,
    },
    /// A state counts in a unit that the equations of a design do not: its numbers would be taken for others.
    #[error("state {state}: found the unit {unit}, expected {expected}")]
    StateUnit {
        /// The state.
        state: String,
        /// Its unit.
        unit: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A file of weights has something that nothing reads: one weight more than there is to weigh.
    #[error("{}: found {place}, counted from 0, which is one too many, expected nothing there", path.display())]
    Surplus {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: String,
    },
    /// A file of weights cannot be read, or does not spell a design.
    #[error(transparent)]
    Toml(#[from] TomlError),
}

/// A number as a reader would write it: not 300 digits of it.
fn written(value: f64) -> String {
    if value.is_finite() && value.abs() >= 1e6 { format!("{value:e}") } else { value.to_string() }
}
