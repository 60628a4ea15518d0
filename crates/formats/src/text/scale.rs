//! Time scales and leap seconds.

use serde::{Deserialize, Serialize};

use crate::utc::{GPS_EPOCH_S, of_gps};
use hovernav::time::Time;

/// Time scale of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeScale {
    /// The logger's own clock, or UTC since 1970.
    #[default]
    Own,
    /// GPS time since 6 January 1980, or as a date and time of day, without leap seconds. It is converted to UTC since
    /// 1970.
    Gps,
}

impl TimeScale {
    /// Whether this is the default scale, which a mapping does not list.
    pub fn is_own(&self) -> bool {
        *self == Self::Own
    }

    /// Converts `time` from this scale to UTC; [`Own`](Self::Own) is unchanged. `is_dated` means that `time` is from a
    /// date, and so counts from 1970.
    pub fn to_utc(self, time: Time, is_dated: bool) -> Time {
        let since_1980 = if is_dated { GPS_EPOCH_S * 1_000_000_000 } else { 0 };
        match self {
            Self::Own => time,
            Self::Gps => Time::from_nanoseconds(of_gps(time.nanoseconds() - since_1980)),
        }
    }
}
