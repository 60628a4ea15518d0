//! Calendar dates.

use chrono::DateTime;
use hovernav::time::Time;

/// The date at `utc_s`, s since 1970, as TOML writes it. `None` outside the years 1990 to 2099: no log can be from
/// then.
pub(crate) fn date(utc_s: f64) -> Option<String> {
    let day = DateTime::from_timestamp(utc_s as i64, 0)?.date_naive();
    let text = day.to_string();
    (text.as_str() >= "1990" && text.as_str() < "2100").then_some(text)
}

/// 6 January 1980, the start of GPS time, s since 1970.
pub(crate) const GPS_EPOCH_S: i64 = 315_964_800;

/// Length of a week, s.
pub(crate) const WEEK_S: i64 = 604_800;

const SECOND_NS: i64 = 1_000_000_000;

/// UTC, s since 1970, at which each leap second has passed. From each of these on, GPS time is another second ahead
/// of UTC; 18 s since 2017.
///
/// # Source
/// IERS Bulletin C; the list in `leap-seconds.list` of the time zone database.
const LEAPS_S: [i64; 18] = [
    362_793_600,
    394_329_600,
    425_865_600,
    489_024_000,
    567_993_600,
    631_152_000,
    662_688_000,
    709_948_800,
    741_484_800,
    773_020_800,
    820_454_400,
    867_715_200,
    915_148_800,
    1_136_073_600,
    1_230_768_000,
    1_341_100_800,
    1_435_708_800,
    1_483_228_800,
];

/// Converts GPS time, ns since 6 January 1980, to UTC, ns since 1970.
pub(crate) fn of_gps(gps_ns: i64) -> i64 {
    let ahead_ns = gps_ns.saturating_add(GPS_EPOCH_S * SECOND_NS);
    // The earlier leap seconds are subtracted before the comparison with each leap second.
    let passed = LEAPS_S.iter().zip(0..).filter(|&(&leap_s, before): &(&i64, i64)| {
        ahead_ns.div_euclid(SECOND_NS) - before > leap_s
    });
    ahead_ns - passed.count() as i64 * SECOND_NS
}

/// Converts a GPS week and the seconds in it to UTC, ns since 1970.
pub(crate) fn of_gps_week(week: f64, in_week_s: f64) -> i64 {
    of_gps(
        (week as i64).saturating_mul(WEEK_S * SECOND_NS).saturating_add((1e9 * in_week_s) as i64),
    )
}

/// UTC at the start of a log, ns since 1970, according to each of its fixes.
#[derive(Debug, Default)]
pub(crate) struct UtcAtZero(Vec<i64>);

impl UtcAtZero {
    /// Adds the UTC of a fix, ns since 1970, at `time` of the log. Has no effect if no log can have that date.
    pub fn push(&mut self, utc_ns: i64, time: Time) {
        if date(utc_ns as f64 * 1e-9).is_some() {
            self.0.push(utc_ns.saturating_sub(time.nanoseconds()));
        }
    }

    /// The first value near the median: receivers send wrong dates until they have decoded the correct one.
    pub fn first(&self) -> Option<i64> {
        let mut sorted = self.0.clone();
        sorted.sort_unstable();
        let median_ns = *sorted.get(sorted.len() / 2)?;
        let is_near = |ns: &&i64| ns.abs_diff(median_ns) <= SECOND_NS.unsigned_abs();
        self.0.iter().find(is_near).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chrono::Datelike as _;

    #[test]
    fn days_are_those_of_the_calendar() {
        assert_eq!(date(1_739_195_790.2).as_deref(), Some("2025-02-10"));
        assert_eq!(date(0.0), None);
        assert_eq!(date(f64::NAN), None);
        assert_eq!(date(1e300), None);
    }

    #[test]
    fn the_first_utc_that_the_others_confirm_is_used() {
        const START_NS: i64 = 1_739_195_790 * SECOND_NS;
        let first = |wrong: &[i64]| {
            let mut utc = UtcAtZero::default();
            for k in 0..10 {
                let right_ns = START_NS + k * SECOND_NS;
                let utc_ns = wrong.get(k as usize).copied().unwrap_or(right_ns);
                utc.push(utc_ns, Time::from_nanoseconds(k * SECOND_NS));
            }
            utc.first()
        };
        for wrong in [&[][..], &[1000], &[GPS_EPOCH_S * SECOND_NS; 8], &[2 * START_NS / 3; 4]] {
            assert_eq!(first(wrong), Some(START_NS), "{wrong:?}");
        }
        assert_eq!(first(&[1000; 10]), None);
    }

    fn utc(gps_s: i64) -> i64 {
        of_gps(gps_s * SECOND_NS) / SECOND_NS
    }

    #[test]
    fn gps_time_is_ahead_of_utc_by_the_leap_seconds_so_far() {
        assert_eq!(utc(0), GPS_EPOCH_S);
        // The receiver's own values at the end of 2016: GPS week 1930, 17 and 18 s into Sunday.
        let turn_s = 1_483_228_800 - GPS_EPOCH_S;
        assert_eq!(utc(turn_s + 16), 1_483_228_799);
        assert_eq!(utc(turn_s + 18), 1_483_228_800);
        assert_eq!(utc(1_800_000_000 - GPS_EPOCH_S + 18), 1_800_000_000);
    }

    #[test]
    fn leap_seconds_fall_on_the_first_of_january_or_july() {
        for leap_s in LEAPS_S {
            let day = DateTime::from_timestamp(leap_s, 0).unwrap();
            assert!(leap_s % 86_400 == 0 && day.day() == 1, "{day}");
            assert!(matches!(day.month(), 1 | 7), "{day}");
        }
        assert!(LEAPS_S.is_sorted());
    }
}
