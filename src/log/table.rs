//! A table of numbers in a CSV file, row by row, with errors that name line and column.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use csv::{ByteRecord, ReaderBuilder};

use super::error::{LogError, excerpt};
use super::number::{parse_number, parse_time};
use super::remarks::Remarks;
use crate::time::Time;

/// A CSV file in memory, read forward once.
///
/// Commas part the fields, which may be quoted or padded with blanks; CR LF, a byte order mark, blank
/// lines and trailing commas are tolerated.
pub(super) struct Table {
    path: PathBuf,
    header: Vec<String>,
    is_used: Vec<bool>,
    header_line: u64,
    reader: csv::Reader<std::io::Cursor<Vec<u8>>>,
    record: ByteRecord,
    length: u64,
    ends_in_newline: bool,
}

/// One row of a [`Table`].
pub(super) struct Row<'a> {
    /// Line in the file, from 1.
    pub line: u64,
    path: &'a Path,
    header: &'a [String],
    record: &'a ByteRecord,
}

impl Table {
    /// Opens a file of `dir`; `None` where there is no such file.
    pub fn open(dir: &Path, file: &str) -> Result<Option<Self>, LogError> {
        let path = dir.join(file);
        match std::fs::read(&path) {
            Ok(bytes) => Self::parse(path, bytes).map(Some),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(LogError::io(&path)(error)),
        }
    }

    fn parse(path: PathBuf, mut bytes: Vec<u8>) -> Result<Self, LogError> {
        if bytes.starts_with(b"\xef\xbb\xbf") {
            bytes.drain(..3);
        }
        let length = bytes.len() as u64;
        let ends_in_newline = matches!(bytes.last(), Some(b'\n' | b'\r'));
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .from_reader(std::io::Cursor::new(bytes));
        let mut record = ByteRecord::new();
        let found = reader.read_byte_record(&mut record);
        if !found.map_err(|error| LogError::io(&path)(error.into()))? {
            return Err(LogError::Unusable {
                path,
                reason: "the file is empty, expected a header row".into(),
            });
        }
        let header_line = record.position().map_or(1, csv::Position::line);
        let mut header: Vec<String> = record
            .iter()
            .map(|name| String::from_utf8_lossy(name.trim_ascii()).into_owned())
            .collect();
        while header.last().is_some_and(String::is_empty) {
            header.pop();
        }
        let mut seen = HashSet::new();
        let repeated = header.iter().find(|name| !name.is_empty() && !seen.insert(name.as_str()));
        let expected = match repeated {
            _ if header.iter().all(|name| parse_number(name.as_bytes()).is_some()) => {
                "a header row of column names".into()
            }
            Some(name) => format!("column {} once", excerpt(name.as_bytes(), 40)),
            None => String::new(),
        };
        if !expected.is_empty() {
            let found = excerpt(header.join(",").as_bytes(), 200);
            return Err(LogError::Columns { path, line: header_line, expected, found });
        }
        let is_used = vec![false; header.len()];
        Ok(Self { path, header, is_used, header_line, reader, record, length, ends_in_newline })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The places of `names` in the header if all are there.
    pub fn find<const N: usize>(&mut self, names: [&str; N]) -> Option<[usize; N]> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.header.iter().position(|found| found == name)?;
        }
        columns.iter().for_each(|&column| self.is_used[column] = true);
        Some(columns)
    }

    /// Says which columns were never asked for, those named in `without_use` apart: an optional
    /// column with a slip in its name would otherwise vanish unnoticed.
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

    /// The places of `names` in the header, or which of them are missing.
    pub fn require<const N: usize>(&mut self, names: [&str; N]) -> Result<[usize; N], LogError> {
        self.find(names).ok_or_else(|| {
            let missing =
                names.iter().filter(|name| !self.header.iter().any(|found| found == *name));
            self.columns_missing(&missing.copied().collect::<Vec<_>>().join(", "))
        })
    }

    /// The error of a header without the columns `expected`.
    pub fn columns_missing(&self, expected: &str) -> LogError {
        LogError::Columns {
            path: self.path.clone(),
            line: self.header_line,
            expected: format!("column {expected}"),
            found: excerpt(self.header.join(",").as_bytes(), 200),
        }
    }

    /// The next row with as many fields as the header, those with more or fewer left out.
    pub fn next(&mut self, remarks: &mut Remarks) -> Result<Option<Row<'_>>, LogError> {
        loop {
            let found = self.reader.read_byte_record(&mut self.record);
            if !found.map_err(|error| LogError::io(&self.path)(error.into()))? {
                return Ok(None);
            }
            let line = self.record.position().map_or(0, csv::Position::line);
            let columns = self.header.len();
            let is_blank = |field: &[u8]| field.trim_ascii().is_empty();
            if self.record.len() != columns {
                if self.record.iter().all(is_blank) {
                    continue;
                }
                if self.record.len() < columns {
                    remarks.count("left out: fewer fields than the header", line);
                    continue;
                }
                if !self.record.iter().skip(columns).all(is_blank) {
                    remarks.count("left out: more fields than the header", line);
                    continue;
                }
            }
            if !self.ends_in_newline
                && self.reader.position().byte() >= self.length
                && self.record.iter().next_back().is_some_and(|last| parse_number(last).is_none())
            {
                remarks.count("left out: cut off at the end of the file", line);
                continue;
            }
            let Self { path, header, record, .. } = self;
            return Ok(Some(Row { line, path, header, record }));
        }
    }
}

impl Row<'_> {
    /// The number in `column`; NaN where the field is empty or says so.
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

    /// The numbers in `columns`, if the table has them and all are finite.
    pub fn finite<const N: usize>(
        &self,
        columns: Option<[usize; N]>,
    ) -> Result<Option<[f64; N]>, LogError> {
        let Some(columns) = columns else { return Ok(None) };
        let numbers = self.numbers(columns)?;
        Ok(numbers.iter().all(|number| number.is_finite()).then_some(numbers))
    }

    /// The time in `column`, seconds to the nearest nanosecond; `None` where it is unknown or beyond
    /// what a clock can show.
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
