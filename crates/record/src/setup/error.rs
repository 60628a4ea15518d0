//! Errors of a flight's configuration.

use std::path::PathBuf;

use hovernav_toml::TomlError;

/// Why a flight's configuration is rejected: one line with the file and the line or key.
#[derive(Debug, thiserror::Error)]
pub enum FlyConfigError {
    /// The file cannot be read, is not TOML, or a value has the wrong kind or is out of range.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// Unknown keys.
    #[error("{}: no such key: {}", path.display(), keys.join(", "))]
    UnknownKeys {
        /// The file.
        path: PathBuf,
        /// The keys, with their sections.
        keys: Vec<String>,
    },
    /// An impossible value.
    #[error("{}{key}: {reason}", bracketed(section))]
    Value {
        /// The section; empty for keys outside all sections.
        section: String,
        /// The key.
        key: String,
        /// Found and expected values.
        reason: String,
    },
}

impl FlyConfigError {
    pub(super) fn value(
        section: impl Into<String>,
        key: impl Into<String>,
        reason: &impl std::fmt::Display,
    ) -> Self {
        Self::Value { section: section.into(), key: key.into(), reason: reason.to_string() }
    }
}

/// The section in brackets; empty for keys outside all sections.
fn bracketed(section: &str) -> String {
    if section.is_empty() { String::new() } else { format!("[{section}] ") }
}
