//! Which part of the helicopter is identified.

use std::fmt;
use std::str::FromStr;

/// Which part of the helicopter, in how much detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// r from pedal and collective.
    Yaw,
    /// w from collective.
    Heave,
    /// p, q, φ, θ, u, v from the cyclic, flapping taken as instantaneous: the thesis's reduced model.
    RollPitch,
    /// All ten states of equations 3.50–3.57, flapping included.
    Hybrid,
    /// Roll and pitch, heave and yaw, without flapping: eight states.
    Hover,
    /// Mettler's R-50 with stabiliser bar and yaw gyro: 13 states.
    R50,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Yaw, Self::Heave, Self::RollPitch, Self::Hybrid, Self::Hover, Self::R50];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Yaw => "yaw",
            Self::Heave => "heave",
            Self::RollPitch => "roll-pitch",
            Self::Hybrid => "hybrid",
            Self::Hover => "hover",
            Self::R50 => "r50",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A model's name that is none.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("found \"{0}\", expected yaw, heave, roll-pitch, hybrid, hover or r50")]
pub struct UnknownKind(String);

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == text)
            .ok_or_else(|| UnknownKind(text.to_owned()))
    }
}
