//! Settings from Python: a file, or a dictionary in the form of `dataset.toml`.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::error::{Error, Result};

/// Settings that override those of a log.
pub struct Settings {
    /// The text of a settings file.
    pub text: String,
    /// Name of the settings file in messages.
    pub name: PathBuf,
}

impl Settings {
    /// The settings in `config`: the path of a file, or a dictionary with its keys.
    pub fn of(config: &Bound<'_, PyAny>) -> Result<Self> {
        let Ok(keys) = config.cast::<PyDict>() else {
            let name: PathBuf = config.extract().map_err(|_| {
                let kind = config.get_type();
                Error::Config(format!("config: found {kind}, expected a path or a dictionary"))
            })?;
            let text = hovernav_toml::read_text(&name).map_err(hovernav_dataset::LogError::from)?;
            return Ok(Self { text, name });
        };
        let rejected = |why: String| Error::Config(format!("config: {why}"));
        let arguments = PyDict::new(keys.py());
        arguments.set_item("allow_nan", false)?;
        // NumPy arrays and numbers are converted by their method `tolist`.
        let to_list = keys.py().import("operator")?.call_method1("methodcaller", ("tolist",))?;
        arguments.set_item("default", to_list)?;
        let json = keys.py().import("json")?.call_method("dumps", (keys,), Some(&arguments));
        let json = json.map_err(|error| rejected(error.value(keys.py()).to_string()))?;
        let json = json.cast::<PyString>().map_err(PyErr::from)?.to_string();
        let value: toml::Value =
            serde_json::from_str(&json).map_err(|error| rejected(error.to_string()))?;
        let text = toml::to_string(&value).map_err(|error| rejected(error.to_string()))?;
        Ok(Self { text, name: "config".into() })
    }

    /// Name of the settings in messages.
    pub fn name(&self) -> &Path {
        &self.name
    }
}

/// The settings in `config` as JSON, for another process.
#[pyfunction]
pub fn _settings_json(config: &Bound<'_, PyAny>) -> Result<String> {
    let Settings { text, name } = Settings::of(config)?;
    let rejected = |why: String| Error::Config(format!("{}: {why}", name.display()));
    let value: toml::Value = toml::from_str(&text).map_err(|error| rejected(error.to_string()))?;
    serde_json::to_string(&value).map_err(|error| rejected(error.to_string()))
}
