//! `autopilot.toml`: the autopilot's configuration as a file.

use std::io;
use std::path::{Path, PathBuf};

use hovernav::autopilot::{ConfigError, HoverConfig};

/// Why an autopilot's file is refused.
#[derive(Debug, thiserror::Error)]
pub enum AutopilotFileError {
    /// The file system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It does not spell an autopilot.
    #[error("{}:{line}: {reason}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What was found and expected.
        reason: String,
    },
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
    let text = std::fs::read_to_string(path)
        .map_err(|source| AutopilotFileError::Io { path: path.into(), source })?;
    let config: HoverConfig = toml::from_str(&text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        let line = 1 + text.bytes().take(start).filter(|&byte| byte == b'\n').count();
        AutopilotFileError::Text { path: path.into(), line, reason: error.message().into() }
    })?;
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
    let body = toml::to_string(config).map_err(|error| AutopilotFileError::Text {
        path: path.into(),
        line: 1,
        reason: error.to_string(),
    })?;
    let remark: String = remark.lines().map(|line| format!("# {line}\n")).collect();
    std::fs::write(path, remark + &body)
        .map_err(|source| AutopilotFileError::Io { path: path.into(), source })
}
