//! A log in memory, and the options for reading it.

use crate::format::Format;
use crate::onboard::Onboard;
use hovernav_dataset::Dataset;
#[cfg(feature = "record")]
use hovernav_record::Record;

/// Choices among the sensors of a log, and limits.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Options {
    /// Number of the IMU, as the log numbers its IMUs. Default: the first, or one with many more samples.
    pub imu: Option<usize>,
    /// Number of the GPS receiver; default as for `imu`.
    pub gps: Option<usize>,
    /// Number of the magnetometer; default as for `imu`.
    pub magnetometer: Option<usize>,
    /// Number of the barometer; default as for `imu`.
    pub baro: Option<usize>,
    /// Name of the signal that moves the vehicle, as in `RATE` or `vehicle_torque_setpoint`. Default: the moving signal
    /// that is nearest to the actuators.
    pub input: Option<String>,
    /// Name of the ROS 2 topic with the receiver's velocity, or `none`. Default: a topic with a receiver's name, with
    /// the frame of the fixes, or with one message per fix.
    pub velocity: Option<String>,
    /// Largest number of inertial samples of a dataset directory, and of rows of its `controls.csv`, that are kept in
    /// memory. If there are more, all stay in their file: see [`Dataset::open_within`]. Default: all in memory, as for
    /// every other format.
    pub samples_in_memory: Option<usize>,
}

/// A log in memory.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Log {
    /// Format of the log.
    pub format: Format,
    /// Measurements of the sensors.
    pub dataset: Dataset,
    /// The flight record, if the log is one.
    #[cfg(feature = "record")]
    pub record: Option<Record>,
    /// Solution of the onboard estimator, if the log contains one.
    pub onboard: Option<Onboard>,
}

impl Log {
    /// Log of `format` that is no flight record.
    pub(crate) const fn of(format: Format, dataset: Dataset, onboard: Option<Onboard>) -> Self {
        Self {
            format,
            dataset,
            #[cfg(feature = "record")]
            record: None,
            onboard,
        }
    }

    /// A log of measurements that come from no file.
    #[must_use]
    pub const fn of_dataset(dataset: Dataset) -> Self {
        Self::of(Format::Dataset, dataset, None)
    }
}
