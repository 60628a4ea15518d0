//! Settings of the whole estimator: mounting, alignment, filter, aids.

use super::config::{
    AntennaHeadingModel, AttitudeModel, BaroModel, EkfConfig, GateConfig, GpsModel, ImuModel,
    MagnetometerModel, RangeModel,
};
use super::setting::{OutOfRange, Setting};
use super::vehicle_kind::VehicleKind;
use crate::frames::{Body, Vector};
use crate::ins::{AlignmentConfig, Mounting};

/// Settings of the whole estimator.
///
/// ```
/// use hovernav::prelude::*;
///
/// let imu = ImuModel::default().with_gyro_noise_degps_per_sqrt_hz(0.014).with_gyro_range_degps(2000.0);
/// let config = EstimatorConfig::default()
///     .with_imu(imu)
///     .with_mounting(Mounting::default().with_antenna_lever_arm_m(Vector::new(-0.35, 0.0, -0.2)));
/// assert!((config.ekf.imu.gyro_range_radps - 34.9).abs() < 0.1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct EstimatorConfig {
    /// Kind of the vehicle. Without it, the fixes show whether the vehicle rolls on wheels.
    pub vehicle_kind: Option<VehicleKind>,
    /// Positions of the sensors in the vehicle.
    pub mounting: Mounting,
    /// Settings of the alignment.
    pub alignment: AlignmentConfig,
    /// Settings of the filter.
    pub ekf: EkfConfig,
    /// Sensors in addition to GPS that are used, if present.
    pub aiding: Aiding,
    /// Rangefinder that points at the ground.
    pub rangefinder: Rangefinder,
    /// Errors of the heading of two antennas; [`AlignmentConfig::baseline_m`] gives their positions.
    pub antenna_heading: AntennaHeadingModel,
}

impl EstimatorConfig {
    /// Settings of the sensor models and gates, by group. The groups are the sections below `[filter]` in configuration
    /// files, except for `rangefinder.model` and `second_antenna.model`.
    pub const SETTINGS: &[(&str, &[Setting])] = &[
        ("imu", ImuModel::SETTINGS),
        ("gps", GpsModel::SETTINGS),
        ("attitude", AttitudeModel::SETTINGS),
        ("magnetometer", MagnetometerModel::SETTINGS),
        ("baro", BaroModel::SETTINGS),
        ("gate", GateConfig::SETTINGS),
        ("rangefinder.model", RangeModel::SETTINGS),
        ("second_antenna.model", AntennaHeadingModel::SETTINGS),
    ];

    /// First of the [`SETTINGS`](Self::SETTINGS) that is out of its range, if any.
    #[must_use]
    pub fn out_of_range(&self) -> Option<OutOfRange> {
        let EkfConfig { imu, gps, attitude, magnetometer, baro, gate, mechanisms: _ } = &self.ekf;
        [
            ("imu", imu.out_of_range()),
            ("gps", gps.out_of_range()),
            ("attitude", attitude.out_of_range()),
            ("magnetometer", magnetometer.out_of_range()),
            ("baro", baro.out_of_range()),
            ("gate", gate.out_of_range()),
            ("rangefinder.model", self.rangefinder.model.out_of_range()),
            ("second_antenna.model", self.antenna_heading.out_of_range()),
        ]
        .into_iter()
        .find_map(|(group, wrong)| {
            let (name, found, expected) = wrong?;
            Some(OutOfRange { group, name, found, expected })
        })
    }

    /// Sets the mounting of the sensors.
    #[must_use]
    pub const fn with_mounting(mut self, mounting: Mounting) -> Self {
        self.mounting = mounting;
        self
    }

    /// Sets the errors of the inertial sensors, `ekf.imu`.
    #[must_use]
    pub const fn with_imu(mut self, imu: ImuModel) -> Self {
        self.ekf.imu = imu;
        self
    }
}

/// A rangefinder: position, direction and errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rangefinder {
    /// Position of the sensor relative to the point of the solution, body axes, m.
    pub lever_arm_m: Vector<Body>,
    /// Direction of the beam, body axes, of length one; straight down by default.
    pub beam: Vector<Body>,
    /// Errors of the sensor, and variation of the ground height.
    pub model: RangeModel,
}

impl Default for Rangefinder {
    fn default() -> Self {
        Self {
            lever_arm_m: Vector::ZERO,
            beam: Vector::new(0.0, 0.0, 1.0),
            model: RangeModel::default(),
        }
    }
}

/// Sensors in addition to GPS that are used after alignment. The default is all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Aiding {
    /// The inertial unit's own attitude.
    pub attitude: bool,
    /// Magnetic heading, while the inertial unit's own attitude is not used.
    pub magnetometer: bool,
    /// Barometric height.
    pub baro: bool,
    /// Distance to the ground.
    pub rangefinder: bool,
    /// Heading of two GPS antennas.
    pub second_antenna: bool,
}

impl Default for Aiding {
    fn default() -> Self {
        Self {
            attitude: true,
            magnetometer: true,
            baro: true,
            rangefinder: true,
            second_antenna: true,
        }
    }
}
