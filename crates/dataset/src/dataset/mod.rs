//! A recorded flight in memory.

pub(crate) mod events;
pub(crate) mod open;
pub(crate) mod outage;
pub(crate) mod samples;
pub(crate) mod settings;
pub(crate) mod size;
pub(crate) mod write;

use crate::error::LogError;
use crate::manifest::Manifest;
use crate::sensors::controls::ControlFile;
use crate::sensors::sample_file::SampleFile;
use hovernav::event::RangeReading;
use hovernav::frames::{Body, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::ImuSample;
use hovernav::time::Time;

/// Kind of event in a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// [`Dataset::imu`].
    Imu,
    /// [`Dataset::fixes`].
    Gps,
    /// [`Dataset::baro`].
    Baro,
    /// [`Dataset::magnetometer`].
    Magnetometer,
    /// [`Dataset::headings`].
    AntennaHeading,
    /// [`Dataset::ranges`].
    Range,
}

/// A recorded flight in memory, in time order, with the defects of its files.
#[derive(Clone, Debug, Default)]
pub struct Dataset {
    /// Description of the dataset and its mounting.
    pub manifest: Manifest,
    /// Inertial samples, times strictly increasing.
    pub imu: Vec<ImuSample>,
    /// File of the inertial samples if there are too many for [`imu`](Self::imu), which is then empty: see
    /// [`open_within`](Self::open_within). [`samples`](Self::samples) iterates over either.
    pub imu_file: Option<SampleFile>,
    /// Fixes, times of validity strictly increasing.
    pub fixes: Vec<Fix>,
    /// Barometric heights, m.
    pub baro: Vec<(Time, f64)>,
    /// Samples of a magnetometer outside the inertial unit, gauss.
    pub magnetometer: Vec<(Time, Vector<Body>)>,
    /// Headings of two GPS antennas.
    pub headings: Vec<AntennaHeading>,
    /// Distances to the ground.
    pub ranges: Vec<RangeReading>,
    /// Rotor speed, Hz, for the optional notch filter of the manifest.
    pub rotor: Vec<(Time, f64)>,
    /// Stick positions: lateral, longitudinal, collective, pedal, each −1…1 about trim.
    pub controls: Vec<(Time, [f64; 4])>,
    /// Injected test input in each of the [`controls`](Self::controls), in their order; empty without test inputs.
    /// Columns `injected_lateral` and so on in `controls.csv`.
    pub injected: Vec<[f64; 4]>,
    /// File that replaces `controls` and `injected` if they have too many rows; both are then empty: see
    /// [`open_within`](Self::open_within). [`each_control`](Self::each_control) iterates over either.
    pub controls_file: Option<ControlFile>,
    /// Source of each event in the order of a flight record. If the number of entries differs from that of the events,
    /// the events are ordered by time.
    pub order: Vec<Source>,
    /// Repairs and skipped rows during reading, one plain sentence each.
    pub warnings: Vec<String>,
    /// Choices and assumptions during reading, without any defect; one plain sentence each.
    pub notes: Vec<String>,
}

impl Dataset {
    /// Passes the [`controls`](Self::controls) to `each`, one after another, from memory or from their file.
    ///
    /// # Errors
    /// A file that has changed since the dataset was opened, or that can no longer be read.
    pub fn each_control(&self, mut each: impl FnMut(Time, [f64; 4])) -> Result<(), LogError> {
        match &self.controls_file {
            Some(file) => file.each(each),
            None => {
                self.controls.iter().for_each(|&(time, sticks)| each(time, sticks));
                Ok(())
            }
        }
    }
}
