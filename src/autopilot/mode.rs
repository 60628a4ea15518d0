//! What the autopilot is doing, and why it does not do what it did.

use super::health::Distrust;
use crate::time::Time;

/// What the autopilot is doing, best first after the pilot's own flying.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mode {
    /// The pilot flies.
    Manual,
    /// Holds or moves to a position, holds the heading.
    Position,
    /// Holds a velocity over ground and the heading, as position is not known well enough.
    Velocity,
    /// Holds roll, pitch and heading, and if it can the height, as velocity is not known well
    /// enough.
    Attitude,
    /// As [`Attitude`](Self::Attitude), sinking at a set rate, as velocity did not come back.
    Descent,
    /// The sticks go to trim, as not even attitude is known.
    Neutral,
}

impl Mode {
    /// All of them, best first after the pilot's own flying.
    pub const ALL: [Self; 6] = [
        Self::Manual,
        Self::Position,
        Self::Velocity,
        Self::Attitude,
        Self::Descent,
        Self::Neutral,
    ];

    /// Its name in records.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Manual => "manual",
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Attitude => "attitude",
            Self::Descent => "descent",
            Self::Neutral => "neutral",
        }
    }

    /// Whether horizontal velocity is controlled.
    #[must_use]
    pub const fn holds_velocity(self) -> bool {
        matches!(self, Self::Position | Self::Velocity)
    }
}

/// Why the mode changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// The pilot's switch.
    Switch,
    /// The pilot moved a stick.
    Override,
    /// The estimate is not good enough for the mode.
    Distrust(Distrust),
    /// The estimate is good enough for a better mode again.
    Recovered,
    /// Velocity did not come back within the configured time.
    Patience,
}

/// A change of mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    /// When.
    pub time: Time,
    /// From which mode.
    pub from: Mode,
    /// To which.
    pub to: Mode,
    /// Why.
    pub reason: Reason,
}
