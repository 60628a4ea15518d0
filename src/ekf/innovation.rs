//! What happened at an update, axis by axis.

use crate::time::Time;

/// The quantity a scalar update compared.
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
    /// Roll of the unit's own attitude, rad.
    Roll,
    /// Pitch of the unit's own attitude, rad.
    Pitch,
    /// Heading of the unit's own attitude or of the magnetometer, rad.
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
    /// Velocity of a vehicle on wheels up or down from its road, down, m/s.
    WheelsDown,
}

impl Channel {
    /// Whether it is of a fix: position or velocity.
    #[must_use]
    pub const fn is_of_fix(self) -> bool {
        matches!(
            self,
            Self::PositionNorth
                | Self::PositionEast
                | Self::PositionDown
                | Self::VelocityNorth
                | Self::VelocityEast
                | Self::VelocityDown
        )
    }

    /// Its name in files, with its unit.
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
        }
    }
}

/// What became of a scalar update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It corrected the state.
    Accepted,
    /// Its innovation lay outside the gate; the state is untouched.
    Rejected,
    /// The filter had locked itself out and was reopened to take it.
    Reopened,
}

/// One scalar update: measured less predicted, what it was expected to be, and what became of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// When the measurement was true.
    pub time: Time,
    /// What was compared.
    pub channel: Channel,
    /// Measured less predicted, in the channel's unit.
    pub innovation: f64,
    /// Its predicted one-sigma, in the channel's unit.
    pub sigma: f64,
    /// Whether it corrected the state, or why not.
    pub verdict: Verdict,
}

impl Innovation {
    /// The innovation in units of its own predicted one-sigma; a consistent filter's are normal
    /// with unit variance.
    #[must_use]
    pub fn normalised(&self) -> f64 {
        self.innovation / self.sigma
    }
}
