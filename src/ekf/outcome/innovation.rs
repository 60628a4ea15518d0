//! The result of an update, axis by axis.

use super::group::Group;
use crate::time::Time;

/// The quantity compared in a scalar update.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// Antenna position north, m.
    PositionNorth,
    /// Antenna position east, m.
    PositionEast,
    /// Antenna position down, m.
    PositionDown,
    /// Antenna velocity north, m/s.
    VelocityNorth,
    /// Antenna velocity east, m/s.
    VelocityEast,
    /// Antenna velocity down, m/s.
    VelocityDown,
    /// Roll of the inertial unit's own attitude, rad.
    Roll,
    /// Pitch of the inertial unit's own attitude, rad.
    Pitch,
    /// Heading of the inertial unit's own attitude or of the magnetometer, rad.
    Yaw,
    /// Barometric height, m, up.
    BaroHeight,
    /// Distance to the ground along the beam of a rangefinder, m.
    Range,
    /// Heading of the baseline between two GPS antennas, rad.
    BaselineHeading,
    /// Angular rate of a vehicle at rest, forward, rad/s.
    RestRateX,
    /// Angular rate of a vehicle at rest, right, rad/s.
    RestRateY,
    /// Angular rate of a vehicle at rest, down, rad/s.
    RestRateZ,
    /// Velocity of a vehicle at rest, north, m/s.
    RestVelocityNorth,
    /// Velocity of a vehicle at rest, east, m/s.
    RestVelocityEast,
    /// Velocity of a vehicle at rest, down, m/s.
    RestVelocityDown,
    /// Velocity of a vehicle on wheels across its road, right, m/s.
    WheelsRight,
    /// Velocity of a vehicle on wheels perpendicular to its road, down, m/s.
    WheelsDown,
    /// A row of a user's own sensor with the number [`Measurement::sensor`](crate::ekf::Measurement::sensor), in the unit of
    /// that row.
    Own(u8),
}

impl Channel {
    /// Whether the channel belongs to a fix: position or velocity.
    #[must_use]
    pub const fn is_of_fix(self) -> bool {
        self.group().is_of_fix()
    }

    /// The group with which the channel is accepted or rejected.
    pub(in crate::ekf) const fn group(self) -> Group {
        match self {
            Self::PositionNorth | Self::PositionEast => Group::HorizontalPosition,
            Self::PositionDown => Group::VerticalPosition,
            Self::VelocityNorth | Self::VelocityEast => Group::HorizontalVelocity,
            Self::VelocityDown => Group::VerticalVelocity,
            Self::Roll | Self::Pitch => Group::Tilt,
            Self::Yaw => Group::Heading,
            Self::BaroHeight => Group::Baro,
            Self::Range => Group::Range,
            Self::BaselineHeading => Group::BaselineHeading,
            Self::RestRateX | Self::RestRateY | Self::RestRateZ => Group::RestRate,
            Self::RestVelocityNorth | Self::RestVelocityEast | Self::RestVelocityDown => {
                Group::RestVelocity
            }
            Self::WheelsRight | Self::WheelsDown => Group::RestVelocity,
            Self::Own(_) => Group::Own,
        }
    }

    /// The channel's name in files, with its unit.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::PositionNorth => "position_north_m",
            Self::PositionEast => "position_east_m",
            Self::PositionDown => "position_down_m",
            Self::VelocityNorth => "velocity_north_mps",
            Self::VelocityEast => "velocity_east_mps",
            Self::VelocityDown => "velocity_down_mps",
            Self::Roll => "roll_rad",
            Self::Pitch => "pitch_rad",
            Self::Yaw => "yaw_rad",
            Self::BaroHeight => "baro_height_m",
            Self::Range => "range_m",
            Self::BaselineHeading => "baseline_heading_rad",
            Self::RestRateX => "rest_rate_x_radps",
            Self::RestRateY => "rest_rate_y_radps",
            Self::RestRateZ => "rest_rate_z_radps",
            Self::RestVelocityNorth => "rest_velocity_north_mps",
            Self::RestVelocityEast => "rest_velocity_east_mps",
            Self::RestVelocityDown => "rest_velocity_down_mps",
            Self::WheelsRight => "wheels_right_mps",
            Self::WheelsDown => "wheels_down_mps",
            Self::Own(_) => "own",
        }
    }
}

/// The outcome of a scalar update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The measurement corrected the state.
    Accepted,
    /// The innovation lay outside the gate; the state is unchanged.
    Rejected,
    /// The filter had rejected the sensor for too long and was reset to the measurement.
    Reset,
}

/// One scalar update: measured minus predicted, the expected one-sigma, and the outcome.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// The measurement's time of validity.
    pub time: Time,
    /// The quantity compared.
    pub channel: Channel,
    /// Measured minus predicted, in the channel's unit.
    pub innovation: f64,
    /// Predicted one-sigma of the innovation, in the channel's unit.
    pub sigma: f64,
    /// Whether the measurement corrected the state, or why not.
    pub verdict: Verdict,
}

impl Innovation {
    /// The innovation divided by its predicted one-sigma. In a consistent filter, these quotients have a normal
    /// distribution with unit variance.
    #[must_use]
    pub fn normalised(&self) -> f64 {
        self.innovation / self.sigma
    }
}
