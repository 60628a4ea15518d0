//! What a record begins with.

use crate::error::LogError;
use crate::setup::FlyConfig;
use hovernav::ekf::EstimatorConfig;
use hovernav::time::Time;

/// What a record begins with: all that a replay needs beside the bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// The flight's configuration; the magnetic declination is a number.
    pub config: FlyConfig,
    /// When the sensors were started, on the flight's clock: the `now` of
    /// [`Sensors::new`](hovernav::sensors::Sensors::new).
    pub start: Time,
    /// The same moment in nanoseconds since the start of 1970, UTC, as well as it is known.
    pub start_unix_ns: i64,
    /// The version that records.
    pub version: String,
}

impl Header {
    /// The header of a flight that starts at `start`. A declination that `config` does not give is 0:
    /// in flight there is no time to look it up.
    #[must_use]
    pub fn new(mut config: FlyConfig, start: Time, start_unix_ns: i64) -> Self {
        config.navigation.imu.magnetic_declination_deg.get_or_insert(0.0);
        Self { config, start, start_unix_ns, version: env!("CARGO_PKG_VERSION").into() }
    }

    /// The estimator's settings, in flight as in replay.
    ///
    /// # Errors
    /// As [`Manifest::settings`](crate::Manifest::settings).
    pub fn settings(&self) -> Result<EstimatorConfig, LogError> {
        Ok(self.config.navigation.settings(true, None)?.0)
    }

    /// From the flight's clock to nanoseconds since the start of 1970, UTC; 0 before that.
    pub(super) fn unix_ns(&self, time: Time) -> u64 {
        let since_start = time.nanoseconds().saturating_sub(self.start.nanoseconds());
        u64::try_from(self.start_unix_ns.saturating_add(since_start)).unwrap_or(0)
    }

    /// Back from [`unix_ns`](Self::unix_ns).
    pub(super) fn time(&self, unix_ns: u64) -> Time {
        let unix_ns = i64::try_from(unix_ns).unwrap_or(i64::MAX);
        let since_start = unix_ns.saturating_sub(self.start_unix_ns);
        Time::from_nanoseconds(self.start.nanoseconds().saturating_add(since_start))
    }
}
