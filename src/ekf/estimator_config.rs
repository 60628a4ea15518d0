//! Settings of the whole estimator: mounting, alignment, filter, aids.

use super::config::{AntennaHeadingModel, EkfConfig, RangeModel};
use crate::frames::{Body, Vector};
use crate::ins::{AlignmentConfig, Mounting};

/// Settings of the whole estimator.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[non_exhaustive]
pub struct EstimatorConfig {
    /// Where the sensors are in the vehicle.
    pub mounting: Mounting,
    /// How it starts.
    pub alignment: AlignmentConfig,
    /// How it goes on.
    pub ekf: EkfConfig,
    /// Which aids beside GPS it uses, where there are any.
    pub aiding: Aiding,
    /// The rangefinder that looks at the ground.
    pub rangefinder: Rangefinder,
    /// Errors of the heading of two antennas; [`AlignmentConfig::baseline_m`] says where they are.
    pub antenna_heading: AntennaHeadingModel,
}

impl EstimatorConfig {
    /// With the sensors mounted like this.
    #[must_use]
    pub const fn with_mounting(mut self, mounting: Mounting) -> Self {
        self.mounting = mounting;
        self
    }

    /// With these settings of the alignment.
    #[must_use]
    pub const fn with_alignment(mut self, alignment: AlignmentConfig) -> Self {
        self.alignment = alignment;
        self
    }

    /// With these settings of the filter.
    #[must_use]
    pub const fn with_ekf(mut self, ekf: EkfConfig) -> Self {
        self.ekf = ekf;
        self
    }

    /// With these aids beside GPS.
    #[must_use]
    pub const fn with_aiding(mut self, aiding: Aiding) -> Self {
        self.aiding = aiding;
        self
    }

    /// With this rangefinder.
    #[must_use]
    pub const fn with_rangefinder(mut self, rangefinder: Rangefinder) -> Self {
        self.rangefinder = rangefinder;
        self
    }
}

/// A rangefinder: where it is, where it looks, and how good it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rangefinder {
    /// The sensor from the point of the solution, body axes, m.
    pub lever_arm_m: Vector<Body>,
    /// Where its beam leads, body axes, of length one; straight down where nothing is said.
    pub beam: Vector<Body>,
    /// What it measures, and how the ground varies.
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

/// Which aids beside GPS are used once aligned. To change some, take the default, all, and assign to
/// its fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Aiding {
    /// The inertial unit's own attitude.
    pub attitude: bool,
    /// Magnetic heading, where the unit's own attitude is not used.
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
