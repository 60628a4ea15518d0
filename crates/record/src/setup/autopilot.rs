//! `autopilot.toml`: the autopilot's configuration in a file.

use std::path::{Path, PathBuf};

use hovernav::autopilot::{ConfigError, HoverConfig};
use hovernav_toml::TomlError;

/// Why an autopilot's file is rejected.
#[derive(Debug, thiserror::Error)]
pub enum AutopilotFileError {
    /// The file cannot be read or written, or does not contain an autopilot.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// The autopilot in the file cannot fly.
    #[error("{}: {source}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// The invalid value.
        source: ConfigError,
    },
}

/// Reads `autopilot.toml` and checks that its autopilot can fly.
///
/// # Errors
/// [`AutopilotFileError`].
pub fn read_autopilot(path: &Path) -> Result<HoverConfig, AutopilotFileError> {
    let (config, _): (HoverConfig, _) = hovernav_toml::read(path)?;
    config.check().map_err(|source| AutopilotFileError::Value { path: path.into(), source })?;
    Ok(config)
}

/// Writes `config` to `path`, after `remark` as a comment. It reads back bit for bit.
///
/// # Errors
/// [`AutopilotFileError`], also for a configuration that cannot fly.
pub fn write_autopilot(
    config: &HoverConfig,
    path: &Path,
    remark: &str,
) -> Result<(), AutopilotFileError> {
    config.check().map_err(|source| AutopilotFileError::Value { path: path.into(), source })?;
    let body = hovernav_toml::to_string(config)
        .map_err(|error| TomlError::at(path, "", 0, &error.to_string()))?;
    let remark: String = remark.lines().map(|line| format!("# {line}\n")).collect();
    hovernav_toml::write_whole(path, remark + &body)
        .map_err(|source| TomlError::Io { path: path.into(), source })?;
    Ok(())
}
