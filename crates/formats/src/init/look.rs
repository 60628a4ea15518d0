//! The first rows of a file's columns, as numbers.

use std::path::Path;

use crate::format::Format;
use crate::recognise::{format_of, head_of, is_text, is_unmappable, looks_like};
use crate::text::{Delimiter, Layout, Lines, TimeUnit, decimal, is_comment};
use hovernav_dataset::statistics::quantile;
use hovernav_dataset::{LogError, is_unknown_velocity};

/// Number of rows that are examined.
const ROWS: usize = 20_000;
/// Number of columns that are examined; no flight logger writes more.
const COLUMNS: usize = 400;

/// The first rows of a file, column by column; NaN for fields that are not numbers.
pub(crate) struct Look {
    pub layout: Layout,
    pub columns: Vec<Vec<f64>>,
    /// The column of full seconds whose next column has the nanoseconds after them. It contains both.
    pub stamp: Option<usize>,
    /// Whether a column contains dates or times of day, converted to seconds in `columns`.
    pub are_clock: Vec<bool>,
    /// The single letters in a column, in capitals, without repetition.
    letters: Vec<Vec<u8>>,
    /// Whether every non-empty field of a column is a date.
    pub are_dates: Vec<bool>,
    /// The unit after the first number of each column; empty for numbers without a unit.
    pub cell_units: Vec<String>,
    /// Whether a column contains types of fixes, as numbers or words.
    pub are_fix_types: Vec<bool>,
    /// Whether a column contains numbers with a superfluous leading zero, such as 0807.038.
    pub are_padded: Vec<bool>,
}

impl Look {
    pub fn at(path: &Path) -> Result<Self, LogError> {
        ensure_text(path)?;
        let layout = Layout::of(path)?;
        let count = layout.names.len().min(COLUMNS);
        let mut look = Self {
            columns: vec![Vec::new(); count],
            are_clock: vec![false; count],
            letters: vec![Vec::new(); count],
            are_dates: vec![true; count],
            are_fix_types: vec![false; count],
            are_padded: vec![false; count],
            cell_units: vec![String::new(); count],
            stamp: None,
            layout,
        };
        let mut lines = Lines::open(path)?;
        while look.columns.first().is_some_and(|column| column.len() < ROWS)
            && let Some(line) = lines.next()?
        {
            let line = line.to_vec();
            if lines.number() > look.layout.header_line && !is_comment(&line) {
                look.take(&line, look.layout.delimiter);
            }
        }
        look.columns.iter_mut().for_each(|column| forget_unknown(column));
        look.join_stamp();
        Ok(look)
    }

    /// Adds nanoseconds to the full seconds in the column before, as in the stamps of ROS: by name, otherwise seconds
    /// since 1970 next to whole numbers that range widely below 10⁹.
    fn join_stamp(&mut self) {
        const EPOCHS: std::ops::Range<f64> = 9.4e8..4.1e9;
        const MIN_SPREAD: f64 = 1e8;
        let is_named = self.layout.header_line > 0;
        let is_stamp = |at: &usize| {
            let [least, most] = self.range(at + 1);
            let [before, name] = [*at, at + 1].map(|at| self.layout.names[at].to_lowercase());
            // The name of a frame follows in ROS.
            let is_before_frame =
                self.columns.get(at + 2).is_some() && self.known(at + 2).next().is_none();
            self.is_whole(*at)
                && self.is_whole(at + 1)
                && least >= 0.0
                && most < 1e9
                && match is_named {
                    true => {
                        before.contains("sec") && (name.contains("nano") || name.contains("nsec"))
                    }
                    false => {
                        (most - least > MIN_SPREAD || is_before_frame)
                            && self.known(*at).all(|second| EPOCHS.contains(&second))
                    }
                }
        };
        self.stamp = (0..self.columns.len().saturating_sub(1)).find(is_stamp);
        if let Some(at) = self.stamp {
            let (seconds, after) = self.columns.split_at_mut(at + 1);
            let pairs = seconds[at].iter_mut().zip(&after[0]);
            pairs.for_each(|(second, nanoseconds)| *second += 1e-9 * nanoseconds);
        }
    }

    fn take(&mut self, line: &[u8], delimiter: Delimiter) {
        let mut fields = Vec::new();
        delimiter.split(line, &mut fields);
        if fields.iter().all(|field| field.is_empty()) {
            return;
        }
        for (index, column) in self.columns.iter_mut().enumerate() {
            let field = fields.get(index).copied().unwrap_or_default();
            let number = decimal::number(field, self.layout.decimal_comma);
            let clock = || {
                let time = decimal::time(field, TimeUnit::Clock, false).flatten()?;
                self.are_clock[index] = true;
                Some(time.seconds())
            };
            column.push(number.or_else(clock).unwrap_or(f64::NAN));
            if self.cell_units[index].is_empty()
                && let Some((_, unit)) =
                    std::str::from_utf8(field).ok().and_then(decimal::with_unit)
            {
                self.cell_units[index] = unit.to_owned();
            }
            self.are_dates[index] &= decimal::midnight(field).is_some();
            self.are_fix_types[index] |= decimal::fix_type(field).is_finite();
            self.are_padded[index] |= matches!(field, [b'0', b'0'..=b'9', ..]);
            if let [letter] = field
                && letter.is_ascii_alphabetic()
                && !self.letters[index].contains(&letter.to_ascii_uppercase())
            {
                self.letters[index].push(letter.to_ascii_uppercase());
            }
        }
    }

    /// Keeps the rows with `value` in `column`.
    pub fn keep_rows_of(&mut self, column: usize, value: f64) {
        let is_kept: Vec<bool> = self.columns[column].iter().map(|found| *found == value).collect();
        for column in &mut self.columns {
            let mut kept = is_kept.iter();
            column.retain(|_| kept.next().is_some_and(|kept| *kept));
        }
    }

    /// Whether a column contains only letters of `known`.
    pub fn has_only_letters(&self, column: usize, known: &[u8]) -> bool {
        let letters = self.letters.get(column).map_or(&[][..], Vec::as_slice);
        !letters.is_empty()
            && letters.iter().all(|letter| known.contains(letter))
            && self.known(column).next().is_none()
    }

    /// Whether every known value of a column is a whole number.
    pub fn is_whole(&self, column: usize) -> bool {
        self.known(column).all(|value| value.fract() == 0.0)
    }

    /// The finite values of a column.
    pub fn known(&self, column: usize) -> impl Iterator<Item = f64> + Clone + '_ {
        self.columns[column].iter().copied().filter(|value| value.is_finite())
    }

    /// The largest magnitude in a column.
    pub fn largest(&self, column: usize) -> f64 {
        self.known(column).fold(0.0, |most, value| most.max(value.abs()))
    }

    /// The least and the largest known value of a column.
    pub fn range(&self, column: usize) -> [f64; 2] {
        self.known(column).fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| {
            [least.min(value), most.max(value)]
        })
    }

    /// The magnitude that a twentieth of the known values other than 0 exceed: spikes do not change it.
    pub fn usual_largest(&self, column: usize) -> f64 {
        let values = self.known(column).map(f64::abs).filter(|value| *value > 0.0);
        quantile(&mut values.collect::<Vec<_>>(), 0.95).unwrap_or(0.0)
    }

    /// The median of the norms of three columns.
    pub fn median_norm(&self, columns: [usize; 3]) -> f64 {
        let [x, y, z] = columns.map(|column| &self.columns[column]);
        let norms = x.iter().zip(y).zip(z).map(|((x, y), z)| (x * x + y * y + z * z).sqrt());
        median(norms.filter(|norm| norm.is_finite()).collect())
    }

    /// The norm of the mean vector of three columns, relative to the root mean square of its norm.
    pub fn steadiness(&self, columns: [usize; 3]) -> f64 {
        let mean = |column: usize, power: i32| {
            let sum: f64 = self.known(column).map(|value| value.powi(power)).sum();
            sum / self.known(column).count() as f64
        };
        let mean_squared: f64 = columns.iter().map(|&column| mean(column, 1).powi(2)).sum();
        (mean_squared / columns.iter().map(|&column| mean(column, 2)).sum::<f64>()).sqrt()
    }

    /// Correlation of two columns.
    pub fn likeness(&self, a: usize, b: usize) -> f64 {
        correlation(self.columns[a].iter().copied().zip(self.columns[b].iter().copied()))
    }

    /// Correlation of the change of the column `angle` with the sum of the column `rate` over the same rows. Turns from
    /// one end of the range of an angle to the other do not count.
    pub fn likeness_of_change(&self, angle: usize, rate: usize) -> f64 {
        const ROWS: usize = 25;
        let [least, most] = self.range(angle);
        let changes = self.columns[angle].windows(ROWS + 1).map(|rows| rows[ROWS] - rows[0]);
        let sums = self.columns[rate].windows(ROWS).map(|rows| rows.iter().sum::<f64>());
        correlation(changes.zip(sums).filter(|(change, _)| change.abs() < 0.5 * (most - least)))
    }

    /// The 99th percentile of the norm of three columns.
    pub fn high_norm(&self, columns: [usize; 3]) -> f64 {
        let [x, y, z] = columns.map(|column| &self.columns[column]);
        let norms = x.iter().zip(y).zip(z).map(|((x, y), z)| (x * x + y * y + z * z).sqrt());
        let mut norms: Vec<f64> = norms.filter(|norm| norm.is_finite()).collect();
        norms.sort_unstable_by(f64::total_cmp);
        norms.get(norms.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(f64::NAN)
    }

    /// The median step from one known value of a column to the next.
    fn median_step(&self, column: usize) -> f64 {
        let values: Vec<f64> = self.known(column).collect();
        let steps = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
        median(steps.collect())
    }

    /// Whether a column increases like a time: on half of the rows or more, with decreases on fewer than 5 %. One more
    /// decrease is allowed, because a counter may start again.
    pub fn rises(&self, column: usize) -> bool {
        let values: Vec<f64> = self.known(column).collect();
        let falls = values.windows(2).filter(|pair| pair[1] < pair[0]).count();
        let rises = values.windows(2).filter(|pair| pair[1] > pair[0]).count();
        values.len() > 1 && 20 * falls.saturating_sub(1) < values.len() && 2 * rises >= values.len()
    }

    /// Whether a column counts: whole numbers that increase by 1, except where rows are missing or a counter starts again.
    pub fn counts(&self, column: usize) -> bool {
        /// Smallest fraction of the steps that are 1.
        const MAX: f64 = 0.9;
        let values = self.known(column);
        let (mut steps, mut ones) = (0usize, 0usize);
        for (before, after) in values.clone().zip(values.skip(1)) {
            steps += 1;
            ones += usize::from(after - before == 1.0);
        }
        steps > 0 && ones as f64 > MAX * steps as f64 && self.is_whole(column)
    }

    /// Whether the steps of a column are alike, as those of a time are.
    pub fn is_even(&self, column: usize) -> bool {
        /// Smallest fraction of the steps within half of the median step from it.
        const MAX: f64 = 0.9;
        let median = self.median_step(column);
        let values = self.known(column);
        let steps = values.clone().zip(values.skip(1)).map(|(before, after)| after - before);
        let count = steps.clone().count();
        let alike = steps.filter(|step| (step - median).abs() <= 0.5 * median).count();
        count > 1 && alike as f64 > MAX * count as f64
    }

    /// Whether a column increases like a time that repeats on several rows, or whose rows are slightly out of
    /// order.
    pub fn climbs(&self, column: usize) -> bool {
        /// Largest displacement of a row out of order, rows.
        const APART: usize = 8;
        /// Smallest number of rows with a value above all values before.
        const MIN_TIMES: usize = 10;
        let values: Vec<f64> = self.known(column).collect();
        let falls = values.windows(APART + 1).filter(|window| window[APART] < window[0]).count();
        let rises =
            values.iter().zip(highest_before(&values)).filter(|(value, highest)| *value > highest);
        rises.count() >= MIN_TIMES && 20 * falls < values.len()
    }

    /// The step from row to row: the median for a column that [rises](Self::rises), the mean for one that only
    /// [climbs](Self::climbs).
    pub fn step(&self, column: usize) -> f64 {
        if self.rises(column) {
            return self.median_step(column);
        }
        let [least, most] = self.range(column);
        (most - least) / (self.known(column).count().saturating_sub(1).max(1)) as f64
    }

    /// The number of consecutive rows with one value: median and maximum.
    pub fn rows_of_one_value(&self, column: usize) -> (usize, usize) {
        let values: Vec<f64> = self.known(column).collect();
        let mut runs: Vec<usize> = values.chunk_by(f64::eq).map(<[f64]>::len).collect();
        runs.sort_unstable();
        (runs.get(runs.len() / 2).copied().unwrap_or(0), runs.last().copied().unwrap_or(0))
    }

    /// The number of rows with a lower value than an earlier row.
    pub fn rows_behind(&self, column: usize) -> usize {
        let values: Vec<f64> = self.known(column).collect();
        values
            .iter()
            .zip(highest_before(&values))
            .filter(|(value, highest)| *value < highest)
            .count()
    }

    /// Whether the columns repeat the row before on most of the rows where they are known.
    pub fn is_held(&self, columns: &[usize]) -> bool {
        let (mut same, mut pairs) = (0usize, 0usize);
        let rows = self.columns.first().map_or(0, Vec::len);
        for row in 1..rows {
            let at = |row: usize| columns.iter().map(move |&column| self.columns[column][row]);
            if at(row).chain(at(row - 1)).all(f64::is_finite) {
                pairs += 1;
                same += usize::from(at(row).eq(at(row - 1)));
            }
        }
        pairs > 0 && 2 * same > pairs
    }
}

/// Rejects a file that is not text, with its actual format in the error.
fn ensure_text(path: &Path) -> Result<(), LogError> {
    if !path.is_file() {
        return Ok(());
    }
    let head = head_of(path)?;
    let found = match format_of(&head) {
        _ if is_unmappable(&head) => {
            let reason = format!("found {}", looks_like(&head));
            return Err(LogError::Unusable { path: path.to_path_buf(), reason });
        }
        Some(Format::Text) => return Ok(()),
        None if is_text(&head) => return Ok(()),
        Some(format) => format!("{}, which needs no mapping", format.with_article()),
        None => looks_like(&head).to_owned(),
    };
    let reason = format!("found {found}, expected text in columns");
    Err(LogError::Unusable { path: path.to_path_buf(), reason })
}

/// Replaces markers for unknown values in a column by NaN. Such markers repeat, and are far from all other values.
fn forget_unknown(column: &mut [f64]) {
    /// Smallest ratio of the magnitude of a marker for unknown values to the largest magnitude of the other values.
    const FAR: f64 = 2.0;
    let is_other = |value: &&f64| value.is_finite() && !is_unknown_velocity(**value);
    let largest = column.iter().filter(is_other).fold(0.0_f64, |most, value| most.max(value.abs()));
    let means_unknown = |value: f64| is_unknown_velocity(value) && value.abs() > FAR * largest;
    if column.iter().filter(|value| value.is_finite() && means_unknown(**value)).count() > 1 {
        column
            .iter_mut()
            .filter(|value| means_unknown(**value))
            .for_each(|value| *value = f64::NAN);
    }
}

/// Correlation of the pairs that are finite; 0 for constant values.
fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let pairs: Vec<(f64, f64)> = pairs.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let count = pairs.len().max(1) as f64;
    let mean_x = pairs.iter().map(|pair| pair.0).sum::<f64>() / count;
    let mean_y = pairs.iter().map(|pair| pair.1).sum::<f64>() / count;
    super::together::correlation(pairs.iter().map(|(x, y)| (x - mean_x, y - mean_y)))
}

/// For each value, the highest value before it.
fn highest_before(values: &[f64]) -> impl Iterator<Item = &f64> {
    values.iter().scan(&f64::NEG_INFINITY, |highest, value| {
        let before = *highest;
        *highest = if value > before { value } else { before };
        Some(before)
    })
}

/// The median of `values`; NaN if there are no values.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    quantile(&mut values, 0.5).unwrap_or(f64::NAN)
}
