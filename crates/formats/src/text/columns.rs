//! The columns of a mapping in one file, and the values of a row in hovernav's units.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use super::decimal::{self, TimeUnit};
use super::lines::Lines;
use super::mapping::{Axes, TableMapping, TimeColumn, Triad};
use hovernav::time::Time;
use hovernav_dataset::LogError;

/// A file of rows, read forward once with its mapping.
pub(crate) struct Source {
    lines: Lines,
    table: TableMapping,
    /// Names of the columns; without names, their numbers from 1.
    names: Vec<String>,
    /// Number of rows read, for files without a time column.
    rows: u64,
    /// Column and number of the sensor whose rows are read.
    instance: Option<(usize, f64)>,
    /// Number of rows of other sensors that were skipped.
    others: u64,
}

/// The fields of one row.
pub(crate) struct Fields<'a> {
    pub line: u64,
    path: &'a Path,
    names: &'a [String],
    fields: Vec<&'a [u8]>,
    decimal_comma: bool,
    row: u64,
    /// Index of the first column with a word instead of a number.
    word: Cell<Option<usize>>,
}

impl Source {
    /// Opens the file of `table`, whose path is relative to `directory`.
    ///
    /// # Errors
    /// [`LogError`] if the file cannot be read or ends before the line of names.
    pub fn open(directory: &Path, table: &TableMapping) -> Result<Self, LogError> {
        let path: PathBuf = directory.join(&table.file);
        let mut lines = Lines::open(&path)?;
        let mut names = Vec::new();
        while lines.number() < table.header_line {
            let is_header = lines.number() + 1 == table.header_line;
            let Some(line) = lines.next()? else {
                let reason = format!(
                    "ends before line {}, expected the column names there",
                    table.header_line
                );
                return Err(LogError::Unusable { path, reason });
            };
            if is_header {
                names = super::layout::header_names(line, table.delimiter);
            }
        }
        let table = table.clone();
        let mut source = Self { lines, table, names, rows: 0, instance: None, others: 0 };
        let column = source.find_optional(&source.table.instance_column)?;
        source.instance = column.zip(source.table.instance.map(f64::from));
        Ok(source)
    }

    pub fn path(&self) -> &Path {
        self.lines.path()
    }

    /// Number of skipped rows of sensors other than the one that is read.
    pub const fn others(&self) -> u64 {
        self.others
    }

    /// Zero bytes: see [`Lines::unwritten`].
    pub fn unwritten(&self) -> Option<(u64, u64)> {
        self.lines.unwritten()
    }

    /// The index of the column `name`; `name` is the column's number, from 1, in a file without names.
    ///
    /// # Errors
    /// [`LogError::Columns`] if the column is missing.
    pub fn find(&self, name: &str) -> Result<usize, LogError> {
        let found = if self.table.header_line == 0 {
            name.parse().ok().and_then(|number: usize| number.checked_sub(1))
        } else {
            self.names.iter().position(|found| found == name)
        };
        found.ok_or_else(|| LogError::Columns {
            path: self.path().to_path_buf(),
            line: self.table.header_line.max(1),
            expected: format!("column {name}"),
            found: self.names.join(" ").chars().take(200).collect(),
        })
    }

    /// The index of the column `name`; `None` if `name` is empty.
    pub fn find_optional(&self, name: &str) -> Result<Option<usize>, LogError> {
        if name.is_empty() { Ok(None) } else { self.find(name).map(Some) }
    }

    /// The indices of a triad's columns.
    pub fn find_triad<U>(&self, triad: &Triad<U>) -> Result<[usize; 3], LogError> {
        self.find_three(&triad.columns)
    }

    /// The indices of three columns.
    pub fn find_three(&self, [x, y, z]: &[String; 3]) -> Result<[usize; 3], LogError> {
        Ok([self.find(x)?, self.find(y)?, self.find(z)?])
    }

    /// The next row that is not a comment; `None` at the end.
    pub fn next(&mut self) -> Result<Option<Fields<'_>>, LogError> {
        // The line is split after the loop because its borrow cannot cross an iteration.
        loop {
            let Some(line) = self.lines.next()? else { return Ok(None) };
            if super::layout::is_comment(line) || line.trim_ascii().is_empty() {
                continue;
            }
            let Some((column, wanted)) = self.instance else { break };
            let mut fields = Vec::new();
            self.table.delimiter.split(line, &mut fields);
            let field = fields.get(column).copied().unwrap_or_default();
            let found = decimal::number(field, self.table.decimal_comma);
            if found.is_none_or(|found| found == wanted) {
                break;
            }
            self.others += 1;
        }
        self.rows += 1;
        let mut fields = Vec::with_capacity(self.names.len().max(8));
        self.table.delimiter.split(self.lines.current(), &mut fields);
        Ok(Some(Fields {
            line: self.lines.number(),
            path: self.lines.path(),
            names: &self.names,
            fields,
            decimal_comma: self.table.decimal_comma,
            row: self.rows - 1,
            word: Cell::new(None),
        }))
    }
}

impl Fields<'_> {
    /// The number in `column`; NaN if the field is empty, missing or a word.
    ///
    /// # Errors
    /// [`LogError::Field`] for other text that is not a number.
    pub fn number(&self, column: usize) -> Result<f64, LogError> {
        let Some(field) = self.fields.get(column) else { return Ok(f64::NAN) };
        match decimal::number(field, self.decimal_comma) {
            Some(number) => Ok(number),
            None if decimal::is_word(field) => {
                self.word.set(self.word.get().or(Some(column)));
                Ok(f64::NAN)
            }
            None => Err(self.unexpected(column, "a number")),
        }
    }

    /// Error on the first word that was read instead of a number.
    pub fn word(&self) -> Option<LogError> {
        self.word.get().map(|column| self.unexpected(column, "a number"))
    }

    /// Type of the fix: see [`decimal::fix_type`].
    pub fn fix_type(&self, column: Option<usize>) -> f64 {
        let field = column.and_then(|column| self.fields.get(column));
        field.map_or(f64::NAN, |field| decimal::fix_type(field))
    }

    /// The number in `column`, if it is finite.
    pub fn known(&self, column: Option<usize>) -> Result<Option<f64>, LogError> {
        let Some(column) = column else { return Ok(None) };
        Ok(Some(self.number(column)?).filter(|number| number.is_finite()))
    }

    /// 1 if `column` contains the letter `plus`, −1 if it contains `minus`, `None` if it is empty. Capital and small
    /// letters are equal.
    ///
    /// # Errors
    /// [`LogError::Field`] for any other text, with `expected` in the message.
    pub fn sign(
        &self,
        column: usize,
        [plus, minus]: [u8; 2],
        expected: &'static str,
    ) -> Result<Option<f64>, LogError> {
        match self.fields.get(column).copied().unwrap_or_default() {
            [] => Ok(None),
            [letter] if letter.eq_ignore_ascii_case(&plus) => Ok(Some(1.0)),
            [letter] if letter.eq_ignore_ascii_case(&minus) => Ok(Some(-1.0)),
            _ => Err(self.unexpected(column, expected)),
        }
    }

    /// The numbers in `columns`; NaN for empty or missing fields.
    pub fn numbers<const N: usize>(&self, columns: [usize; N]) -> Result<[f64; N], LogError> {
        let mut numbers = [0.0; N];
        for (number, column) in numbers.iter_mut().zip(columns) {
            *number = self.number(column)?;
        }
        Ok(numbers)
    }

    /// The numbers in `columns`, if all are finite.
    pub fn known_all<const N: usize>(
        &self,
        columns: [usize; N],
    ) -> Result<Option<[f64; N]>, LogError> {
        let numbers = self.numbers(columns)?;
        Ok(numbers.iter().all(|number| number.is_finite()).then_some(numbers))
    }

    /// The vector in `columns`, multiplied by `factor` and converted to body axes.
    pub fn triad(
        &self,
        columns: [usize; 3],
        factor: f64,
        axes: Axes,
    ) -> Result<Option<[f64; 3]>, LogError> {
        let values = self.known_all(columns)?;
        Ok(values.map(|values| axes.turned(values).map(|value| value * factor)))
    }

    /// The time of the row on the file's own scale, from `column`, or from a count and its rate. Without a column, the
    /// count is the number of the row.
    pub fn time(&self, column: Option<usize>, time: &TimeColumn) -> Result<Option<Time>, LogError> {
        match (column, time.rate_hz) {
            (Some(column), Some(rate_hz)) if time.unit == TimeUnit::Count => {
                let count = self.known(Some(column))?;
                Ok(count.and_then(|count| Time::try_from_seconds(count / rate_hz)))
            }
            (Some(column), _) => {
                let Some(field) = self.fields.get(column) else { return Ok(None) };
                decimal::time(field, time.unit, self.decimal_comma)
                    .ok_or_else(|| self.unexpected(column, "a time"))
            }
            (None, Some(rate_hz)) => Ok(Time::try_from_seconds(self.row as f64 / rate_hz)),
            (None, None) => Ok(None),
        }
    }

    /// The midnight at which the date in `column` began.
    ///
    /// # Errors
    /// [`LogError::Field`] for text that is not a date.
    pub fn midnight(&self, column: usize) -> Result<Option<Time>, LogError> {
        let field = self.fields.get(column).copied().unwrap_or_default();
        decimal::midnight(field).ok_or_else(|| self.unexpected(column, "a date"))
    }

    fn unexpected(&self, column: usize, expected: &'static str) -> LogError {
        let found = self.fields.get(column).copied().unwrap_or_default();
        let found: String = String::from_utf8_lossy(&found[..found.len().min(160)])
            .escape_debug()
            .take(40)
            .collect();
        let name = self.names.get(column).cloned();
        LogError::Field {
            path: self.path.to_path_buf(),
            line: self.line,
            column: name.unwrap_or_else(|| (column + 1).to_string()),
            found,
            expected,
        }
    }
}
