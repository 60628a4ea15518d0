//! Whose a finding is.

use std::fmt;

use serde::{Serialize, Serializer};

/// Whose a finding is: a sensor, or what is made of the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sensor {
    /// Gyros and accelerometers. What happens to the unit's own attitude is told of it too, but for the two below.
    InertialUnit,
    /// The attitude that the inertial unit computes, where the set-up of it cannot be.
    UnitAttitude,
    /// The heading of that attitude, where the filter refuses it.
    UnitHeading,
    /// The receiver of the fixes.
    Gps,
    /// The receiver's velocity, where the set-up of it cannot be.
    GpsVelocity,
    /// A magnetometer, in the inertial unit or apart from it.
    Magnetometer,
    /// A barometer.
    Barometer,
    /// A rangefinder that looks down.
    Rangefinder,
    /// The two antennas that give a heading.
    SecondAntenna,
    /// The clocks of inertial unit and receiver against each other.
    Clocks,
    /// How the vehicle moves, which no sensor tells alone.
    Vehicle,
    /// The filter, or the smoother.
    Filter,
}

impl Sensor {
    /// What it is called, in `summary.json` and in sentences. Programs go by it: it never changes.
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
