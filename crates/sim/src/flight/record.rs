//! A flight flown.

use hovernav::autopilot::{ExcitationAbort, Mode, Transition};
use hovernav::controls::Sticks;
use hovernav::ekf::Solution;
use hovernav::event::RangeReading;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::ImuSample;
use hovernav::time::Time;
use hovernav_log::{Dataset, Manifest, Truth};

/// One sample of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightSample {
    /// The centre of gravity.
    pub truth: Truth,
    /// The estimate, which the autopilot flies on without its steps; the truth where it flies on that.
    pub solution: Option<Solution>,
    /// What it was doing.
    pub mode: Mode,
    /// Its command.
    pub sticks: Sticks,
    /// What of it is a test input: of the autopilot's, or added to whoever flies.
    pub injected: Sticks,
    /// Where the servos stood.
    pub servos: Sticks,
    /// The wind until the next sample, m/s.
    pub wind_mps: Vector<Ned>,
}

/// A flight flown.
#[derive(Clone, Debug)]
pub struct Flight {
    /// What the sensors were.
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
    /// What happened, one sample per inertial sample.
    pub samples: Vec<FlightSample>,
    /// Every change of mode.
    pub transitions: Vec<Transition>,
    /// Test inputs that ended before their time: when, s, and why.
    pub aborted: Vec<(f64, ExcitationAbort)>,
    /// When it crashed, s, if it did: the flight ends there.
    pub crashed_s: Option<f64>,
}

impl Flight {
    /// Everything that was recorded, as a dataset and the truth about it, for
    /// [`Dataset::write`].
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
