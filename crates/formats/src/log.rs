//! A log in memory, and what may be chosen of it.

use crate::format::Format;
use crate::onboard::Onboard;
use hovernav_log::Dataset;
use hovernav_log::record::Record;

/// What to take where a log leaves a choice.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Options {
    /// Which inertial unit, counted as the log counts them; unless given, the first or the one with
    /// most samples.
    pub imu: Option<usize>,
    /// Which GPS receiver, likewise.
    pub gps: Option<usize>,
    /// Which magnetometer, likewise.
    pub magnetometer: Option<usize>,
    /// Which barometer, likewise.
    pub baro: Option<usize>,
    /// Which topic of a ROS 2 log has the receiver's own velocity, by its name, or `none`; unless given, one
    /// that names a receiver, shares the fixes' frame or has a message for each fix.
    pub velocity: Option<String>,
    /// How many inertial samples of a dataset directory, and rows of its `controls.csv`, are held in memory, at most:
    /// of more, all stay in their file, see [`Dataset::open_within`]. Unless given, all are in memory, as those of any other format are.
    pub samples_in_memory: Option<usize>,
}

/// A log in memory.
#[derive(Debug)]
#[non_exhaustive]
pub struct Log {
    /// What it was.
    pub format: Format,
    /// What the sensors measured.
    pub dataset: Dataset,
    /// The flight record, where the log is one.
    pub record: Option<Record>,
    /// What the estimator on board said, where the log has it.
    pub onboard: Option<Onboard>,
}
