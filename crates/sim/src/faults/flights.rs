//! Flights into which faults are injected.

use std::path::{Path, PathBuf};

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav_dataset::{Dataset, LogError, Reference};

use super::injection::Log;
use super::measure::{Measures, measure};
use super::runner::estimate;
use crate::{DmuConfig, FlightPlan, GpsConfig, fly, sensor_manifest};

/// A flight for the injection of faults.
#[derive(Clone, Debug)]
pub enum Flight {
    /// A dataset directory, with or without a reference.
    Dataset(PathBuf),
    /// A simulated flight of 300 s with the thesis's sensors: test points, climbs, turns and hover; each seed gives
    /// another flight.
    Simulated,
}

/// A flight without faults, estimated and scored.
#[derive(Debug)]
pub struct Clean {
    /// Name of the flight.
    pub name: String,
    pub(super) seed: u64,
    /// Whether each seed gives another flight.
    pub(super) is_drawn: bool,
    pub(super) log: Log,
    pub(super) reference: Option<Reference>,
    /// Scores of the estimate.
    pub measures: Measures,
    pub(super) solutions: Vec<Solution>,
    pub(super) end_s: f64,
}

impl Flight {
    /// Name in tables.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Dataset(dir) => {
                dir.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
            }
            Self::Simulated => "simulated".into(),
        }
    }

    /// Whether each seed gives another flight.
    #[must_use]
    pub fn is_drawn(&self) -> bool {
        matches!(self, Self::Simulated)
    }

    /// The flight for `seed`, estimated without faults; `scratch` is a directory for temporary files. Barometer and
    /// rotor speed are read again from the flight's directory for every copy with faults.
    ///
    /// # Errors
    /// [`LogError`] where the flight cannot be read or written.
    pub fn clean(&self, seed: u64, scratch: &Path) -> Result<Clean, LogError> {
        let dir = match self {
            Self::Dataset(dir) => dir.clone(),
            Self::Simulated => {
                simulate(seed, scratch)?;
                scratch.to_path_buf()
            }
        };
        let dataset = Dataset::open(&dir)?;
        let reference = Reference::open(&dir, &dataset.manifest)?;
        let log = Log::open(&dir)?;
        let end_s = log.end_s();
        let (run, warnings) = estimate(dataset)?;
        let mut measures = measure(&run.solutions, reference.as_ref(), &[], end_s);
        measures.warnings = warnings;
        let solutions = run.solutions;
        let (name, is_drawn) = (self.name(), self.is_drawn());
        Ok(Clean { name, seed, is_drawn, log, reference, measures, solutions, end_s })
    }
}

/// A simulated flight of the thesis's helicopter, written as a dataset.
fn simulate(seed: u64, dir: &Path) -> Result<(), LogError> {
    let unusable = |reason: String| LogError::Unusable { path: dir.to_path_buf(), reason };
    let start = Geodetic::from_degrees(1.3521, 103.8198, 50.0)
        .ok_or_else(|| unusable("no position on Earth".into()))?;
    // The golden angle spreads the headings over the circle.
    let heading_rad = hovernav::frames::wrap_angle(2.399_963 * seed as f64);
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let trajectory = FlightPlan::test_flight(start, heading_rad)
        .build()
        .map_err(|error| unusable(error.to_string()))?;
    let recording =
        fly(&trajectory, &dmu, &gps, seed).map_err(|error| unusable(error.to_string()))?;
    let manifest = sensor_manifest("simulated helicopter".into(), &dmu, &gps);
    let dataset =
        Dataset { manifest, imu: recording.imu, fixes: recording.fixes, ..Dataset::default() };
    dataset.write(dir, &recording.truth)
}
