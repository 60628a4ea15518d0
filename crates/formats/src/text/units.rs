//! Units of foreign files, each with its factor to hovernav's unit.

use std::f64::consts::PI;

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use serde::{Deserialize, Serialize};

/// An enumeration of units, each with its name in a mapping and its factor.
macro_rules! units {
    ($(#[$doc:meta])* $unit:ident { $($(#[$about:meta])* $name:ident = $text:literal, $factor:expr;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
        pub enum $unit {
            $($(#[$about])* #[serde(rename = $text)] $name,)*
        }

        impl $unit {
            /// Factor from this unit to hovernav's unit.
            #[must_use]
            pub fn factor(self) -> f64 {
                match self {
                    $(Self::$name => $factor,)*
                }
            }

            /// The name in a mapping.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)*
                }
            }
        }
    };
}

units! {
    /// Units of gyros, converted to rad/s; angle increments to rad.
    RateUnit {
        /// Radians per second.
        #[default]
        RadiansPerSecond = "rad/s", 1.0;
        /// Degrees per second.
        DegreesPerSecond = "deg/s", PI / 180.0;
        /// Milliradians per second.
        MilliradiansPerSecond = "mrad/s", 1e-3;
        /// Thousandths of a degree per second.
        MillidegreesPerSecond = "mdeg/s", PI / 180_000.0;
        /// Hundredths of a degree per second.
        CentidegreesPerSecond = "cdeg/s", PI / 18_000.0;
        /// Degrees per hour.
        DegreesPerHour = "deg/h", PI / 648_000.0;
        /// Revolutions per minute.
        RevolutionsPerMinute = "rpm", PI / 30.0;
        /// Radians turned since the row before.
        Radians = "rad", 1.0;
        /// Degrees turned since the row before.
        Degrees = "deg", PI / 180.0;
    }
}

units! {
    /// Units of accelerometers, converted to m/s²; velocity increments to m/s.
    ForceUnit {
        /// Metres per second squared.
        #[default]
        MetresPerSecondSquared = "m/s2", 1.0;
        /// Standard gravity.
        Gravity = "g", STANDARD_GRAVITY_MPS2;
        /// Thousandths of standard gravity.
        Milligravity = "mg", STANDARD_GRAVITY_MPS2 * 1e-3;
        /// Centimetres per second squared.
        CentimetresPerSecondSquared = "cm/s2", 1e-2;
        /// Feet per second squared.
        FeetPerSecondSquared = "ft/s2", 0.3048;
        /// Velocity gained since the row before, metres per second.
        MetresPerSecond = "m/s", 1.0;
    }
}

units! {
    /// Units of magnetometers, converted to gauss.
    MagneticUnit {
        /// Gauss.
        #[default]
        Gauss = "gauss", 1.0;
        /// Milligauss.
        Milligauss = "mG", 1e-3;
        /// Microtesla.
        Microtesla = "uT", 1e-2;
        /// Nanotesla.
        Nanotesla = "nT", 1e-5;
        /// Tesla.
        Tesla = "T", 1e4;
    }
}

units! {
    /// Units of attitude, converted to radians.
    AngleUnit {
        /// Degrees.
        #[default]
        Degrees = "deg", PI / 180.0;
        /// Radians.
        Radians = "rad", 1.0;
    }
}

units! {
    /// Units of latitude and longitude, converted to degrees.
    PlaceUnit {
        /// Degrees.
        #[default]
        Degrees = "deg", 1.0;
        /// Radians.
        Radians = "rad", 180.0 / PI;
        /// Degrees times ten million.
        ScaledDegrees = "deg1e7", 1e-7;
        /// Degrees and minutes in one number, ddmm.mmmm, as in NMEA 0183; the factor is for whole degrees.
        DegreesMinutes = "ddmm", 1e-2;
        /// Earth-centred x and y instead of latitude and longitude.
        EarthCentred = "ecef", 1.0;
    }
}

impl PlaceUnit {
    /// Converts `value` to degrees.
    #[must_use]
    pub fn degrees(self, value: f64) -> f64 {
        match self {
            Self::DegreesMinutes => {
                let whole = (value / 100.0).trunc();
                whole + (value - 100.0 * whole) / 60.0
            }
            _ => value * self.factor(),
        }
    }
}

units! {
    /// Units of length, converted to metres.
    LengthUnit {
        /// Metres.
        #[default]
        Metres = "m", 1.0;
        /// Centimetres.
        Centimetres = "cm", 1e-2;
        /// Millimetres.
        Millimetres = "mm", 1e-3;
        /// Feet.
        Feet = "ft", 0.3048;
    }
}

units! {
    /// Units of speed, converted to m/s.
    SpeedUnit {
        /// Metres per second.
        #[default]
        MetresPerSecond = "m/s", 1.0;
        /// Centimetres per second.
        CentimetresPerSecond = "cm/s", 1e-2;
        /// Millimetres per second.
        MillimetresPerSecond = "mm/s", 1e-3;
        /// Kilometres per hour.
        KilometresPerHour = "km/h", 1.0 / 3.6;
        /// Knots.
        Knots = "kn", 1852.0 / 3600.0;
        /// Miles per hour.
        MilesPerHour = "mph", 1609.344 / 3600.0;
        /// Feet per second.
        FeetPerSecond = "ft/s", 0.3048;
        /// Feet per minute, of vertical speeds.
        FeetPerMinute = "ft/min", 0.3048 / 60.0;
    }
}

units! {
    /// Units of course, converted to radians.
    CourseUnit {
        /// Degrees.
        #[default]
        Degrees = "deg", PI / 180.0;
        /// Radians.
        Radians = "rad", 1.0;
        /// Hundredths of a degree.
        Centidegrees = "cdeg", PI / 18_000.0;
        /// Degrees times a hundred thousand.
        ScaledDegrees = "deg1e5", PI / 18_000_000.0;
    }
}

units! {
    /// Units of barometers: heights are converted to metres, pressures to pascals.
    BaroUnit {
        /// Metres.
        #[default]
        Metres = "m", 1.0;
        /// Feet.
        Feet = "ft", 0.3048;
        /// Centimetres.
        Centimetres = "cm", 1e-2;
        /// Pascals.
        Pascals = "Pa", 1.0;
        /// Hectopascals, the same as millibars.
        Hectopascals = "hPa", 1e2;
        /// Kilopascals.
        Kilopascals = "kPa", 1e3;
        /// Inches of mercury.
        InchesOfMercury = "inHg", 3386.389;
    }
}

units! {
    /// Units of stick positions, converted to fractions of full travel about trim.
    StickUnit {
        /// Fraction of full travel, −1 to 1.
        #[default]
        Fraction = "fraction", 1.0;
        /// Percent of full travel, −100 to 100.
        Percent = "percent", 1e-2;
    }
}

impl RateUnit {
    /// Whether rows contain increments since the row before.
    #[must_use]
    pub const fn is_increment(self) -> bool {
        matches!(self, Self::Radians | Self::Degrees)
    }
}

impl ForceUnit {
    /// Whether rows contain increments since the row before.
    #[must_use]
    pub const fn is_increment(self) -> bool {
        matches!(self, Self::MetresPerSecond)
    }
}

impl BaroUnit {
    /// Whether the unit is one of pressure.
    #[must_use]
    pub const fn is_pressure(self) -> bool {
        matches!(
            self,
            Self::Pascals | Self::Hectopascals | Self::Kilopascals | Self::InchesOfMercury
        )
    }
}

/// Reference surface of a height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightAbove {
    /// The WGS-84 ellipsoid.
    #[default]
    Ellipsoid,
    /// Mean sea level.
    Sea,
}

/// The navigation axes of an attitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum World {
    /// North, east, down; the vehicle's axes are forward, right, down.
    #[default]
    Ned,
    /// East, north, up; the vehicle's axes are forward, left, up.
    Enu,
}

/// Source of an attitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AttitudeRole {
    /// The IMU, whose attitude the filter may use.
    #[default]
    Unit,
    /// An estimator that ran during the flight, for comparison only.
    Onboard,
}

impl HeightAbove {
    /// The name in a mapping.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ellipsoid => "ellipsoid",
            Self::Sea => "sea",
        }
    }
}

impl World {
    /// The name in a mapping.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ned => "ned",
            Self::Enu => "enu",
        }
    }
}

impl AttitudeRole {
    /// The name in a mapping.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unit => "unit",
            Self::Onboard => "onboard",
        }
    }
}
