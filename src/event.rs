//! Events: one stream of all sensor measurements, in the order of arrival.

use crate::frames::{Body, Vector};
use crate::gps::{AntennaHeading, Fix};
use crate::imu::ImuSample;
use crate::time::Time;

/// A measurement of a sensor. Each variant holds the reading of one kind of sensor, with its time of validity.
///
/// For a sensor of another kind, implement [`Measurement`](crate::ekf::Measurement).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A sample of the inertial unit.
    Imu(ImuSample),
    /// A satellite fix.
    Gps(Fix),
    /// A barometric height.
    Baro(BaroReading),
    /// The magnetic field from a magnetometer separate from the inertial unit.
    Magnetometer(MagneticReading),
    /// The heading of two GPS antennas.
    AntennaHeading(AntennaHeading),
    /// A distance to the ground.
    Range(RangeReading),
}

/// A measurement of a barometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaroReading {
    /// Time of validity.
    pub time: Time,
    /// Height above any fixed level, m, up; valid within ±100 km.
    pub height_m: f64,
}

impl BaroReading {
    /// A height above any fixed level, m, up.
    #[must_use]
    pub const fn new(time: Time, height_m: f64) -> Self {
        Self { time, height_m }
    }

    /// Whether the height is finite and within 100 km of zero.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        is_possible_height(self.height_m)
    }
}

/// A measurement of a magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagneticReading {
    /// Time of validity.
    pub time: Time,
    /// Magnetic field in body axes, gauss.
    pub field_gauss: Vector<Body>,
}

impl MagneticReading {
    /// A magnetic field in body axes, gauss.
    #[must_use]
    pub const fn new(time: Time, field_gauss: Vector<Body>) -> Self {
        Self { time, field_gauss }
    }
}

/// A measurement of a rangefinder that looks at the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeReading {
    /// Time of validity.
    pub time: Time,
    /// Distance along the beam, from the sensor to the reflecting surface, m.
    pub range_m: f64,
    /// One-sigma of the distance, m, where the sensor reports it.
    pub sigma_m: Option<f64>,
    /// Quality reported by the sensor, from 0, invalid, to 1; `None` where it reports no quality.
    pub quality: Option<f64>,
}

impl RangeReading {
    /// A distance without one-sigma and quality.
    #[must_use]
    pub const fn new(time: Time, range_m: f64) -> Self {
        Self { time, range_m, sigma_m: None, quality: None }
    }

    /// Whether the values are possible for a rangefinder: distance and one-sigma from 0 to 10 km, quality from 0 to 1.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        // Written so that a NaN is rejected.
        let can_be = |value: f64| (0.0..LONGEST_RANGE_M).contains(&value);
        can_be(self.range_m)
            && self.sigma_m.is_none_or(can_be)
            && self.quality.is_none_or(|quality| (0.0..=1.0).contains(&quality))
    }
}

/// Upper limit of a rangefinder's distance, m.
const LONGEST_RANGE_M: f64 = 1e4;
/// Largest distance of a barometric height from zero, m.
const HIGHEST_M: f64 = 1e5;

/// Whether a number can be a barometric height, m: finite and within 100 km of zero.
pub(crate) fn is_possible_height(height_m: f64) -> bool {
    // Written so that a NaN is rejected.
    (-HIGHEST_M..=HIGHEST_M).contains(&height_m)
}

impl Event {
    /// Time of validity of the measurement.
    #[must_use]
    pub fn time(&self) -> Time {
        match self {
            Self::Imu(sample) => sample.time,
            Self::Gps(fix) => fix.time,
            Self::AntennaHeading(heading) => heading.time,
            Self::Range(reading) => reading.time,
            Self::Baro(reading) => reading.time,
            Self::Magnetometer(reading) => reading.time,
        }
    }
}
