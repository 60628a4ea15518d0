//! Time of receivers: GPS week and time of week, or UTC.

const NS_PER_S: i64 = 1_000_000_000;
const DAY_NS: i64 = 86_400 * NS_PER_S;
const WEEK_NS: i64 = 7 * DAY_NS;
const WEEK_MS: u32 = 604_800_000;
/// Days from 1 January 1970 to the start of GPS time, 1980-01-06 00:00:00 UTC.
const GPS_START_DAY: i32 = 3_657;
/// Nanoseconds from the start of 1970 to the start of GPS time.
const GPS_START_NS: i64 = GPS_START_DAY as i64 * DAY_NS;
/// Upper limit of the number of leap seconds in the future.
const MAX_LEAP_SECONDS: i64 = 60;

/// Earliest GPS week that a live receiver can report: that of 4 January 2026.
pub const WEEK_FLOOR: u16 = 2_400;

/// The true GPS week of a `week` that may lack multiples of 1024: the first possible week that is not before `floor`.
///
/// The navigation message carries ten bits of the week. Old firmware resolves the rollover relative to a week that is
/// fixed in the firmware. 1024 weeks (19.6 years) after this week its count falls back by 1024.
///
/// ```
/// use hovernav::gps::{WEEK_FLOOR, unroll_week};
/// assert_eq!(unroll_week(1_053, WEEK_FLOOR), 3_101);
/// assert_eq!(unroll_week(1_053, 2_000), 2_077);
/// assert_eq!(unroll_week(2_410, WEEK_FLOOR), 2_410);
/// ```
#[must_use]
pub const fn unroll_week(week: u16, floor: u16) -> u16 {
    if week >= floor {
        return week;
    }
    let turns = (floor - week).div_ceil(1_024);
    week.saturating_add(turns.saturating_mul(1_024))
}

/// Time of an epoch on the receiver's clock, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReceiverTime {
    /// GPS time, which has no leap seconds.
    Gps {
        /// Weeks since 6 January 1980, with the rollover resolved; `None` while the receiver does not know the week.
        week: Option<u16>,
        /// Nanoseconds since the start of the week, below one week.
        time_of_week_ns: u64,
        /// GPS time minus UTC, s, if the receiver reports it.
        leap_seconds: Option<u8>,
    },
    /// Coordinated universal time.
    Utc {
        /// Days since 1 January 1970; `None` without a message with a date.
        day: Option<i32>,
        /// Nanoseconds since midnight, below one day, or below one day and a second in a leap second.
        time_of_day_ns: u64,
    },
}

impl ReceiverTime {
    /// Seconds from `earlier` to `self`.
    ///
    /// If one of the times has no week, they are assumed to be less than half a week apart. If one has no date, they
    /// are assumed to be less than half a day apart. `None` if one is GPS time and the other UTC.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Option<f64> {
        let (whole, part_ns, period_ns) = match (*self, *earlier) {
            (
                Self::Gps { week, time_of_week_ns, .. },
                Self::Gps { week: week_before, time_of_week_ns: before_ns, .. },
            ) => (
                week.zip(week_before).map(|(a, b)| i64::from(a) - i64::from(b)),
                difference_ns(time_of_week_ns, before_ns),
                WEEK_NS,
            ),
            (
                Self::Utc { day, time_of_day_ns },
                Self::Utc { day: day_before, time_of_day_ns: before_ns },
            ) => (
                day.zip(day_before).map(|(a, b)| i64::from(a) - i64::from(b)),
                difference_ns(time_of_day_ns, before_ns),
                DAY_NS,
            ),
            _ => return None,
        };
        let difference_ns = match whole {
            Some(periods) => periods.saturating_mul(period_ns).saturating_add(part_ns),
            None => wrap(part_ns, period_ns),
        };
        Some(difference_ns as f64 * 1e-9)
    }

    /// Nanoseconds of UTC since the start of 1970 without leap seconds (Unix time); `None` where the week, the date
    /// or the leap seconds are unknown.
    #[must_use]
    pub fn unix_ns(&self) -> Option<i64> {
        match *self {
            Self::Gps { week, time_of_week_ns, leap_seconds } => {
                let weeks_ns = i64::from(week?).saturating_mul(WEEK_NS);
                let utc_ns = weeks_ns
                    .saturating_add(i64::try_from(time_of_week_ns).ok()?)
                    .saturating_sub(i64::from(leap_seconds?) * NS_PER_S);
                Some(utc_ns.saturating_add(GPS_START_NS))
            }
            Self::Utc { day, time_of_day_ns } => Some(
                i64::from(day?)
                    .saturating_mul(DAY_NS)
                    .saturating_add(i64::try_from(time_of_day_ns).ok()?),
            ),
        }
    }

    /// GPS time from a time of week (less than one week) and the UTC of the same moment. UTC is given as days since the
    /// start of 1970 and nanoseconds since midnight, below two days. The week and the leap seconds are those for which
    /// the two agree.
    ///
    /// `None` if their difference is not within 0 to 60 s, the range of leap seconds.
    // Computed in days, because a 64-bit division takes 1 kB of program memory on a microcontroller.
    pub(crate) fn from_week_time_and_utc(
        time_of_week_ns: u64,
        day: i32,
        time_of_day_ns: i64,
    ) -> Option<Self> {
        let time_of_week = i64::try_from(time_of_week_ns).ok().filter(|time| *time < WEEK_NS)?;
        let day = day.checked_sub(GPS_START_DAY)?;
        let day_of_week_ns = i64::from(day.rem_euclid(7)) * DAY_NS;
        let ahead_ns = time_of_week.saturating_sub(day_of_week_ns.saturating_add(time_of_day_ns));
        // Rounded to the nearest second: the receiver gives the time of week in whole milliseconds.
        let rounded_ns = ahead_ns.saturating_add(NS_PER_S / 2);
        // GPS time may already be in the next week.
        let (leap_ns, turned) =
            if rounded_ns < 0 { (rounded_ns.saturating_add(WEEK_NS), 1) } else { (rounded_ns, 0) };
        if leap_ns >= (MAX_LEAP_SECONDS + 1) * NS_PER_S {
            return None;
        }
        // The quotient has few digits, so rounding cannot carry it across a whole number.
        let leap_seconds = (leap_ns as f64 / NS_PER_S as f64) as u8;
        let week = u16::try_from(day.div_euclid(7) + turned).ok()?;
        Some(Self::Gps { week: Some(week), time_of_week_ns, leap_seconds: Some(leap_seconds) })
    }

    /// GPS time from a time of week in milliseconds and a fraction to add, ns; the sum may lie outside the week.
    pub(crate) fn of_gps(
        week: Option<i16>,
        time_of_week_ms: u32,
        more_ns: i32,
        leap_seconds: Option<u8>,
    ) -> Self {
        let (weeks, rest_ms) = (time_of_week_ms / WEEK_MS, time_of_week_ms % WEEK_MS);
        let time_ns = i64::from(rest_ms) * 1_000_000 + i64::from(more_ns);
        let (turned, time_ns) = match time_ns {
            before if before < 0 => (-1, before + WEEK_NS),
            after if after >= WEEK_NS => (1, after - WEEK_NS),
            within => (0, within),
        };
        let week = week.map(|week| i64::from(week) + i64::from(weeks) + turned);
        Self::Gps {
            week: week.and_then(|week| u16::try_from(week).ok()),
            time_of_week_ns: time_ns.unsigned_abs(),
            leap_seconds,
        }
    }
}

/// Days from 1 January 1970 to a date of the Gregorian calendar; `None` for an invalid date, or one before the year
/// 1.
///
/// # Source
/// H. Hinnant, *chrono-Compatible Low-Level Date Algorithms* (2013), `days_from_civil`: the year begins in March, so
/// that the leap day is its last.
pub(crate) fn days_since_1970(year: u32, month: u32, day: u32) -> Option<i32> {
    let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let length = match month {
        1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
        4 | 6 | 9 | 11 => 30,
        2 => 28 + u32::from(leap),
        _ => return None,
    };
    if !(1..=9_999).contains(&year) || !(1..=length).contains(&day) {
        return None;
    }
    let year = year - u32::from(month <= 2);
    let (era, year_of_era) = (year / 400, year % 400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let day_of_era = 365 * year_of_era + year_of_era / 4 - year_of_era / 100 + day_of_year;
    i32::try_from(146_097 * era + day_of_era).ok()?.checked_sub(719_468)
}

/// A time of week in seconds as whole nanoseconds; `None` outside a week.
pub(crate) fn time_of_week_ns(seconds: f64) -> Option<u64> {
    (0.0..604_800.0).contains(&seconds).then(|| libm::round(seconds * 1e9) as u64)
}

fn difference_ns(later: u64, earlier: u64) -> i64 {
    later.cast_signed().saturating_sub(earlier.cast_signed())
}

/// `value` wrapped by whole periods into ± half a period.
fn wrap(value: i64, period: i64) -> i64 {
    (value.saturating_add(period / 2)).rem_euclid(period) - period / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_week_that_rolled_over_once_or_twice_is_found_again() {
        assert_eq!(unroll_week(1_399, WEEK_FLOOR), 2_423);
        assert_eq!(unroll_week(375, WEEK_FLOOR), 2_423);
        assert_eq!(unroll_week(0, 0), 0);
        assert_eq!(unroll_week(65_535, WEEK_FLOOR), 65_535);
        assert!(unroll_week(0, u16::MAX) >= u16::MAX - 1_024);
    }

    #[test]
    fn days_are_counted_one_by_one_through_four_centuries() {
        let mut expected = -135_140;
        for year in 1_600..=2_100 {
            for month in 1..=12 {
                for day in (1..=31).filter_map(|day| days_since_1970(year, month, day)) {
                    assert_eq!(day, expected, "{year}-{month}");
                    expected += 1;
                }
            }
        }
        assert_eq!(days_since_1970(1_970, 1, 1), Some(0));
        assert_eq!(days_since_1970(2_000, 2, 29), Some(11_016));
        assert_eq!(days_since_1970(2_026, 3, 20), Some(20_532));
        for (year, month, day) in [(1_900, 2, 29), (2_023, 4, 31), (2_023, 13, 1), (2_023, 1, 0)] {
            assert_eq!(days_since_1970(year, month, day), None, "{year}-{month}-{day}");
        }
    }

    #[test]
    fn time_runs_on_across_the_end_of_a_week_and_of_a_day() {
        let gps =
            |week, time_of_week_ns| ReceiverTime::Gps { week, time_of_week_ns, leap_seconds: None };
        let last = WEEK_NS as u64 - 500_000_000;
        assert_eq!(gps(None, 500_000_000).since(&gps(Some(2_400), last)), Some(1.0));
        assert_eq!(gps(Some(2_401), 500_000_000).since(&gps(Some(2_400), last)), Some(1.0));
        assert_eq!(gps(None, last).since(&gps(None, 500_000_000)), Some(-1.0));
        let utc = |day, time_of_day_ns| ReceiverTime::Utc { day, time_of_day_ns };
        let late = DAY_NS as u64 - 250_000_000;
        assert_eq!(utc(None, 0).since(&utc(None, late)), Some(0.25));
        assert_eq!(utc(Some(3), 0).since(&utc(Some(1), late)), Some(86_400.25));
        assert_eq!(utc(None, 0).since(&gps(None, 0)), None);
    }

    #[test]
    fn gps_time_and_utc_of_one_moment_give_week_and_leap_seconds() {
        // 2017-07-19 08:50:00.8 UTC, 18 leap seconds, week 1958 (a u-blox capture's first epoch).
        let unix_ns = 1_500_454_200_800_000_000;
        let (day, time_of_day_ns) = (17_366, 31_800_800_000_000);
        let time = ReceiverTime::from_week_time_and_utc(291_018_800_000_000, day, time_of_day_ns);
        assert_eq!(
            time,
            Some(ReceiverTime::Gps {
                week: Some(1_958),
                time_of_week_ns: 291_018_800_000_000,
                leap_seconds: Some(18)
            })
        );
        assert_eq!(time.and_then(|time| time.unix_ns()), Some(unix_ns));
        // The two times differ by half an hour: one of them is wrong.
        assert_eq!(
            ReceiverTime::from_week_time_and_utc(
                291_018_800_000_000,
                day,
                time_of_day_ns + 1_800 * NS_PER_S
            ),
            None
        );
    }

    #[test]
    fn every_leap_second_of_the_span_is_reported_to_the_half_second() {
        let (tow_ns, day) = (3 * DAY_NS + 100 * NS_PER_S, GPS_START_DAY + 2_400 * 7 + 3);
        let leap_of = |ahead_ns: i64| {
            let utc_ns = 100 * NS_PER_S - ahead_ns;
            let time = ReceiverTime::from_week_time_and_utc(tow_ns as u64, day, utc_ns)?;
            let ReceiverTime::Gps { week, leap_seconds, .. } = time else { return None };
            assert_eq!(week, Some(2_400));
            leap_seconds
        };
        for leap in 0..=60 {
            let whole_ns = i64::from(leap) * NS_PER_S;
            for off_ns in [-NS_PER_S / 2, -1, 0, 1, NS_PER_S / 2 - 1] {
                assert_eq!(leap_of(whole_ns + off_ns), Some(leap), "{leap} {off_ns}");
            }
        }
        assert_eq!(leap_of(-NS_PER_S / 2 - 1), None);
        assert_eq!(leap_of(60 * NS_PER_S + NS_PER_S / 2), None);
        assert_eq!(ReceiverTime::from_week_time_and_utc(WEEK_NS as u64, day, 0), None);
        assert_eq!(ReceiverTime::from_week_time_and_utc(u64::MAX, i32::MIN, i64::MIN), None);
    }

    #[test]
    fn times_of_week_beyond_its_ends_are_of_the_weeks_next_to_it() {
        let of = |ms, more_ns| match ReceiverTime::of_gps(Some(2_400), ms, more_ns, None) {
            ReceiverTime::Gps { week, time_of_week_ns, .. } => (week, time_of_week_ns),
            ReceiverTime::Utc { .. } => (None, 0),
        };
        let week_ns = WEEK_NS as u64;
        assert_eq!(of(0, -1), (Some(2_399), week_ns - 1));
        assert_eq!(of(1, -1_000_001), (Some(2_399), week_ns - 1));
        assert_eq!(of(WEEK_MS, 0), (Some(2_401), 0));
        assert_eq!(of(WEEK_MS - 1, 1_000_000), (Some(2_401), 0));
        assert_eq!(of(2 * WEEK_MS, -5), (Some(2_401), week_ns - 5));
        assert_eq!(of(u32::MAX, i32::MAX).0, Some(2_407));
    }

    #[test]
    fn the_first_seconds_of_a_week_in_gps_time_belong_to_the_new_week() {
        // UTC is still 10 s before the week's start when GPS time, 18 s ahead, is 8 s into it.
        let week_start = GPS_START_DAY + 2_400 * 7;
        let time = ReceiverTime::from_week_time_and_utc(
            8 * NS_PER_S as u64,
            week_start - 1,
            DAY_NS - 10 * NS_PER_S,
        );
        assert!(matches!(
            time,
            Some(ReceiverTime::Gps { week: Some(2_400), leap_seconds: Some(18), .. })
        ));
    }
}
