//! Text and calendar time of the formats that have them.

use std::fmt;

use chrono::{DateTime, SecondsFormat, Utc};
use hovernav::time::Time;

/// The moment as a date: the clock's seconds since the start of 1970.
pub fn date(time: Time) -> DateTime<Utc> {
    DateTime::from_timestamp_nanos(time.nanoseconds())
}

/// The moment as XML writes it.
pub fn xml_date(time: Time) -> String {
    date(time).to_rfc3339_opts(SecondsFormat::Millis, true)
}

/// Text as XML shows it; what XML cannot hold is left out.
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

/// Indices of `times` at least `interval_s` apart, the last among them.
pub fn thinned(times: &[Time], interval_s: f64) -> impl Iterator<Item = usize> + '_ {
    let mut last: Option<Time> = None;
    (0..times.len()).filter(move |&index| {
        let is_due = last.is_none_or(|last| times[index] - last >= interval_s);
        if is_due {
            last = Some(times[index]);
        }
        is_due || index + 1 == times.len()
    })
}
