//! Beginning of a record.

use crate::setup::FlyConfig;
use hovernav::ekf::EstimatorConfig;
use hovernav::time::Time;
use hovernav_dataset::LogError;

/// Beginning of a record: all that a replay needs in addition to the raw bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// The flight's configuration, with the magnetic declination as a number.
    pub config: FlyConfig,
    /// Start of the sensors on the flight's clock: the `now` of
    /// [`Sensors::new`](hovernav::sensors::Sensors::new).
    pub start: Time,
    /// Start of the flight in ns since the start of 1970, UTC, as accurately as it is known.
    pub start_unix_ns: i64,
    /// Version of the recording program.
    pub version: String,
}

impl Header {
    /// Header of a flight that starts at `start`. If `config` has no declination, it is 0: in flight there is no time
    /// to compute it.
    #[must_use]
    pub fn new(mut config: FlyConfig, start: Time, start_unix_ns: i64) -> Self {
        config.navigation.imu.magnetic_declination_deg.get_or_insert(0.0);
        Self { config, start, start_unix_ns, version: env!("CARGO_PKG_VERSION").into() }
    }

    /// The estimator's settings, the same in flight and in replay.
    ///
    /// # Errors
    /// As [`Manifest::settings`](hovernav_dataset::Manifest::settings).
    pub fn settings(&self) -> Result<EstimatorConfig, LogError> {
        Ok(self.config.navigation.settings(true, None)?.0)
    }

    /// Conversion from the flight's clock to ns since the start of 1970, UTC; 0 for earlier times.
    pub(super) fn unix_ns(&self, time: Time) -> u64 {
        let since_start = time.nanoseconds().saturating_sub(self.start.nanoseconds());
        u64::try_from(self.start_unix_ns.saturating_add(since_start)).unwrap_or(0)
    }

    /// Inverse of [`unix_ns`](Self::unix_ns).
    pub(super) fn time(&self, unix_ns: u64) -> Time {
        let unix_ns = i64::try_from(unix_ns).unwrap_or(i64::MAX);
        let since_start = unix_ns.saturating_sub(self.start_unix_ns);
        Time::from_nanoseconds(self.start.nanoseconds().saturating_add(since_start))
    }
}
