//! CSV files of numbers; a file gets its name only when it is complete.

use std::io::{self, Write as _};
use std::path::PathBuf;

use crate::error::LogError;
use hovernav::time::Time;
use hovernav_toml::WholeFile;

/// Bytes buffered before a write.
const CHUNK: usize = 1 << 20;

/// A CSV file being written. Numbers that are not finite are rejected.
pub(crate) struct CsvWriter {
    path: PathBuf,
    columns: Vec<&'static str>,
    /// Bytes not yet written.
    bytes: Vec<u8>,
    /// File with the bytes already written, if there are more than [`CHUNK`].
    part: Option<WholeFile>,
    /// Error of an earlier write.
    failure: Option<io::Error>,
    row: usize,
    column: usize,
}

impl CsvWriter {
    /// Starts a file with a header of `columns`.
    pub fn new(path: PathBuf, columns: &[&'static str]) -> Self {
        let mut bytes = columns.join(",").into_bytes();
        bytes.push(b'\n');
        Self {
            path,
            columns: columns.to_vec(),
            bytes,
            part: None,
            failure: None,
            row: 1,
            column: 0,
        }
    }

    /// Writes a time in seconds, with as many decimals as needed.
    pub fn time(&mut self, time: Time) {
        const PER_SECOND: u64 = 1_000_000_000;
        let nanoseconds = time.nanoseconds().unsigned_abs();
        if time < Time::ZERO {
            self.bytes.push(b'-');
        }
        let (mut fraction, mut decimals) = (nanoseconds % PER_SECOND, 9);
        while decimals > 0 && fraction % 10 == 0 {
            fraction /= 10;
            decimals -= 1;
        }
        push_decimal(
            &mut self.bytes,
            nanoseconds / PER_SECOND * TEN_TO[decimals] + fraction,
            decimals,
        );
        self.end_field();
    }

    /// Writes a number in the fewest digits that read back as the same number.
    pub fn shortest(&mut self, value: f64) -> Result<(), LogError> {
        if !value.is_finite() {
            return Err(self.unwritable(value));
        }
        self.bytes.extend_from_slice(zmij::Buffer::new().format_finite(value).as_bytes());
        self.end_field();
        Ok(())
    }

    /// Writes each of `values` in the fewest digits; empty fields for `None`.
    pub fn shortest_or_empty<const N: usize>(
        &mut self,
        values: Option<[f64; N]>,
    ) -> Result<(), LogError> {
        match values {
            Some(values) => values.into_iter().try_for_each(|value| self.shortest(value)),
            None => {
                (0..N).for_each(|_| self.end_field());
                Ok(())
            }
        }
    }

    /// Writes a number with a fixed count of `decimals`, at most 10.
    pub fn fixed(&mut self, value: f64, decimals: usize) -> Result<(), LogError> {
        self.fixed_units(self.in_units(value, decimals)?, decimals);
        Ok(())
    }

    /// Writes each of `values` with a fixed count of `decimals`, at most 10.
    pub fn fixed_each(&mut self, values: [f64; 3], decimals: usize) -> Result<(), LogError> {
        values.into_iter().try_for_each(|value| self.fixed(value, decimals))
    }

    /// Writes an angle in (−180, 180] with a fixed count of `decimals`, at most 10; a value that rounds to −180 is
    /// written as 180.
    pub fn fixed_angle_deg(&mut self, angle_deg: f64, decimals: usize) -> Result<(), LogError> {
        let units = self.in_units(angle_deg, decimals)?;
        let half_turn = 180 * TEN_TO[decimals] as i64;
        self.fixed_units(if units == -half_turn { half_turn } else { units }, decimals);
        Ok(())
    }

    /// Ends the row.
    pub fn end_row(&mut self) {
        debug_assert_eq!(self.column, self.columns.len());
        if let Some(last) = self.bytes.last_mut() {
            *last = b'\n';
        }
        self.row += 1;
        self.column = 0;
        if self.bytes.len() >= CHUNK && self.failure.is_none() {
            self.failure = self.write_part().err();
        }
    }

    /// Writes the remaining bytes and gives the file its name.
    pub fn finish(mut self) -> Result<(), LogError> {
        let written = match self.failure.take() {
            Some(failure) => Err(failure),
            None => self.write_part().and_then(|()| match self.part.take() {
                Some(part) => part.finish(),
                None => Ok(()),
            }),
        };
        written.map_err(LogError::io(&self.path))
    }

    fn write_part(&mut self) -> io::Result<()> {
        let part = match &mut self.part {
            Some(part) => part,
            none => none.insert(WholeFile::create(&self.path)?),
        };
        part.write_all(&self.bytes)?;
        self.bytes.clear();
        Ok(())
    }

    /// `value` in units of its last decimal place.
    fn in_units(&self, value: f64, decimals: usize) -> Result<i64, LogError> {
        let units = value * TEN_TO[decimals] as f64;
        // This form of the comparison rejects NaN too.
        if units.abs() < 9e18 {
            Ok((units + 0.5f64.copysign(units)) as i64)
        } else {
            Err(self.unwritable(value))
        }
    }

    fn fixed_units(&mut self, units: i64, decimals: usize) {
        if units < 0 {
            self.bytes.push(b'-');
        }
        push_decimal(&mut self.bytes, units.unsigned_abs(), decimals);
        self.end_field();
    }

    fn end_field(&mut self) {
        self.bytes.push(b',');
        self.column += 1;
    }

    fn unwritable(&self, value: f64) -> LogError {
        let column = self.columns.get(self.column).copied().unwrap_or_default();
        LogError::Unwritable { path: self.path.clone(), row: self.row, column, value }
    }
}

const TEN_TO: [u64; 11] = {
    let mut powers = [1; 11];
    let mut exponent = 1;
    while exponent < powers.len() {
        powers[exponent] = 10 * powers[exponent - 1];
        exponent += 1;
    }
    powers
};

/// Appends a number to `out` as text: `units` of the last of `decimals` places.
fn push_decimal(out: &mut Vec<u8>, mut units: u64, decimals: usize) {
    let mut digits = [b'0'; 21];
    let mut start = digits.len();
    let mut push = |digit: u8| {
        start -= 1;
        digits[start] = digit;
    };
    for _ in 0..decimals {
        push(b'0' + (units % 10) as u8);
        units /= 10;
    }
    if decimals > 0 {
        push(b'.');
    }
    loop {
        push(b'0' + (units % 10) as u8);
        units /= 10;
        if units == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[start..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_file_appears_whole_or_not_at_all() {
        let place = std::env::temp_dir().join(format!("hovernav-csv-{}", std::process::id()));
        std::fs::create_dir_all(&place).unwrap();
        let path = place.join("long.csv");
        let files = || std::fs::read_dir(&place).unwrap().count();
        for last in [1.0, f64::NAN] {
            let mut csv = CsvWriter::new(path.clone(), &["a", "b"]);
            for row in 0..200_000 {
                csv.shortest(f64::from(row)).unwrap();
                csv.fixed(0.25, 3).unwrap();
                csv.end_row();
            }
            assert_eq!(files(), 1, "one part, and nothing under the file's own name");
            if csv.shortest(last).is_ok() {
                csv.fixed(0.25, 3).unwrap();
                csv.end_row();
                csv.finish().unwrap();
                let text = std::fs::read_to_string(&path).unwrap();
                assert_eq!(text.lines().count(), 200_002);
                assert!(text.starts_with("a,b\n0.0,0.250\n") && text.ends_with("\n1.0,0.250\n"));
                std::fs::remove_file(&path).unwrap();
            } else {
                drop(csv);
            }
            assert_eq!(files(), 0);
        }
        std::fs::remove_dir(&place).unwrap();
    }
}
