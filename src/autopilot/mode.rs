//! Modes of the autopilot, and reasons for their changes.

use crate::health::Distrust;
use crate::time::Time;

/// Mode of the autopilot. `Manual` is first; the other modes follow from the best to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mode {
    /// The pilot flies.
    Manual,
    /// Holds a position or flies to it, and holds the heading.
    Position,
    /// Holds a velocity over ground, and the heading, because position is not accurate enough.
    Velocity,
    /// Holds roll, pitch, heading and, if possible, height, because velocity is not accurate enough.
    Attitude,
    /// As [`Attitude`](Self::Attitude), but descends at the configured sink rate, because velocity did not recover in
    /// time.
    Descent,
    /// Moves the sticks to trim, because attitude is unknown.
    Neutral,
}

impl Mode {
    /// All modes: first `Manual`, then from the best to the worst.
    pub const ALL: [Self; 6] = [
        Self::Manual,
        Self::Position,
        Self::Velocity,
        Self::Attitude,
        Self::Descent,
        Self::Neutral,
    ];

    /// Name of the mode in records.
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

    /// Whether the mode controls horizontal velocity.
    #[must_use]
    pub const fn holds_velocity(self) -> bool {
        matches!(self, Self::Position | Self::Velocity)
    }
}

/// Reason for a change of mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// The pilot opened or closed the switch.
    Switch,
    /// The pilot moved a stick.
    Override,
    /// The estimate is not good enough for the mode.
    Distrust(Distrust),
    /// The estimate is good enough for a better mode again.
    Recovered,
    /// Velocity did not recover within the configured time.
    VelocityNotRecovered,
}

/// A change of mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transition {
    /// Time of the change.
    pub time: Time,
    /// The previous mode.
    pub from: Mode,
    /// The new mode.
    pub to: Mode,
    /// The reason.
    pub reason: Reason,
}
