#![doc = include_str!("../README.md")]

mod deserializer;
mod file;
mod recording;
mod whole_file;
mod words;

use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::Table;
use toml::de::{DeTable, DeValue};

use deserializer::{Place, ValueDeserializer};
use recording::Recording;

pub use file::{open_file, read_bytes};
pub use whole_file::{WholeFile, copy_whole, write_whole};

/// Set-up files are short: no larger file is one, bytes.
const LONGEST_TEXT: u64 = 16 << 20;

/// Why a TOML file is refused: one line that names the file and the place in it.
#[derive(Debug, thiserror::Error)]
pub enum TomlError {
    /// The file system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The text is not TOML, or a value is not of its key's kind or range.
    #[error("{}:{line}: {reason}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What was found and expected, on one line.
        reason: String,
    },
}

impl TomlError {
    /// The error of `text`, the contents of the file `path`, at the byte `offset`.
    #[must_use]
    pub fn at(path: &Path, text: &str, offset: usize, reason: &str) -> Self {
        let line = 1 + text.bytes().take(offset).filter(|&byte| byte == b'\n').count();
        Self::Text { path: path.to_path_buf(), line, reason: reason.replace('\n', ", ") }
    }

    /// The error of [`toml`]'s own parser on `text`, the contents of the file `path`.
    #[must_use]
    pub fn of(path: &Path, text: &str, error: &toml::de::Error) -> Self {
        Self::at(path, text, error.span().map_or(0, |span| span.start), error.message())
    }
}

/// The text of the file `path`, past a byte order mark.
///
/// # Errors
/// [`TomlError::Io`], and [`TomlError::Text`] where it is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, TomlError> {
    let bytes = read_bytes(path, LONGEST_TEXT)
        .map_err(|source| TomlError::Io { path: path.to_path_buf(), source })?;
    let mut text = String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(&error.as_bytes()[..valid]);
        TomlError::at(path, &text, valid, "found bytes that are not UTF-8, expected text")
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// What the file `path` spells, and the keys in it that nothing knows.
///
/// # Errors
/// As [`read_text`] and [`parse`].
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<(T, Vec<String>), TomlError> {
    parse(&read_text(path)?, path)
}

/// What `text` spells, and the keys in it that nothing knows, as in `gps.latency`; `path` names it in
/// messages. A date is given to its key's type as text.
///
/// # Errors
/// [`TomlError::Text`] where the text is not TOML, or a value is not of its key's kind or range.
pub fn parse<T: DeserializeOwned>(text: &str, path: &Path) -> Result<(T, Vec<String>), TomlError> {
    let table = parse_table(text, path)?;
    from_table(table).map_err(|error| error.in_text(text, path))
}

/// The table that `text` spells; `path` names it in messages.
///
/// # Errors
/// [`TomlError::Text`] where the text is not TOML.
pub fn parse_table(text: &str, path: &Path) -> Result<Table, TomlError> {
    text.parse().map_err(|error| TomlError::of(path, text, &error))
}

/// What `table` spells, and the keys in it that nothing knows.
///
/// # Errors
/// [`ValueError`] where a value is not of its key's kind or range.
pub fn from_table<T: DeserializeOwned>(table: Table) -> Result<(T, Vec<String>), ValueError> {
    let mut unknown = Vec::new();
    let value = toml::Value::Table(table);
    let parsed = T::deserialize(ValueDeserializer::new(&value, &mut unknown))?;
    Ok((parsed, unknown))
}

/// `value` as a TOML document.
///
/// # Errors
/// A value that TOML has no form for, such as a list with `None` in it.
pub fn to_string<T: Serialize + ?Sized>(value: &T) -> Result<String, toml::ser::Error> {
    toml::to_string(&Recording::of(value)?)
}

/// `value` as a TOML value.
///
/// # Errors
/// As [`to_string`]; also an integer above 2⁶³ − 1, and a map whose keys are no text.
pub fn to_value<T: Serialize + ?Sized>(value: &T) -> Result<toml::Value, toml::ser::Error> {
    toml::Value::try_from(Recording::of(value)?)
}

/// `base` with the keys of `table` put over it, tables key by key and everything else whole.
///
/// # Errors
/// [`ValueError`] as [`from_table`], and for what TOML cannot hold.
pub fn overlaid<T: Serialize + DeserializeOwned>(base: &T, table: Table) -> Result<T, ValueError> {
    let text = to_string(base).map_err(serde::de::Error::custom)?;
    let mut merged: Table = text.parse().map_err(serde::de::Error::custom)?;
    put_over(&mut merged, table);
    Ok(from_table(merged)?.0)
}

fn put_over(base: &mut Table, table: Table) {
    for (key, value) in table {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(value)) => put_over(inner, value),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// A value that is not of its key's kind or range: its key, what was found and what is expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValueError {
    message: String,
    place: Vec<Place>,
}

impl std::error::Error for ValueError {}

impl ValueError {
    /// The error of `key`: `reason` says what was found and what is expected.
    #[must_use]
    pub fn of_key(key: &str, reason: &str) -> Self {
        <Self as serde::de::Error>::custom(reason).below(key)
    }

    /// The same error of what stands below `key`.
    #[must_use]
    pub fn below(mut self, key: &str) -> Self {
        self.place.push(Place::Key(key.to_owned()));
        self
    }

    /// This error with its line in `text`, the contents of the file `path`, which was read into the value.
    #[must_use]
    pub fn in_text(&self, text: &str, path: &Path) -> TomlError {
        TomlError::at(path, text, offset_of(text, &self.place).unwrap_or(0), &self.to_string())
    }
}

impl std::fmt::Display for ValueError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&words::sentence(&self.place, &self.message))
    }
}

/// The byte of `text` at which the value of `key`, one of the outermost, begins; 0 where there is none.
#[must_use]
pub fn offset_of_key(text: &str, key: &str) -> usize {
    offset_of(text, &[Place::Key(key.to_owned())]).unwrap_or(0)
}

/// Byte of `text` at which the value at `place`, given from the innermost key outward, begins.
fn offset_of(text: &str, place: &[Place]) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let (mut start, mut value) = (0, &DeValue::Table(document.into_inner()));
    for step in place.iter().rev() {
        let next = match (value, step) {
            (DeValue::Table(table), Place::Key(key)) => table.get(key.as_str()),
            (DeValue::Array(list), Place::Index(index)) => list.get(*index),
            _ => None,
        };
        // What is missing is missing from what is around it.
        let Some(next) = next else { break };
        (start, value) = (next.span().start, next.get_ref());
    }
    Some(start)
}
