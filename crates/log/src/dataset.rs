//! A recorded flight in memory.

use crate::controls::ControlFile;
use crate::error::LogError;
use crate::manifest::Manifest;
use crate::sample_file::SampleFile;
use hovernav::event::RangeReading;
use hovernav::frames::{Body, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::ImuSample;
use hovernav::time::Time;

/// What a dataset holds events of.
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

/// A recorded flight in memory, in time order, and what was wrong with its files.
#[derive(Clone, Debug, Default)]
pub struct Dataset {
    /// What it is and how it was mounted.
    pub manifest: Manifest,
    /// Inertial samples, times strictly increasing.
    pub imu: Vec<ImuSample>,
    /// Where the inertial samples are while there are too many for [`imu`](Self::imu), which is empty then: see
    /// [`open_within`](Self::open_within). Whoever goes over [`samples`](Self::samples) gets either.
    pub imu_file: Option<SampleFile>,
    /// Fixes, times of validity strictly increasing.
    pub fixes: Vec<Fix>,
    /// Barometric heights, m.
    pub baro: Vec<(Time, f64)>,
    /// Samples of a magnetometer apart from the inertial unit, gauss.
    pub magnetometer: Vec<(Time, Vector<Body>)>,
    /// Headings of two GPS antennas.
    pub headings: Vec<AntennaHeading>,
    /// Distances to the ground.
    pub ranges: Vec<RangeReading>,
    /// Speed of the rotor, Hz, for the notch that the manifest may ask for.
    pub rotor: Vec<(Time, f64)>,
    /// Stick positions: lateral, longitudinal, collective, pedal, each −1…1 about trim.
    pub controls: Vec<(Time, [f64; 4])>,
    /// What of each of the [`controls`](Self::controls) is a test input, injected beside whoever flies, in
    /// their order; empty where none was flown. In `controls.csv` they are `injected_lateral` and so on.
    pub injected: Vec<[f64; 4]>,
    /// Where the two before are while there are too many rows of them, and both are empty: see
    /// [`open_within`](Self::open_within). Whoever goes over [`each_control`](Self::each_control) gets either.
    pub controls_file: Option<ControlFile>,
    /// Which sensor's event came next, from the first to the last, as a flight record has it. Where
    /// it does not list as many as there are, events are taken in the order of their times.
    pub order: Vec<Source>,
    /// What was repaired or left out while reading, one plain sentence each.
    pub warnings: Vec<String>,
    /// What was chosen or taken for granted while reading, with nothing wrong: one plain sentence
    /// each.
    pub notes: Vec<String>,
}

impl Dataset {
    /// Hands the [`controls`](Self::controls) to `each`, one after another, from memory or from their file.
    ///
    /// # Errors
    /// A file that was changed since the dataset was opened, or that the system no longer gives.
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
