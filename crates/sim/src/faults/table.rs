//! A CSV file with individual changes: every unchanged field keeps its bytes.

use std::io::{self, Write as _};
use std::path::Path;
use std::sync::Arc;

use hovernav_dataset::LogError;
use hovernav_toml::{open_file, write_whole};

use super::window::Window;

/// The text of the regular file at `path`. A pipe, which could block forever, is rejected.
pub(super) fn read_text(path: &Path) -> io::Result<String> {
    open_file(path, u64::MAX).and_then(io::read_to_string)
}

/// A table and its changes. Rows whose number of fields differs from the header are never changed.
#[derive(Clone, Debug)]
pub(super) struct Table {
    original: Arc<Original>,
    /// Values row by row; NaN where a field is empty or not a number.
    values: Vec<f64>,
    dropped: Vec<bool>,
}

/// The file as read.
#[derive(Debug)]
struct Original {
    header: String,
    names: Vec<String>,
    lines: Vec<String>,
    values: Vec<f64>,
}

impl Table {
    /// Reads the file at `path`; `None` if it does not exist.
    pub fn read(path: &Path) -> Result<Option<Self>, LogError> {
        match read_text(path) {
            Ok(text) => Ok(Self::parse(&text)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(LogError::Io { path: path.to_path_buf(), source }),
        }
    }

    pub fn parse(text: &str) -> Option<Self> {
        let mut lines = text.split_inclusive('\n');
        let header = lines.next()?.to_owned();
        let name = |field: &str| field.trim_matches(BLANK).trim_matches(BLANK).to_owned();
        let names: Vec<String> = header.split(',').map(name).collect();
        let lines: Vec<String> = lines.map(str::to_owned).collect();
        let mut values = Vec::with_capacity(names.len() * lines.len());
        for line in &lines {
            let start = values.len();
            values.extend(line.split(',').map(number));
            if values.len() - start != names.len() {
                values.truncate(start);
                values.resize(start + names.len(), f64::NAN);
            }
        }
        let dropped = vec![false; lines.len()];
        let original = Original { header, names, lines, values: values.clone() };
        Some(Self { original: Arc::new(original), values, dropped })
    }

    /// Number of rows, including dropped ones.
    pub fn len(&self) -> usize {
        self.dropped.len()
    }

    /// Index of the column `name`.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.original.names.iter().position(|found| found == name)
    }

    /// Indices of the columns `names`, if all exist.
    pub fn columns<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self.column(name)?;
        }
        Some(columns)
    }

    /// The number in a row and column.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.original.names.len() + column]
    }

    /// Three numbers of a row.
    pub fn triple(&self, row: usize, columns: [usize; 3]) -> [f64; 3] {
        columns.map(|column| self.get(row, column))
    }

    /// Sets a field to `value`; NaN empties the field.
    pub fn set(&mut self, row: usize, column: usize, value: f64) {
        self.values[row * self.original.names.len() + column] = value;
    }

    /// Changes the number in a row and column, if there is one.
    pub fn change(&mut self, row: usize, column: usize, change: impl FnOnce(f64) -> f64) {
        let value = self.get(row, column);
        if value.is_finite() {
            self.set(row, column, change(value));
        }
    }

    /// Drops a row.
    pub fn drop_row(&mut self, row: usize) {
        self.dropped[row] = true;
    }

    /// The remaining rows with an original time in `window`.
    pub fn rows_in(&self, window: Window) -> Vec<usize> {
        let Some(time) = self.column("t_s") else { return Vec::new() };
        let width = self.original.names.len();
        let is_in = |row: &usize| {
            !self.dropped[*row] && window.covers(self.original.values[row * width + time])
        };
        (0..self.len()).filter(is_in).collect()
    }

    /// First and last time of the file.
    pub fn span_s(&self) -> Option<(f64, f64)> {
        let time = self.column("t_s")?;
        let times = (0..self.len()).map(|row| self.get(row, time)).filter(|time| time.is_finite());
        let (low, high) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), time| {
            (low.min(time), high.max(time))
        });
        (low <= high).then_some((low, high))
    }

    /// Writes the table to `path`.
    pub fn write(&self, path: &Path) -> Result<(), LogError> {
        let original = &*self.original;
        let width = original.names.len();
        let mut out = original.header.clone().into_bytes();
        for (row, line) in original.lines.iter().enumerate().filter(|(row, _)| !self.dropped[*row])
        {
            let span = row * width..(row + 1) * width;
            let (now, before) = (&self.values[span.clone()], &original.values[span]);
            if now.iter().zip(before).all(|(now, before)| same(*now, *before)) {
                out.extend_from_slice(line.as_bytes());
                continue;
            }
            let end = &line[line.trim_end_matches(['\r', '\n']).len()..];
            let fields = line.trim_end_matches(['\r', '\n']).split(',');
            for (column, field) in fields.enumerate() {
                if column > 0 {
                    out.push(b',');
                }
                if same(now[column], before[column]) {
                    out.extend_from_slice(field.as_bytes());
                } else if now[column].is_finite() {
                    // Writing to a vector never fails.
                    let _ = write!(out, "{}", now[column]);
                }
            }
            out.extend_from_slice(end.as_bytes());
        }
        write_whole(path, out).map_err(|source| LogError::Io { path: path.to_path_buf(), source })
    }
}

/// Characters that may surround a field: blanks, quotes, line ends, a byte order mark.
const BLANK: [char; 6] = [' ', '\t', '\r', '\n', '"', '\u{feff}'];

fn number(field: &str) -> f64 {
    field.trim_matches(BLANK).parse().unwrap_or(f64::NAN)
}

/// Whether two fields contain the same number, or neither contains a number.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_fields_that_change_are_written_again() {
        let text = "t_s, a ,note\r\n0.10,1.500,x\r\nbroken\r\n0.20,,y\r\n0.30,2.0,z";
        let mut table = Table::parse(text).unwrap();
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.csv");
        table.write(&path).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);

        let a = table.column("a").unwrap();
        for row in table.rows_in(Window::ALL) {
            table.change(row, a, |value| value + 1.0);
        }
        table.drop_row(2);
        table.write(&path).unwrap();
        let expected = "t_s, a ,note\r\n0.10,2.5,x\r\nbroken\r\n0.30,3,z";
        assert_eq!(std::fs::read_to_string(&path).unwrap(), expected);
    }
}
