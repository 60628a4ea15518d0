//! Time scales and leap seconds.

use serde::{Deserialize, Serialize};

use crate::utc::of_gps;
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

impl TimeScale {
    /// Whether this is the default scale, which a mapping does not list.
    pub fn is_own(&self) -> bool {
        *self == Self::Own
    }

    /// Converts `time` from this scale to UTC; [`Own`](Self::Own) is unchanged.
    pub fn to_utc(self, time: Time) -> Time {
        match self {
            Self::Own => time,
            Self::Gps => Time::from_nanoseconds(of_gps(time.nanoseconds())),
        }
    }
}
