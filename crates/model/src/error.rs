//! Why a model is refused.

use hovernav_toml::TomlError;

/// Why a model could not be made, read, written or used.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// A model file cannot be read or written, or does not spell a model.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A matrix has another shape than the names ask for.
    #[error("{matrix}: found {rows}x{columns}, expected {expected_rows}x{expected_columns}")]
    Shape {
        /// Which matrix.
        matrix: &'static str,
        /// Rows found.
        rows: usize,
        /// Columns found.
        columns: usize,
        /// Rows that the names ask for.
        expected_rows: usize,
        /// Columns that the names ask for.
        expected_columns: usize,
    },
    /// A matrix holds NaN or an infinity.
    #[error("{matrix}: found {value} in row {row}, column {column}, expected a finite number")]
    NotFinite {
        /// Which matrix.
        matrix: &'static str,
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// What stands there.
        value: f64,
    },
    /// A parameter is NaN or infinite, or its covariance is no covariance.
    #[error("parameter {name}: {reason}")]
    Parameter {
        /// Its name.
        name: String,
        /// What was found and expected.
        reason: &'static str,
    },
    /// A name is empty or stands twice.
    #[error("{list}: found the name \"{name}\" {found}, expected each name once")]
    Name {
        /// Which list.
        list: &'static str,
        /// The name.
        name: String,
        /// `"empty"` or `"twice"`.
        found: &'static str,
    },
    /// A slope speaks of what the model does not have, or is no number.
    #[error("slope {index}, {what}: found \"{found}\", expected {expected}")]
    Slope {
        /// Which, from 1.
        index: usize,
        /// What of it.
        what: &'static str,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A name that the model does not have.
    #[error("{list}: the model has no \"{name}\", expected one of {known}")]
    Unknown {
        /// Which list.
        list: &'static str,
        /// The name asked for.
        name: String,
        /// Those there are.
        known: String,
    },
    /// The sample period is not a positive number.
    #[error("sample period: found {period_s} s, expected a number above 0")]
    Period {
        /// What was found, s.
        period_s: f64,
    },
    /// The model is in the wrong time domain for what is asked.
    #[error("the model is {found}, expected {expected}")]
    TimeDomain {
        /// What the model is.
        found: &'static str,
        /// What it should be.
        expected: &'static str,
    },
    /// States that were to be removed have no steady value.
    #[error("states {states} cannot be removed: they have no steady value")]
    NoSteadyValue {
        /// The states.
        states: String,
    },
    /// The eigenvalues did not settle.
    #[error("the eigenvalues of a {size}x{size} matrix did not settle")]
    Eigenvalues {
        /// Its size.
        size: usize,
    },
}
