//! Settings of the whole estimator: mounting, alignment, filter, aids.

use super::config::EkfConfig;
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
}

impl Default for Aiding {
    fn default() -> Self {
        Self { attitude: true, magnetometer: true, baro: true }
    }
}
