//! One stream of everything the sensors say, in order of arrival.

use crate::frames::{Body, Vector};
use crate::gps::{AntennaHeading, Fix};
use crate::imu::ImuSample;
use crate::time::Time;

/// Something a sensor said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A sample of the inertial unit.
    Imu(ImuSample),
    /// A satellite fix.
    Gps(Fix),
    /// A barometric height above any fixed level, m, up.
    Baro {
        /// When it was true.
        time: Time,
        /// Height, m.
        height_m: f64,
    },
    /// A magnetometer apart from the inertial unit.
    Magnetometer {
        /// When it was true.
        time: Time,
        /// Magnetic field in body axes, gauss.
        field_gauss: Vector<Body>,
    },
    /// The heading of two GPS antennas.
    AntennaHeading(AntennaHeading),
    /// A distance to the ground.
    Range(RangeReading),
}

/// What a rangefinder that looks at the ground says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeReading {
    /// When it was true.
    pub time: Time,
    /// Distance along the beam, from the sensor to what it hits, m.
    pub range_m: f64,
    /// Its one-sigma, m, where the sensor tells.
    pub sigma_m: Option<f64>,
    /// How good the sensor takes it to be, from 0, not valid, to 1, where it tells.
    pub quality: Option<f64>,
}

impl RangeReading {
    /// A distance of which the sensor says no more.
    #[must_use]
    pub const fn new(time: Time, range_m: f64) -> Self {
        Self { time, range_m, sigma_m: None, quality: None }
    }

    /// Whether its numbers can be a rangefinder's: distance and one-sigma from 0 to 10 km, quality from 0 to 1.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        // Written so that a NaN is refused.
        let can_be = |value: f64| (0.0..LONGEST_RANGE_M).contains(&value);
        can_be(self.range_m)
            && self.sigma_m.is_none_or(can_be)
            && self.quality.is_none_or(|quality| (0.0..=1.0).contains(&quality))
    }
}

/// No rangefinder reads as much, m.
const LONGEST_RANGE_M: f64 = 1e4;
/// No barometric height is further from zero, m.
const HIGHEST_M: f64 = 1e5;

/// Whether a number can be a barometric height, m: finite and within 100 km of zero.
#[must_use]
pub fn is_possible_height(height_m: f64) -> bool {
    // Written so that a NaN is refused.
    (-HIGHEST_M..=HIGHEST_M).contains(&height_m)
}

impl Event {
    /// When what it says was true.
    #[must_use]
    pub fn time(&self) -> Time {
        match self {
            Self::Imu(sample) => sample.time,
            Self::Gps(fix) => fix.time,
            Self::AntennaHeading(heading) => heading.time,
            Self::Range(reading) => reading.time,
            Self::Baro { time, .. } | Self::Magnetometer { time, .. } => *time,
        }
    }
}
