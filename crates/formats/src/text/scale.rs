//! Time scales and leap seconds.

use serde::{Deserialize, Serialize};

use hovernav::time::Time;

/// Time scale of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeScale {
    /// The logger's own clock, or UTC since 1970.
    #[default]
    Own,
    /// GPS time since 6 January 1980, without leap seconds. It is converted to UTC since 1970.
    Gps,
}

/// 6 January 1980, s since 1970.
const GPS_EPOCH_S: i64 = 315_964_800;

/// A week of GPS time, s.
pub(crate) const WEEK_S: i64 = 604_800;

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

impl TimeScale {
    /// Whether this is the default scale, which a mapping does not list.
    pub fn is_own(&self) -> bool {
        *self == Self::Own
    }

    /// Converts `time` from this scale to UTC; [`Own`](Self::Own) is unchanged.
    pub fn to_utc(self, time: Time) -> Time {
        const SECOND_NS: i64 = 1_000_000_000;
        if self == Self::Own {
            return time;
        }
        let ahead_ns = time.nanoseconds().saturating_add(GPS_EPOCH_S * SECOND_NS);
        // The earlier leap seconds are subtracted before the comparison with each leap second.
        let passed = LEAPS_S.iter().zip(0..).filter(|&(&leap_s, before): &(&i64, i64)| {
            ahead_ns.div_euclid(SECOND_NS) - before > leap_s
        });
        Time::from_nanoseconds(ahead_ns - passed.count() as i64 * SECOND_NS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chrono::{DateTime, Datelike as _};

    fn utc(gps_s: i64) -> i64 {
        let time = TimeScale::Gps.to_utc(Time::from_nanoseconds(gps_s * 1_000_000_000));
        time.nanoseconds() / 1_000_000_000
    }

    #[test]
    fn gps_time_is_ahead_of_utc_by_the_leap_seconds_so_far() {
        assert_eq!(utc(0), GPS_EPOCH_S);
        // The receiver's own pair at the turn of 2017: GPS week 1930, 17 and 18 s into Sunday.
        let turn_s = 1_483_228_800 - GPS_EPOCH_S;
        assert_eq!(utc(turn_s + 16), 1_483_228_799);
        assert_eq!(utc(turn_s + 18), 1_483_228_800);
        assert_eq!(utc(1_800_000_000 - GPS_EPOCH_S + 18), 1_800_000_000);
        assert_eq!(TimeScale::Own.to_utc(Time::ZERO), Time::ZERO);
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
