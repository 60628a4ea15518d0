//! The columns of the time of a row.

use std::ops::Range;

use super::columns::{Reader, Understood};
use super::quantity::Quantity;
use super::travel;
use crate::text::{Mapping, TimeColumn, TimeScale, TimeUnit};
use crate::utc::WEEK_S;
use hovernav_dataset::LogError;

/// Ticks of 100 ns from 1980 to 2110, counted from 1601. As nanoseconds since 1970 they would be before 1976.
const FILE_TIMES: Range<f64> = 1.19e17..1.61e17;
/// Ticks of 100 ns from 1980 to 2110, counted from the year 1. As nanoseconds since 1970 they would be before 1992.
const TICKS: Range<f64> = 6.24e17..6.66e17;

impl Reader<'_> {
    /// The time column; `None` if no column increases like a time.
    pub(super) fn time(
        &mut self,
        has_motion: bool,
        checks: &mut Vec<String>,
    ) -> Option<TimeColumn> {
        let column = self.time_column()?;
        let rises = self.look.rises(column);
        let step = self.look.step(column);
        let is_count = self.look.counts(column) && self.known.unit(column).is_none();
        let rate_hz = self.look.layout.rate_mhz.filter(|_| is_count).map(|rate| rate as f64 * 1e-3);
        let unit = match self.known.unit(column) {
            _ if rate_hz.is_some() => TimeUnit::Count,
            _ if self.look.stamp == Some(column) => TimeUnit::Seconds,
            _ if self.look.are_clock[column] => TimeUnit::Clock,
            _ if self.is_hhmmss(column) => TimeUnit::HoursMinutesSeconds,
            _ if self.is_between(column, FILE_TIMES) => TimeUnit::FileTime,
            _ if self.is_between(column, TICKS) => TimeUnit::Ticks,
            _ if self.look.layout.names[column].to_lowercase().contains("timefine") => {
                TimeUnit::TenthMilliseconds
            }
            Some("s") => TimeUnit::Seconds,
            Some("ms") => TimeUnit::Milliseconds,
            Some("us") => TimeUnit::Microseconds,
            Some("ns") => TimeUnit::Nanoseconds,
            Some("d") => TimeUnit::Days,
            _ => self.unstated_unit(column, step, has_motion),
        };
        let is_mjd = self.look.layout.names[column].to_lowercase().contains("mjd");
        let unit = match unit {
            TimeUnit::Days if is_mjd => TimeUnit::ModifiedJulianDays,
            TimeUnit::Days if self.is_between(column, SPREADSHEET_DAYS) => {
                TimeUnit::SpreadsheetDays
            }
            TimeUnit::Days if self.is_between(column, DATENUMS) => TimeUnit::Datenum,
            unit => unit,
        };
        let date = self.date(column, unit, checks);
        let week = self.week(column, unit, checks);
        let nanoseconds = self.look.stamp.filter(|stamp| *stamp == column);
        let nanoseconds = nanoseconds.map_or_else(String::new, |stamp| self.name(stamp + 1));
        let name = self.name(column);
        let step_s = step * unit.seconds() / rate_hz.unwrap_or(1.0);
        let longest_s = if has_motion { 0.2 } else { 30.0 };
        (self.span, self.step) = (self.look.range(column), step);
        if !(1e-5..=longest_s).contains(&step_s) {
            checks.push(format!(
                "time {name}: found steps of {step_s} s, read as {}: check its unit",
                unit.name()
            ));
        }
        if !rises {
            self.describe_rise(column, checks);
        }
        self.is_counted = is_count && has_motion && rate_hz.is_none();
        if self.is_counted {
            checks.push(format!(
                "{COUNTED} {name} of {} counts rows and states no unit: read as {}, {:.0} Hz; if it is no \
                 time, set unit = \"count\" and rate_hz under [table.time]",
                self.file,
                unit.name(),
                1.0 / step_s
            ));
        }
        if unit == TimeUnit::SpreadsheetDays {
            checks.push(format!(
                "time {name} is in days since 30 December 1899, as spreadsheets count, and names no zone: \
                 read as UTC; for local times set offset_s under [table.time], -3600 per hour east of \
                 Greenwich"
            ));
        }
        let lower = name.to_lowercase();
        if unit.is_of_day() && (lower.contains("local") || lower.contains("lcl")) {
            checks.push(format!(
                "time {name} is local and names no zone: read as UTC; set offset_s under [table.time], \
                 -3600 per hour east of Greenwich"
            ));
        }
        let is_dated = date.is_some() || self.look.largest(column) > YEAR_S;
        // RTKLIB names the time scale.
        let is_gps = unit.is_of_day() && is_dated && lower == "gpst";
        if unit.is_of_day() && lower.contains("gps") && !is_gps {
            checks.push(format!(
                "time {name} is from GPS and states no scale: read as UTC; if it is GPS time, set scale = \"gps\" \
                 under [table.time], which needs a date"
            ));
        }
        Some(TimeColumn {
            column: name,
            unit,
            nanoseconds,
            scale: if week.is_some() || is_gps { TimeScale::Gps } else { TimeScale::Own },
            date: date.map_or_else(String::new, |column| self.name(column)),
            week: week.map_or_else(String::new, |column| self.name(column)),
            rate_hz,
            ..TimeColumn::default()
        })
    }

    /// The unit of a time that states none. All plausible units are kept in `time_units`.
    fn unstated_unit(&mut self, column: usize, step: f64, has_motion: bool) -> TimeUnit {
        let plausible_s = if has_motion { IMU_STEPS_S } else { OTHER_STEPS_S };
        let is_epoch =
            |unit: &TimeUnit| EPOCHS_S.contains(&(self.look.largest(column) * unit.seconds()));
        let mut units = PLAIN_UNITS.to_vec();
        units.retain(|unit| plausible_s.contains(&(step * unit.seconds())));
        if let Some(epoch) = units.iter().copied().find(is_epoch) {
            units = vec![epoch];
        }
        units.sort_by_key(|unit| !USUAL_STEPS_S.contains(&(step * unit.seconds())));
        self.time_units = units;
        self.time_units.first().copied().unwrap_or_default()
    }

    /// The reason why no column is a time.
    pub(super) fn missing_time(&self) -> String {
        /// Smallest epoch that single precision rounds to many seconds.
        const MIN_S: f64 = 1e9;
        let names = &self.look.layout.names;
        let is_rounded = |column: &usize| {
            let mut values = self.look.known(*column).peekable();
            values.peek().is_some()
                && values.all(|value| value > MIN_S && f64::from(value as f32) == value)
        };
        let mut times = (0..names.len()).filter(|&column| self.is(column, Quantity::Time));
        match times.find(is_rounded) {
            Some(column) => format!(
                "{} is rounded to single precision, which states an epoch only to 128 s: write it in double \
                 precision",
                names[column]
            ),
            None => format!(
                "found no column that increases like a time, expected numbers, 12:34:56.7 or \
                 2025-07-08T12:34:56.7 in one of {}",
                names.join(", ").chars().take(200).collect::<String>()
            ),
        }
    }

    /// The column of the time, by name: one that rises on every row, otherwise one that repeats values, otherwise one
    /// of dates. Without such a name it is the first column, if its name is not recognised and it rises. A column that
    /// counts is the last choice; then any column that is not recognised and rises evenly is a time.
    fn time_column(&self) -> Option<usize> {
        let all = 0..self.look.columns.len();
        let of = |quantity: Quantity| {
            let columns = || all.clone().filter(move |&c| self.is(c, quantity));
            let rising = |&column: &usize| self.look.rises(column);
            let counts = |column: &usize| self.look.counts(*column);
            (columns().find(|column| rising(column) && !counts(column)))
                .or_else(|| columns().find(|column| self.look.climbs(*column)))
                .or_else(|| columns().find(rising))
        };
        let is_bare = |&column: &usize| {
            self.known.meanings[column].is_none()
                && self.look.rises(column)
                && !self.look.counts(column)
                && (column == 0 || self.look.is_even(column))
        };
        let counts = |&column: &usize| self.look.counts(column);
        let first = || all.clone().find(|&c| c == 0 && self.known.meanings[c].is_none());
        of(Quantity::Time)
            .or_else(|| of(Quantity::Date))
            .or_else(|| all.clone().find(is_bare))
            .or_else(|| first().filter(counts))
    }

    fn is_between(&self, column: usize, range: Range<f64>) -> bool {
        self.look.known(column).all(|value| range.contains(&value))
    }

    fn is(&self, column: usize, quantity: Quantity) -> bool {
        self.known.meanings[column].is_some_and(|meaning| meaning.quantity == quantity)
    }

    /// Whether a column contains times of day as hhmmss. Seconds and minutes stay below 60, and each new minute
    /// jumps by 41, which would be a gap in plain seconds. If no minute begins in the file, the name must contain utc,
    /// hms or hhmmss.
    fn is_hhmmss(&self, column: usize) -> bool {
        let is_shown = |value: f64| {
            let is_leap = (235_960.0..235_961.0).contains(&value);
            (0.0..240_000.0).contains(&value)
                && (value % 100.0 < 60.0 || is_leap)
                && value / 100.0 % 100.0 < 60.0
        };
        if !self.look.known(column).all(is_shown) {
            return false;
        }
        let minute = |value: f64| (value / 100.0).floor();
        let seconds = |value: f64| {
            let (hours, minutes) = ((value / 10_000.0).floor(), minute(value) % 100.0);
            3600.0 * hours + 60.0 * minutes + value % 100.0
        };
        let pairs = || self.look.known(column).zip(self.look.known(column).skip(1));
        let passed = pairs().filter(|(a, b)| minute(*b) > minute(*a));
        let (mut minutes, mut smooth) = (0usize, 0usize);
        for (before, after) in passed {
            minutes += 1;
            // Rows 10 s apart differ by 50 as numbers if a minute begins between them: a ratio of 5.
            smooth += usize::from(4.0 * (seconds(after) - seconds(before)) <= after - before);
        }
        if minutes > 0 {
            return 2 * smooth > minutes;
        }
        let name = self.look.layout.names[column].to_lowercase();
        let says_so = ["utc", "hms", "hhmmss"].iter().any(|part| name.contains(part));
        says_so && (self.look.largest(column) >= 10_000.0 || self.look.are_padded[column])
    }

    /// The date column that belongs to the times of day.
    fn date(&self, time: usize, unit: TimeUnit, checks: &mut Vec<String>) -> Option<usize> {
        const DAY_S: f64 = 86_400.0;
        let date = self.known.column(Quantity::Date).filter(|date| *date != time)?;
        // A time that includes its date needs no date column.
        let is_hhmmss = unit == TimeUnit::HoursMinutesSeconds;
        if !is_hhmmss && self.look.largest(time) * unit.seconds() >= DAY_S {
            return None;
        }
        if !unit.is_of_day() {
            return None;
        }
        if !self.look.are_dates[date] {
            checks.push(format!(
                "time: {} is not a date, expected ddmmyy, yyyymmdd or 2025-07-08: ignored, so the \
                 times of day in {} have no date",
                self.look.layout.names[date], self.look.layout.names[time]
            ));
            return None;
        }
        Some(date)
    }

    /// The column of the GPS week that belongs to the times of week.
    fn week(&self, time: usize, unit: TimeUnit, checks: &mut Vec<String>) -> Option<usize> {
        /// Weeks after which the ten-bit week number of some receivers starts again at 0.
        const TEN_BITS: f64 = 1024.0;
        let name = self.look.layout.names[time].to_lowercase();
        // RTKLIB writes a week and the time in it below the names of a date and a time of day.
        let of_rtklib = || {
            let date = self.known.column(Quantity::Date).filter(|_| name == "gpst");
            date.filter(|date| !self.look.are_dates[*date])
        };
        let week = self.known.column(Quantity::Week).or_else(of_rtklib)?;
        let times = self.known.meanings.iter().flatten();
        let is_only = times.filter(|meaning| meaning.quantity == Quantity::Time).count() < 2;
        let is_of_week = is_only || ["tow", "week", "sow"].iter().any(|part| name.contains(part));
        let max_s = self.look.largest(time) * unit.seconds();
        if unit.is_of_day()
            || !is_of_week
            || max_s > WEEK_S as f64 + 1.0
            || !self.look.is_whole(week)
        {
            return None;
        }
        let week_name = &self.look.layout.names[week];
        let count = self.look.largest(week);
        if count < TEN_BITS {
            checks.push(format!(
                "time: week {count} of {week_name} is between 1980 and 1999. If the receiver sends \
                 only ten bits of the week, set offset_s under [table.time] to 619315200 s per \
                 1024 weeks"
            ));
        }
        Some(week)
    }

    /// Reports repeated times and rows out of order.
    fn describe_rise(&self, column: usize, checks: &mut Vec<String>) {
        let (file, name) = (&self.file, &self.look.layout.names[column]);
        let (rows, most) = self.look.rows_of_one_value(column);
        if rows > 1 {
            checks.push(format!(
                "time {name} of {file} repeats, typically on {rows} rows and at most on {most}: \
                 rows of equal time are combined, and identical rows count once"
            ));
        }
        let behind = self.look.rows_behind(column);
        if behind > 0 {
            checks.push(format!(
                "time {name} of {file} goes back on {behind} rows: these are ignored; sort the \
                 file to keep them"
            ));
        }
    }
}

/// A year, s; a larger time of a clock has a date.
const YEAR_S: f64 = 3.2e7;
/// Days from 1982 to 2064, as spreadsheets count them.
const SPREADSHEET_DAYS: Range<f64> = 3e4..6e4;
/// Days from 1981 to 2064, counted from the year 0.
const DATENUMS: Range<f64> = 7.235e5..7.54e5;

/// Beginning of the check of a time that may be a number of rows.
pub(super) const COUNTED: &str = "time: the counter";

/// Units of times that state none. Spreadsheets count in days.
const PLAIN_UNITS: [TimeUnit; 5] = [
    TimeUnit::Seconds,
    TimeUnit::Milliseconds,
    TimeUnit::Microseconds,
    TimeUnit::Nanoseconds,
    TimeUnit::Days,
];
/// Plausible intervals of an IMU, s.
const IMU_STEPS_S: Range<f64> = 2e-4..0.15;
/// Plausible intervals of a file without an IMU, s: of a receiver, or of an attitude or reference as fast as an IMU.
const OTHER_STEPS_S: Range<f64> = 1.5e-3..15.0;
/// Usual intervals of a file without an IMU, s.
const USUAL_STEPS_S: Range<f64> = 2.5e-3..2.5;
/// Times from 2000 to 2100, s since 1970.
const EPOCHS_S: Range<f64> = 9.4e8..4.1e9;

/// Determines the unit of each time that has several plausible ones: the files overlap in time, or speeds agree with
/// the distances between positions. Otherwise the user is asked.
pub(super) fn settle_units(
    mapping: &mut Mapping,
    understood: &[Understood],
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) -> Result<(), LogError> {
    let seconds = |one: &Understood, unit: TimeUnit| one.span.map(|time| time * unit.seconds());
    let known: Vec<[f64; 2]> = (understood.iter())
        .filter(|one| one.time_units.len() < 2 && PLAIN_UNITS.contains(&one.mapping.time.unit))
        .map(|one| seconds(one, one.mapping.time.unit))
        .collect();
    for (at, one) in understood.iter().enumerate().filter(|(_, one)| one.time_units.len() > 1) {
        let shared = |unit: &TimeUnit| {
            let [first, last] = seconds(one, *unit);
            let part = |[from, to]: &[f64; 2]| {
                (last.min(*to) - first.max(*from)) / (last.max(*to) - first.min(*from))
            };
            known.iter().map(part).fold(0.0, f64::max)
        };
        let overlapping = one.time_units.iter().copied().filter(|unit| shared(unit) > 0.0);
        let overlapping = overlapping.max_by(|a, b| shared(a).total_cmp(&shared(b)));
        let moving = || -> Result<Option<TimeUnit>, LogError> {
            for unit in &one.time_units {
                let mut trial = mapping.clone();
                trial.table[at].time.unit = *unit;
                let travelled = travel::travel(&super::read(&trial)?.fixes);
                if travelled.is_some_and(|one| {
                    one.cosine >= travel::DECISIVE_COSINE && (0.5..2.0).contains(&one.ratio)
                }) {
                    return Ok(Some(*unit));
                }
            }
            Ok(None)
        };
        let time = &one.mapping.time;
        let (file, column) = (one.mapping.file.display(), &time.column);
        if let Some(unit) = overlapping {
            mapping.table[at].time.unit = unit;
            findings.push(format!(
                "{column} of {file} is in {}: the files overlap in time",
                unit.name()
            ));
        } else if let Some(unit) = if one.mapping.gps.is_some() { moving()? } else { None } {
            mapping.table[at].time.unit = unit;
            findings.push(format!(
                "{column} of {file} is in {}: the speeds agree with the distances between the positions",
                unit.name()
            ));
        } else {
            let [read, other] = [0, 1].map(|index| one.time_units[index]);
            checks.push(format!(
                "time: {column} of {file} states no unit: rows are {:.4} s apart if it is in {}, as read, or \
                 {:.4} s if it is in {other}; for that set unit = \"{other}\" under [table.time]",
                one.step * read.seconds(),
                read.name(),
                one.step * other.seconds(),
                other = other.name()
            ));
        }
    }
    Ok(())
}
