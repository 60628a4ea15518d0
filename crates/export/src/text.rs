//! Text and calendar time for the formats that contain them.

use std::fmt;

use chrono::{DateTime, SecondsFormat, Utc};
use hovernav::ekf::Solution;
use hovernav::time::Time;

/// A time since the start of 1970 as a date.
pub fn date(time: Time) -> DateTime<Utc> {
    DateTime::from_timestamp_nanos(time.nanoseconds())
}

/// A time in the form of XML, to the nearest millisecond.
pub fn xml_date(time: Time) -> String {
    // The formatter truncates further digits.
    const HALF_A_MILLISECOND: i64 = 500_000;
    let rounded = time.nanoseconds().saturating_add(HALF_A_MILLISECOND);
    date(Time::from_nanoseconds(rounded)).to_rfc3339_opts(SecondsFormat::Millis, true)
}

/// Text escaped for XML; characters that XML cannot represent are omitted.
pub struct Escaped<'a>(pub &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use std::fmt::Write as _;
        for character in self.0.chars() {
            match character {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\t' | '\n' | '\r' => f.write_char(' ')?,
                control if control < ' ' || matches!(control, '\u{fffe}' | '\u{ffff}') => {}
                other => f.write_char(other)?,
            }
        }
        Ok(())
    }
}

/// Selection of solutions at least an interval apart, and the last one.
pub struct Thinning {
    interval_s: f64,
    last: Option<Time>,
    skipped: Option<Solution>,
}

impl Thinning {
    pub fn to(interval_s: f64) -> Self {
        Self { interval_s, last: None, skipped: None }
    }

    /// Whether `solution` is selected.
    pub fn takes(&mut self, solution: &Solution) -> bool {
        let is_due = self.last.is_none_or(|last| solution.time - last >= self.interval_s);
        if is_due {
            self.last = Some(solution.time);
        }
        self.skipped = (!is_due).then_some(*solution);
        is_due
    }

    /// The last solution, unless it was selected.
    pub fn rest(&mut self) -> Option<Solution> {
        self.skipped.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_dated_to_the_nearest_millisecond() {
        let dated = |nanoseconds| xml_date(Time::from_nanoseconds(nanoseconds));
        assert_eq!(dated(1_999_600_000), "1970-01-01T00:00:02.000Z");
        assert_eq!(dated(1_999_400_000), "1970-01-01T00:00:01.999Z");
        assert_eq!(dated(-1_600_000), "1969-12-31T23:59:59.998Z");
    }
}
