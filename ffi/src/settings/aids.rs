//! Settings of the rangefinder and of the second antenna.

use hovernav::ekf as core_ekf;
use hovernav::ekf::EstimatorConfig;
use hovernav::frames::Vector;

use super::mirror;
use crate::status::Fault;

/// Error model of a rangefinder and of the ground height.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RangeModel {
    /// Shortest distance that the sensor measures, m.
    pub least_m: f64,
    /// Longest distance that the sensor measures, m.
    pub most_m: f64,
    /// Smallest quality of a usable reading, 0 to 1.
    pub least_quality: f64,
    /// One-sigma of the white error, m, for a reading without an accuracy of its own.
    pub noise_m: f64,
    /// One-sigma of an additional error that grows with the distance, as a fraction of the distance.
    pub noise_share: f64,
    /// One-sigma of the change of ground height over a metre, m.
    pub ground_walk_m: f64,
}

/// Error model of the heading of two antennas.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AntennaHeadingModel {
    /// Shortest time between two updates, s.
    pub interval_s: f64,
    /// One-sigma of the heading, rad, for a reading without an accuracy of its own.
    pub sigma_rad: f64,
    /// Lower limit of the one-sigma of a heading, rad.
    pub floor_rad: f64,
    /// Fraction of the one-sigma that varies slowly, 0 to 1.
    pub wander_share: f64,
    /// Correlation time of the slow error, s.
    pub wander_time_s: f64,
    /// Largest difference between the measured and the mounted length of the baseline, m; beyond it the heading is
    /// rejected.
    pub length_tolerance_m: f64,
}

mirror!(RangeModel, core_ekf::RangeModel {
    least_m most_m least_quality noise_m noise_share ground_walk_m
});
mirror!(AntennaHeadingModel, core_ekf::AntennaHeadingModel {
    interval_s sigma_rad floor_rad wander_share wander_time_s length_tolerance_m
});

/// A rangefinder that looks at the ground.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Rangefinder {
    /// Position of the sensor relative to the reference point of the solution, body axes, m.
    pub lever_arm_m: [f64; 3],
    /// Unit vector along the beam, body axes; 0, 0, 1 is straight down.
    pub beam: [f64; 3],
    /// Error model of the sensor and of the ground.
    pub model: RangeModel,
}

/// The second of two GPS antennas that give a heading.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct SecondAntenna {
    /// Baseline: vector from the first antenna to the second, body axes, m; all zero if the heading is that of the
    /// vehicle itself.
    pub baseline_m: [f64; 3],
    /// Error model of the heading of the two antennas.
    pub model: AntennaHeadingModel,
}

impl Rangefinder {
    pub(super) fn of(core: &EstimatorConfig) -> Self {
        let core_ekf::Rangefinder { lever_arm_m, beam, model } = &core.rangefinder;
        Self { lever_arm_m: lever_arm_m.to_array(), beam: beam.to_array(), model: model.into() }
    }

    pub(super) fn put(&self, into: &mut EstimatorConfig) -> Result<(), Fault> {
        let beam = Vector::from(self.beam);
        let length = beam.norm();
        if !(0.99..=1.01).contains(&length) {
            return Err(Fault::new(&["rangefinder.beam"], length, "a vector of length 1"));
        }
        let into = &mut into.rangefinder;
        (into.lever_arm_m, into.beam) = (self.lever_arm_m.into(), beam);
        self.model.put(&mut into.model);
        Ok(())
    }
}

impl SecondAntenna {
    pub(super) fn of(core: &EstimatorConfig) -> Self {
        Self {
            baseline_m: core.alignment.baseline_m.unwrap_or_default().to_array(),
            model: (&core.antenna_heading).into(),
        }
    }

    pub(super) fn put(&self, into: &mut EstimatorConfig) {
        let is_mounted = self.baseline_m.iter().any(|component| *component != 0.0);
        into.alignment.baseline_m = is_mounted.then(|| self.baseline_m.into());
        self.model.put(&mut into.antenna_heading);
    }
}
