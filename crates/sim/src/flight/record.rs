//! A simulated flight.

use crate::Crash;
use hovernav::autopilot::{ExcitationAbort, Mode, Transition};
use hovernav::controls::Sticks;
use hovernav::ekf::Solution;
use hovernav::event::RangeReading;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::ImuSample;
use hovernav::time::Time;
use hovernav_dataset::{Dataset, Manifest, Truth};

/// One sample of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightSample {
    /// State of the centre of gravity.
    pub truth: Truth,
    /// The estimate, or the truth if the truth is the feedback. The autopilot uses the estimate without the jumps by
    /// corrections.
    pub solution: Option<Solution>,
    /// Mode of the autopilot.
    pub mode: Mode,
    /// Command of the sticks.
    pub sticks: Sticks,
    /// Test input in the command, flown by the autopilot or added by [`AddSticks`](super::FlightEvent::AddSticks).
    pub injected: Sticks,
    /// Positions of the servos.
    pub servos: Sticks,
    /// Wind until the next sample, m/s.
    pub wind_mps: Vector<Ned>,
}

/// A simulated flight.
#[derive(Clone, Debug)]
pub struct Flight {
    /// Description of the sensors.
    pub manifest: Manifest,
    /// Samples of the inertial unit.
    pub imu: Vec<ImuSample>,
    /// Fixes.
    pub fixes: Vec<Fix>,
    /// Barometric heights, m.
    pub baro: Vec<(Time, f64)>,
    /// Distances to the ground.
    pub ranges: Vec<RangeReading>,
    /// Headings of two antennas.
    pub headings: Vec<AntennaHeading>,
    /// One sample per inertial sample.
    pub samples: Vec<FlightSample>,
    /// All changes of mode.
    pub transitions: Vec<Transition>,
    /// Aborted test inputs: time, s, and reason.
    pub aborted: Vec<(f64, ExcitationAbort)>,
    /// Time of the crash, s, if it crashed; the flight ends there.
    pub crashed_s: Option<f64>,
    /// The crash, if it crashed.
    pub crash: Option<Crash>,
}

impl Flight {
    /// The recorded data as a dataset and the truth, for [`Dataset::write`].
    #[must_use]
    pub fn dataset(&self) -> (Dataset, Vec<Truth>) {
        let injected = self.samples.iter().map(|sample| sample.injected.to_array());
        let is_excited = self.samples.iter().any(|sample| sample.injected != Sticks::NEUTRAL);
        let dataset = Dataset {
            manifest: self.manifest.clone(),
            imu: self.imu.clone(),
            fixes: self.fixes.clone(),
            baro: self.baro.clone(),
            ranges: self.ranges.clone(),
            headings: self.headings.clone(),
            controls: self
                .samples
                .iter()
                .map(|sample| (sample.truth.time, sample.sticks.to_array()))
                .collect(),
            injected: injected.filter(|_| is_excited).collect(),
            ..Dataset::default()
        };
        (dataset, self.samples.iter().map(|sample| sample.truth).collect())
    }
}
