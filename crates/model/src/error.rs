//! Errors of models.

use hovernav_toml::TomlError;

/// Reasons why a model cannot be made, read, written or used.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// A model file cannot be read or written, or does not contain a model.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// The shape of a matrix does not match the names of its rows and columns.
    #[error("{matrix}: found {rows}x{columns}, expected {expected_rows}x{expected_columns}")]
    Shape {
        /// The matrix.
        matrix: &'static str,
        /// Rows found.
        rows: usize,
        /// Columns found.
        columns: usize,
        /// Number of rows required by the names.
        expected_rows: usize,
        /// Number of columns required by the names.
        expected_columns: usize,
    },
    /// A matrix contains NaN or an infinity.
    #[error("{matrix}: found {value} in row {row}, column {column}, expected a finite number")]
    NotFinite {
        /// The matrix.
        matrix: &'static str,
        /// Row number, counted from 1.
        row: usize,
        /// Column number, counted from 1.
        column: usize,
        /// Value found.
        value: f64,
    },
    /// A parameter is NaN or infinite, or its covariance is invalid.
    #[error("parameter {name}: {reason}")]
    Parameter {
        /// Name of the parameter.
        name: String,
        /// Value found and value expected.
        reason: &'static str,
    },
    /// A name is empty or occurs twice.
    #[error("{list}: found the name \"{name}\" {found}, expected each name once")]
    Name {
        /// List that contains the name, for example `states`.
        list: &'static str,
        /// The name.
        name: String,
        /// `"empty"` or `"twice"`.
        found: &'static str,
    },
    /// A slope refers to something that the model does not have, or is not a number.
    #[error("slope {index}, {what}: found \"{found}\", expected {expected}")]
    Slope {
        /// Number of the slope, counted from 1.
        index: usize,
        /// Invalid part of the slope.
        what: &'static str,
        /// Value found.
        found: String,
        /// Value expected.
        expected: &'static str,
    },
    /// The model has no state, input or output of the requested name.
    #[error("{list}: the model has no \"{name}\", expected one of {known}")]
    Unknown {
        /// List that was searched, for example `states`.
        list: &'static str,
        /// The requested name.
        name: String,
        /// Names that exist in the list.
        known: String,
    },
    /// The sample period is not a positive number.
    #[error("sample period: found {period_s} s, expected a number above 0")]
    Period {
        /// Value found, s.
        period_s: f64,
    },
    /// The speed of a trim is no number, or no trim exists at this speed.
    #[error(
        "forward speed of the trim: found {found}, expected a speed in m/s at which the vehicle has a trim"
    )]
    Speed {
        /// Value found.
        found: String,
    },
    /// The operation requires a continuous model and found a discrete one, or the reverse.
    #[error("the model is {found}, expected {expected}")]
    TimeDomain {
        /// Time domain of the model.
        found: &'static str,
        /// Time domain expected.
        expected: &'static str,
    },
    /// The states to be removed have no steady state.
    #[error("states {states} cannot be removed: they have no steady state")]
    NoSteadyValue {
        /// The states.
        states: String,
    },
    /// The eigenvalue computation did not converge.
    #[error("the eigenvalues of a {size}x{size} matrix did not converge")]
    Eigenvalues {
        /// Size of the matrix.
        size: usize,
    },
}
