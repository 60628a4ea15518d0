//! `autopilot.toml`: the autopilot's configuration as a file.

use std::path::{Path, PathBuf};

use hovernav::autopilot::{ConfigError, HoverConfig};
use hovernav_toml::TomlError;

/// Why an autopilot's file is refused.
#[derive(Debug, thiserror::Error)]
pub enum AutopilotFileError {
    /// It cannot be read or written, or does not spell an autopilot.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// It spells one that cannot fly.
    #[error("{}: {source}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Which value.
        source: ConfigError,
    },
}

/// Reads `autopilot.toml` and checks that one can fly with it.
///
/// # Errors
/// [`AutopilotFileError`].
pub fn read_autopilot(path: &Path) -> Result<HoverConfig, AutopilotFileError> {
    let (config, _): (HoverConfig, _) = hovernav_toml::read(path)?;
    config.check().map_err(|source| AutopilotFileError::Value { path: path.into(), source })?;
    Ok(config)
}

/// Writes `config` to `path`, below `remark` as a comment. What is read back is the same to the bit.
///
/// # Errors
/// [`AutopilotFileError`], also for a configuration one cannot fly with.
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
