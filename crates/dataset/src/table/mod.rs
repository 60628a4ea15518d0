//! CSV tables of numbers, read row by row, with line and column in every error.

pub(crate) mod csv_writer;
pub(crate) mod number;
pub(crate) mod records;
pub(crate) mod remarks;

use std::cmp::Ordering;
use std::collections::HashSet;
use std::io::{self, Cursor, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use csv::ByteRecord;

use crate::error::{LogError, excerpt};
use crate::table::number::{parse_number, parse_time};
use crate::table::records::{Place, Records};
use crate::table::remarks::Remarks;
use hovernav::time::Time;
use hovernav_toml::open_file;

/// Time, s, the first column of every table.
pub const TIME: &str = "t_s";

/// Largest size of a table, bytes; larger ones are rejected. Twice the size of ten hours at 400 Hz.
pub(crate) const LARGEST_BYTES: u64 = 4 << 30;

/// A CSV file with a header row, read forward once.
///
/// Commas separate the fields, which may be quoted or padded with blanks. CR LF, a byte order mark, blank lines and
/// trailing commas are accepted.
pub(crate) struct Table {
    path: PathBuf,
    header: Vec<String>,
    is_used: Vec<bool>,
    header_line: u64,
    records: Records,
}

/// One row of a [`Table`].
pub(crate) struct Row<'a> {
    /// Line in the file, from 1.
    pub line: u64,
    path: &'a Path,
    header: &'a [String],
    record: &'a ByteRecord,
}

impl Table {
    /// Opens a file of `dir`; `None` without such a file.
    pub fn open(dir: &Path, file: &str) -> Result<Option<Self>, LogError> {
        let path = dir.join(file);
        match open_file(&path, LARGEST_BYTES) {
            Ok(file) => Self::read(path, Box::new(file.take(LARGEST_BYTES))).map(Some),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(LogError::io(&path)(error)),
        }
    }

    /// Table from `bytes`, the contents of the file `path`.
    pub fn parse(path: PathBuf, bytes: Vec<u8>) -> Result<Self, LogError> {
        Self::read(path, Box::new(Cursor::new(bytes)))
    }

    /// Table from `source`, the file `path`.
    fn read(path: PathBuf, source: Box<dyn Read + Send>) -> Result<Self, LogError> {
        let mut records = Records::new(source).map_err(LogError::io(&path))?;
        if !records.advance().map_err(LogError::io(&path))? {
            let reason = "the file is empty, expected a header row".into();
            return Err(LogError::Unusable { path, reason });
        }
        if let Some(found) = no_text(records.current().as_slice()) {
            let reason = format!("found {found}, expected a table of comma-separated text");
            return Err(LogError::Unusable { path, reason });
        }
        let line = records.line();
        let names = records.current().iter();
        let mut header: Vec<String> =
            names.map(|name| String::from_utf8_lossy(name.trim_ascii()).into_owned()).collect();
        while header.last().is_some_and(String::is_empty) {
            header.pop();
        }
        let mut seen = HashSet::new();
        let expected = if header.iter().all(|name| parse_number(name.as_bytes()).is_some()) {
            Some("a header row of column names".into())
        } else {
            let repeated = header.iter().find(|name| !name.is_empty() && !seen.insert(*name));
            repeated.map(|name| format!("column {} once", excerpt(name.as_bytes(), 40)))
        };
        if let Some(expected) = expected {
            let found = excerpt(header.join(",").as_bytes(), 200);
            return Err(LogError::Columns { path, line, expected, found });
        }
        let is_used = vec![false; header.len()];
        Ok(Self { path, header, is_used, header_line: line, records })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Start of the row that was read last.
    pub fn place(&self) -> Place {
        self.records.place()
    }

    /// Continues with the row at `place` of the same file.
    pub fn resume(&mut self, place: Place) -> Result<(), LogError> {
        let seek = || {
            let mut file = open_file(&self.path, LARGEST_BYTES)?;
            file.seek(SeekFrom::Start(place.byte))?;
            Ok(file)
        };
        let file = seek().map_err(LogError::io(&self.path))?;
        let rest = file.take(LARGEST_BYTES.saturating_sub(place.byte));
        self.records = Records::from(Box::new(rest), place);
        Ok(())
    }

    /// Indices of `names` in the header, if all are there.
    pub fn find<const N: usize>(&mut self, names: [&str; N]) -> Option<[usize; N]> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.header.iter().position(|found| found == name)?;
        }
        columns.iter().for_each(|&column| self.is_used[column] = true);
        Some(columns)
    }

    /// Lists the columns that were never requested, except those in `without_use`. Without this list, a misspelt
    /// optional column would be ignored unnoticed.
    pub fn remark_unused(&self, without_use: &[&str], remarks: &mut Remarks) {
        let unused: Vec<&str> = self
            .header
            .iter()
            .zip(&self.is_used)
            .filter(|(name, is_used)| {
                !**is_used && !name.is_empty() && !without_use.contains(&name.as_str())
            })
            .map(|(name, _)| name.as_str())
            .collect();
        if !unused.is_empty() {
            let unused = excerpt(unused.join(", ").as_bytes(), 200);
            remarks.say(format!("columns without use: {unused}"));
        }
    }

    /// Indices of `names` in the header, or an error with the missing ones.
    pub fn require<const N: usize>(&mut self, names: [&str; N]) -> Result<[usize; N], LogError> {
        self.find(names).ok_or_else(|| {
            let missing =
                names.iter().filter(|name| !self.header.iter().any(|found| found == *name));
            self.columns_missing(&missing.copied().collect::<Vec<_>>().join(", "))
        })
    }

    /// Error of a header without the columns `expected`.
    pub fn columns_missing(&self, expected: &str) -> LogError {
        LogError::Columns {
            path: self.path.clone(),
            line: self.header_line,
            expected: format!("column {expected}"),
            found: excerpt(self.header.join(",").as_bytes(), 200),
        }
    }

    /// The next row with as many fields as the header; those with more or fewer are skipped.
    pub fn next(&mut self, remarks: &mut Remarks) -> Result<Option<Row<'_>>, LogError> {
        while self.records.advance().map_err(LogError::io(&self.path))? {
            if self.records.current().iter().all(is_blank) {
                continue;
            }
            if let Some(fault) = self.fault() {
                remarks.count(fault, self.records.line());
                continue;
            }
            let Self { path, header, records, .. } = self;
            let (line, record) = (records.line(), records.current());
            return Ok(Some(Row { line, path, header, record }));
        }
        Ok(None)
    }

    /// Reason why the current record is not a row of this table.
    fn fault(&self) -> Option<&'static str> {
        let record = self.records.current();
        let ends_in_number = || record.iter().next_back().is_none_or(|f| parse_number(f).is_some());
        let is_name = |(name, field): (&String, &[u8])| name.as_bytes() == field.trim_ascii();
        if self.header.iter().zip(record).all(is_name) && record.len() >= self.header.len() {
            return Some("skipped: repeats the header");
        }
        match record.len().cmp(&self.header.len()) {
            Ordering::Less => Some("skipped: fewer fields than the header"),
            Ordering::Greater if !record.iter().skip(self.header.len()).all(is_blank) => {
                Some("skipped: more fields than the header")
            }
            _ if self.records.is_cut_off() && !ends_in_number() => {
                Some("skipped: cut off at the end of the file")
            }
            _ => None,
        }
    }
}

/// Name of the content of a file that begins with `head` and is not text.
fn no_text(head: &[u8]) -> Option<&'static str> {
    let is_control = |byte: &u8| *byte < b' ' && !byte.is_ascii_whitespace();
    match head {
        [0x1F, 0x8B, ..] => Some("a gzip file (unpack it first)"),
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => Some("text in UTF-16 (save it as UTF-8 first)"),
        _ => head.iter().any(is_control).then_some("binary data"),
    }
}

fn is_blank(field: &[u8]) -> bool {
    field.trim_ascii().is_empty()
}

impl Row<'_> {
    /// The number in `column`; NaN for an empty field or `nan`.
    pub fn number(&self, column: usize) -> Result<f64, LogError> {
        let field = self.field(column);
        parse_number(field).ok_or_else(|| self.unexpected(column, "a number"))
    }

    /// The numbers in `columns`.
    pub fn numbers<const N: usize>(&self, columns: [usize; N]) -> Result<[f64; N], LogError> {
        let mut numbers = [0.0; N];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = self.number(column)?;
        }
        Ok(numbers)
    }

    /// The numbers in `columns`, if the table has these columns and all numbers are finite.
    pub fn finite<const N: usize>(
        &self,
        columns: Option<[usize; N]>,
    ) -> Result<Option<[f64; N]>, LogError> {
        let Some(columns) = columns else { return Ok(None) };
        let numbers = self.numbers(columns)?;
        Ok(numbers.iter().all(|number| number.is_finite()).then_some(numbers))
    }

    /// The time in `column`, seconds to the nearest nanosecond; `None` if it is unknown or out of the range of a clock.
    pub fn time(&self, column: usize) -> Result<Option<Time>, LogError> {
        let field = self.field(column);
        parse_time(field).ok_or_else(|| self.unexpected(column, "a time in seconds"))
    }

    fn field(&self, column: usize) -> &[u8] {
        self.record.get(column).unwrap_or_default()
    }

    fn unexpected(&self, column: usize, expected: &'static str) -> LogError {
        LogError::Field {
            path: self.path.to_path_buf(),
            line: self.line,
            column: self.header.get(column).cloned().unwrap_or_default(),
            found: excerpt(self.field(column), 40),
            expected,
        }
    }
}

/// Approximate number of rows of the table `path`; zero if it cannot be read.
pub(crate) fn rows_of(path: &Path) -> u64 {
    const HEAD: u64 = 1 << 16;
    let read = || -> io::Result<u64> {
        // Opening a pipe would wait for its writer.
        let (file, mut head) = (open_file(path, LARGEST_BYTES)?, Vec::new());
        let length = file.metadata()?.len();
        file.take(HEAD).read_to_end(&mut head)?;
        let rows = head.iter().filter(|byte| **byte == b'\n').count() as u64;
        Ok(if head.is_empty() { 0 } else { rows * length / head.len() as u64 })
    };
    read().unwrap_or(0)
}
