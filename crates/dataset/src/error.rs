//! Errors of reading and writing logs.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

use hovernav::time::Time;
use hovernav_toml::TomlError;

/// Error of reading or writing a log. The message is one line with the file and the line or byte offset.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The operating system reported an error.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
    /// A table lacks required columns.
    #[error("{}:{line}: expected {expected}, found {found}", path.display())]
    Columns {
        /// The table.
        path: PathBuf,
        /// Line of the header, from 1.
        line: u64,
        /// The required columns.
        expected: String,
        /// The header found, shortened.
        found: String,
    },
    /// A field has the wrong kind of content for its column.
    #[error("{}:{line}: column {column}: found \"{found}\", expected {expected}", path.display())]
    Field {
        /// The table.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// The text found, shortened, on one line.
        found: String,
        /// Expected content of the column.
        expected: &'static str,
    },
    /// A file has no usable content, or cannot hold the given data.
    #[error("{}: {reason}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Found and expected content.
        reason: String,
    },
    /// A binary file has invalid content.
    #[error("{}: at byte {offset}: {reason}", path.display())]
    Bytes {
        /// The file.
        path: PathBuf,
        /// Byte offset, from 0.
        offset: u64,
        /// Found and expected content.
        reason: String,
    },
    /// The reader of the log's format is not part of this build.
    #[error("{}: {format}: hovernav-formats was built without its feature {feature}", path.display())]
    MissingFeature {
        /// The file.
        path: PathBuf,
        /// Format of the file.
        format: String,
        /// The feature that enables the reader.
        feature: &'static str,
    },
    /// The clock of a table does not run forward, even without stray rows.
    #[error(
        "{}:{line}: time goes back from {before} to {found}, and {skipped} of {rows} rows would be \
         removed to repair it; expected one recording with one clock",
        path.display()
    )]
    Clock {
        /// The table.
        path: PathBuf,
        /// Line where time first goes back, from 1.
        line: u64,
        /// The time on the row before.
        before: Time,
        /// The time on that line.
        found: Time,
        /// Number of rows that a repair would remove.
        skipped: usize,
        /// Number of rows.
        rows: usize,
    },
    /// The sensors' readings are impossible with this set-up.
    #[error("{}: {}", path.display(), findings.join("; and "))]
    Setup {
        /// The log.
        path: PathBuf,
        /// The errors, with causes and remedies, a sentence each.
        findings: Vec<String>,
    },
    /// A manifest or configuration cannot be read or is not valid.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A number to be written is NaN, infinite or beyond what the column can hold.
    #[error("{}: row {row}, column {column}: {value} cannot be written", path.display())]
    Unwritable {
        /// The file to be written.
        path: PathBuf,
        /// Row after the header, from 1.
        row: usize,
        /// Name of the column.
        column: &'static str,
        /// The value.
        value: f64,
    },
}

impl LogError {
    /// Wraps the operating system's error about `path`.
    pub fn io(path: &Path) -> impl FnOnce(io::Error) -> Self + use<'_> {
        move |source| Self::Io { path: path.to_path_buf(), source }
    }

    /// Error for a file `path` that has changed since it was opened.
    pub(crate) fn changed(path: PathBuf) -> Self {
        let reason = "found the file changed while in use, expected it unchanged";
        Self::Unusable { path, reason: reason.into() }
    }

    /// Error in `path` at byte `offset`, from 0.
    #[must_use]
    pub fn bytes(path: &Path, offset: usize, reason: String) -> Self {
        Self::Bytes { path: path.to_path_buf(), offset: offset as u64, reason }
    }
}

/// `text` with the characters that `is_spelt` selects as escape sequences of Rust, such as `\u{1b}`.
#[must_use]
pub fn spelt_out(text: &str, is_spelt: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_spelt) {
        return Cow::Borrowed(text);
    }
    let spelt = |letter: char| match is_spelt(letter) {
        true => letter.escape_default().to_string(),
        false => letter.to_string(),
    };
    Cow::Owned(text.chars().map(spelt).collect())
}

/// `text` for a one-line message: at most `longest` characters, with line breaks escaped.
pub(crate) fn excerpt(text: &[u8], longest: usize) -> String {
    // A character has at most four bytes.
    let text = String::from_utf8_lossy(&text[..text.len().min(4 * longest + 4)]);
    let mut shown: String = text.escape_debug().take(longest).collect();
    if text.escape_debug().nth(longest).is_some() {
        shown.push('…');
    }
    shown
}
