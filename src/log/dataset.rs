//! A dataset directory: `dataset.toml`, `imu.csv` and whatever lies beside them.

use crate::dmu::ImuSample;
use crate::frames::{Body, Vector};
use crate::gps::Fix;
use crate::time::Time;

/// A recorded flight in memory, in time order, and what was wrong with its files.
#[derive(Clone, Debug, Default)]
pub struct Dataset {
    /// What it is and how it was mounted.
    pub manifest: Manifest,
    /// Inertial samples, times strictly increasing.
    pub imu: Vec<ImuSample>,
    /// Fixes, times of validity strictly increasing.
    pub fixes: Vec<Fix>,
    /// Barometric heights, m.
    pub baro: Vec<(Time, f64)>,
    /// Samples of a magnetometer apart from the inertial unit, gauss.
    pub magnetometer: Vec<(Time, Vector<Body>)>,
    /// Stick positions: lateral, longitudinal, collective, pedal, each −1…1 about trim.
    pub controls: Vec<(Time, [f64; 4])>,
    /// What was repaired or left out while reading, one plain sentence each.
    pub warnings: Vec<String>,
}

/// `dataset.toml`: what the vehicle and its sensors are. Every key has a default.
#[derive(Clone, Debug, Default)]
pub struct Manifest {
    /// Name of the dataset.
    pub name: String,
}
