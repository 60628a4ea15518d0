//! Why a flight's configuration is refused.

use std::path::PathBuf;

use hovernav_toml::TomlError;

/// Why a flight's configuration is refused: one line that names the file and the place in it.
#[derive(Debug, thiserror::Error)]
pub enum FlyConfigError {
    /// It cannot be read, is not TOML, or a value is not of its key's kind or range.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// Keys that nothing knows.
    #[error("{}: no such key: {}", path.display(), keys.join(", "))]
    UnknownKeys {
        /// The file.
        path: PathBuf,
        /// The keys, with their sections.
        keys: Vec<String>,
    },
    /// A value that cannot be.
    #[error("{}{key}: {reason}", bracketed(section))]
    Value {
        /// The section; empty of the keys that stand in none.
        section: String,
        /// The key.
        key: String,
        /// What was found and expected.
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

/// The section's head; of the keys that stand in none, nothing.
fn bracketed(section: &str) -> String {
    if section.is_empty() { String::new() } else { format!("[{section}] ") }
}
