#![doc = include_str!("../README.md")]

mod deserializer;
mod file;
mod place;
mod recording;
mod whole_file;
mod words;

use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::Table;
use toml::de::{DeTable, DeValue};

use deserializer::ValueDeserializer;
use place::Place;
use recording::Recording;

pub use file::{open_file, read_bytes};
pub use whole_file::{WholeFile, copy_whole, fresh_file, write_whole};

/// Largest size of a set-up file, bytes.
const LONGEST_TEXT: u64 = 16 << 20;

/// Why a TOML file is rejected: one line with the file and the line in it.
#[derive(Debug, thiserror::Error)]
pub enum TomlError {
    /// The operating system reported an error.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
    /// The text is not TOML, or a value has the wrong kind or is out of range.
    #[error("{}:{line}: {reason}", path.display())]
    Text {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Found and expected values, on one line.
        reason: String,
    },
}

impl TomlError {
    /// Error in `text`, the contents of the file `path`, at the byte `offset`.
    #[must_use]
    pub fn at(path: &Path, text: &str, offset: usize, reason: &str) -> Self {
        let line = 1 + text.bytes().take(offset).filter(|&byte| byte == b'\n').count();
        Self::Text { path: path.to_path_buf(), line, reason: reason.replace('\n', ", ") }
    }

    /// Error of [`toml`]'s own parser in `text`, the contents of the file `path`.
    #[must_use]
    pub fn of(path: &Path, text: &str, error: &toml::de::Error) -> Self {
        Self::at(path, text, error.span().map_or(0, |span| span.start), error.message())
    }
}

/// Reads the text of the file `path`, without a byte order mark.
///
/// # Errors
/// [`TomlError::Io`], and [`TomlError::Text`] if it is not UTF-8.
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

/// Reads the value in the file `path`, and the unknown keys in it.
///
/// # Errors
/// As [`read_text`] and [`parse`].
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<(T, Vec<String>), TomlError> {
    parse(&read_text(path)?, path)
}

/// Parses the value in `text`, with its unknown keys in the form `gps.latency`; `path` names it in messages. A date
/// reaches its key's type as text.
///
/// # Errors
/// [`TomlError::Text`] if the text is not TOML, or a value has the wrong kind or is out of range.
pub fn parse<T: DeserializeOwned>(text: &str, path: &Path) -> Result<(T, Vec<String>), TomlError> {
    let table = parse_table(text, path)?;
    from_table(table).map_err(|error| error.in_text(text, path))
}

/// Parses the table in `text`; `path` names it in messages.
///
/// # Errors
/// [`TomlError::Text`] if the text is not TOML.
pub fn parse_table(text: &str, path: &Path) -> Result<Table, TomlError> {
    text.parse().map_err(|error| TomlError::of(path, text, &error))
}

/// Converts `table` to a value, with its unknown keys.
///
/// # Errors
/// [`ValueError`] if a value has the wrong kind or is out of range.
pub fn from_table<T: DeserializeOwned>(table: Table) -> Result<(T, Vec<String>), ValueError> {
    let mut unknown = Vec::new();
    let value = toml::Value::Table(table);
    let parsed = T::deserialize(ValueDeserializer::new(&value, &mut unknown))?;
    Ok((parsed, unknown))
}

/// `value` as a TOML document.
///
/// # Errors
/// A value that TOML cannot represent, such as a list with `None` in it.
pub fn to_string<T: Serialize + ?Sized>(value: &T) -> Result<String, toml::ser::Error> {
    toml::to_string(&Recording::of(value)?)
}

/// `value` as a TOML value.
///
/// # Errors
/// As [`to_string`]; also an integer above 2⁶³ − 1, and a map whose keys are not text.
pub fn to_value<T: Serialize + ?Sized>(value: &T) -> Result<toml::Value, toml::ser::Error> {
    toml::Value::try_from(Recording::of(value)?)
}

/// `base` with the values of `table`: tables are merged key by key, all other values are replaced.
///
/// # Errors
/// [`ValueError`] as in [`from_table`], and for values that TOML cannot represent.
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

/// A value of the wrong kind or out of range: its key, with found and expected values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValueError {
    message: String,
    place: Vec<Place>,
}

impl std::error::Error for ValueError {}

impl ValueError {
    /// Error of `key`; `reason` contains found and expected values.
    #[must_use]
    pub fn of_key(key: &str, reason: &str) -> Self {
        <Self as serde::de::Error>::custom(reason).below(key)
    }

    /// This error for a value below `key`: `key` is added to the path of the value.
    #[must_use]
    pub fn below(mut self, key: &str) -> Self {
        self.place.push(Place::Key(key.to_owned()));
        self
    }

    /// This error with its line in `text`, the contents of the file `path`, from which the value was read.
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

/// Byte offset in `text` of the value of the outermost key `key`; 0 without that key.
#[must_use]
pub fn offset_of_key(text: &str, key: &str) -> usize {
    offset_of(text, &[Place::Key(key.to_owned())]).unwrap_or(0)
}

/// Byte offset in `text` of the value at the path `place`, which begins with the innermost key.
fn offset_of(text: &str, place: &[Place]) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let (mut start, mut value) = (0, &DeValue::Table(document.into_inner()));
    for step in place.iter().rev() {
        let next = match (value, step) {
            (DeValue::Table(table), Place::Key(key)) => table.get(key.as_str()),
            (DeValue::Array(list), Place::Index(index)) => list.get(*index),
            _ => None,
        };
        // The error of a missing key is reported at the table around the key.
        let Some(next) = next else { break };
        (start, value) = (next.span().start, next.get_ref());
    }
    Some(start)
}
