//! Sensor of a finding.

use std::fmt;

use serde::{Serialize, Serializer};

/// Sensor of a finding, or a result computed from the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sensor {
    /// Gyros and accelerometers. Includes most findings on the attitude that the inertial unit computes, except those
    /// of [`UnitAttitude`](Self::UnitAttitude) and [`UnitHeading`](Self::UnitHeading).
    InertialUnit,
    /// The attitude that the inertial unit computes, if its set-up is wrong.
    UnitAttitude,
    /// The heading that the inertial unit computes, if the filter rejects it.
    UnitHeading,
    /// The GPS receiver.
    Gps,
    /// The receiver's velocity, if its set-up is wrong.
    GpsVelocity,
    /// A magnetometer, inside or outside the inertial unit.
    Magnetometer,
    /// A barometer.
    Barometer,
    /// A downward-looking rangefinder.
    Rangefinder,
    /// The pair of antennas that gives a heading.
    SecondAntenna,
    /// The clocks of inertial unit and receiver, compared with each other.
    Clocks,
    /// The vehicle's motion, which no single sensor shows.
    Vehicle,
    /// The filter, or the smoother.
    Filter,
}

impl Sensor {
    /// Name in `summary.json` and in sentences. Programs depend on it: it never changes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::InertialUnit => "inertial unit",
            Self::UnitAttitude => "unit's own attitude",
            Self::UnitHeading => "unit's own heading",
            Self::Gps => "gps",
            Self::GpsVelocity => "gps velocity",
            Self::Magnetometer => "magnetometer",
            Self::Barometer => "barometer",
            Self::Rangefinder => "rangefinder",
            Self::SecondAntenna => "second antenna",
            Self::Clocks => "clocks",
            Self::Vehicle => "vehicle",
            Self::Filter => "filter",
        }
    }
}

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Sensor {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
