//! Why a log could not be read or written.

use std::io;
use std::path::{Path, PathBuf};

use crate::finding::SetupFinding;
use hovernav::time::Time;
use hovernav_toml::TomlError;

/// Why a log could not be read or written: one line that names the file and the place in it.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A table lacks columns it cannot do without.
    #[error("{}:{line}: expected {expected}, found {found}", path.display())]
    Columns {
        /// The table.
        path: PathBuf,
        /// Line of the header, from 1.
        line: u64,
        /// The columns asked for.
        expected: String,
        /// The header found, shortened.
        found: String,
    },
    /// A field holds something that is not what its column is for.
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
        /// What should stand there.
        expected: &'static str,
    },
    /// A file that must hold something holds nothing usable, or cannot hold what it is given.
    #[error("{}: {reason}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// What was found, and what was expected.
        reason: String,
    },
    /// A file of bytes is not what it should be.
    #[error("{}: at byte {offset}: {reason}", path.display())]
    Bytes {
        /// The file.
        path: PathBuf,
        /// Where in it, from 0.
        offset: u64,
        /// What was found and expected.
        reason: String,
    },
    /// A log whose reader was left out of this build.
    #[error("{}: {format}: hovernav-formats was built without its feature {feature}", path.display())]
    LeftOut {
        /// The file.
        path: PathBuf,
        /// What it is.
        format: String,
        /// The feature that reads it.
        feature: &'static str,
    },
    /// The clock of a table does not run forward, beyond the repair of stray rows.
    #[error(
        "{}:{line}: time goes back from {before} to {found}, and {left_out} of {rows} rows would be \
         left out to mend it; expected one recording with one clock",
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
        /// How many rows time's order would cost.
        left_out: usize,
        /// How many rows there are.
        rows: usize,
    },
    /// What the sensors say cannot be.
    #[error("{}: {}", path.display(), in_words(findings))]
    Setup {
        /// The log.
        path: PathBuf,
        /// What cannot be, and how to mend it.
        findings: Vec<SetupFinding>,
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

fn in_words(findings: &[SetupFinding]) -> String {
    findings.iter().map(SetupFinding::to_string).collect::<Vec<_>>().join("; and ")
}

impl LogError {
    /// The system's error about `path`.
    pub fn io(path: &Path) -> impl FnOnce(io::Error) -> Self + use<'_> {
        move |source| Self::Io { path: path.to_path_buf(), source }
    }

    /// The file `path` is no longer what it was when it was opened.
    pub(crate) fn changed(path: PathBuf) -> Self {
        let reason = "the file was changed while it was in use, expected it to stay as it is";
        Self::Unusable { path, reason: reason.into() }
    }

    /// What is wrong with `path` at byte `offset`, from 0.
    #[must_use]
    pub fn bytes(path: &Path, offset: usize, reason: String) -> Self {
        Self::Bytes { path: path.to_path_buf(), offset: offset as u64, reason }
    }
}

/// `text` made fit for a one-line message: at most `longest` characters, none that breaks the line.
pub(crate) fn excerpt(text: &[u8], longest: usize) -> String {
    // No character takes more than four bytes.
    let text = String::from_utf8_lossy(&text[..text.len().min(4 * longest + 4)]);
    let mut shown: String = text.escape_debug().take(longest).collect();
    if text.escape_debug().nth(longest).is_some() {
        shown.push('…');
    }
    shown
}
