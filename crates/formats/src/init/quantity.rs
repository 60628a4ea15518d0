//! Quantities in the columns of a file.

use crate::text::HeightAbove;

/// The quantity in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Time,
    Date,
    /// The week of GPS time.
    Week,
    /// Angular rate about an axis.
    Gyro(usize),
    /// Specific force along an axis.
    Accel(usize),
    /// Gravity alone along an axis.
    Gravity(usize),
    /// Increment of angle about an axis.
    AngleIncrement(usize),
    /// Increment of velocity along an axis.
    VelocityIncrement(usize),
    Mag(usize),
    /// Roll, pitch, yaw.
    Attitude(usize),
    /// Scalar first.
    Quaternion(usize),
    Latitude,
    Longitude,
    Height(Option<HeightAbove>),
    /// Height of the geoid above the ellipsoid.
    Undulation,
    /// North, east, down.
    Velocity(usize),
    /// East, north, up, of a message that has only a velocity.
    Twist(usize),
    Up,
    Speed,
    Course,
    SigmaHorizontal,
    SigmaVertical,
    SigmaSpeed,
    SigmaVerticalSpeed,
    /// One-sigma of the position north, east, down.
    SigmaPosition(usize),
    /// One-sigma of the velocity north, east, down.
    SigmaVelocity(usize),
    FixType,
    Satellites,
    Pressure,
    BaroHeight,
    /// Lateral, longitudinal, collective, pedal.
    Stick(usize),
}

impl Quantity {
    /// Whether the quantity is one of a receiver's fix.
    pub(super) const fn is_of_receiver(self) -> bool {
        matches!(
            self,
            Self::Latitude
                | Self::Longitude
                | Self::Height(_)
                | Self::Undulation
                | Self::Velocity(_)
                | Self::Up
                | Self::Speed
                | Self::Course
                | Self::FixType
                | Self::Satellites
        ) || self.is_sigma()
    }

    /// Whether the quantity is a one-sigma of a position or velocity.
    pub(super) const fn is_sigma(self) -> bool {
        matches!(
            self,
            Self::SigmaHorizontal
                | Self::SigmaVertical
                | Self::SigmaSpeed
                | Self::SigmaVerticalSpeed
                | Self::SigmaPosition(_)
                | Self::SigmaVelocity(_)
        )
    }
}
