//! Errors of the library as Python exceptions.

use hovernav_dataset::LogError;
use hovernav_sim::faults::InjectError;
use pyo3::exceptions::{PyFileNotFoundError, PyOSError};
use pyo3::prelude::*;

mod python {
    #![allow(missing_docs, reason = "documented where Python defines them")]
    use pyo3::import_exception;

    import_exception!(hovernav._errors, ArrayError);
    import_exception!(hovernav._errors, ConfigError);
    import_exception!(hovernav._errors, FaultError);
    import_exception!(hovernav._errors, LogError);
    import_exception!(hovernav._errors, ModelError);
    import_exception!(hovernav._errors, SetupError);
}

/// An error that is returned to Python.
#[derive(Debug)]
pub enum Error {
    /// An error of the library.
    Log(LogError),
    /// An error of Python, such as an interrupt.
    Python(PyErr),
    /// An error in arrays, as text.
    Array(String),
    /// An error in settings, as text.
    Config(String),
    /// An error in the faults to inject, as text.
    Fault(String),
    /// An error of a model or an autopilot, as text.
    Model(String),
}

/// Result of a function that Python calls.
pub type Result<T> = std::result::Result<T, Error>;

impl From<LogError> for Error {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}

impl From<PyErr> for Error {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<InjectError> for Error {
    fn from(error: InjectError) -> Self {
        match error {
            InjectError::Log(error) => Self::Log(error),
            other => Self::Fault(other.to_string()),
        }
    }
}

impl From<Error> for PyErr {
    fn from(error: Error) -> Self {
        match error {
            Error::Python(error) => error,
            Error::Array(words) => python::ArrayError::new_err(words),
            Error::Config(words) => python::ConfigError::new_err(words),
            Error::Fault(words) => python::FaultError::new_err(words),
            Error::Model(words) => python::ModelError::new_err(words),
            Error::Log(error) => {
                let words = error.to_string();
                match error {
                    LogError::Toml(_) => python::ConfigError::new_err(words),
                    LogError::Setup { .. } => python::SetupError::new_err(words),
                    _ => python::LogError::new_err(words),
                }
            }
        }
    }
}

/// The error of the operating system for a scratch directory.
pub fn scratch(error: &std::io::Error) -> Error {
    let words = format!("cannot create a temporary directory: {error}");
    Error::Python(match error.kind() {
        std::io::ErrorKind::NotFound => PyFileNotFoundError::new_err(words),
        _ => PyOSError::new_err(words),
    })
}
