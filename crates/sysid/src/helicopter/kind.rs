//! Kinds of models: the part of the helicopter to identify, and its level of detail.

use std::fmt;
use std::str::FromStr;

/// Part of the helicopter to identify, and its level of detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// r from pedal and collective.
    Yaw,
    /// w from collective.
    Heave,
    /// p, q, φ, θ, u, v from the cyclic, with instantaneous flapping: the thesis's reduced model.
    RollPitch,
    /// As [`RollPitch`](Self::RollPitch), with flapping: the cyclic part of [`Hybrid`](Self::Hybrid).
    Flapping,
    /// All ten states of equations 3.50–3.57, flapping included.
    Hybrid,
    /// Roll and pitch, heave and yaw, without flapping: eight states.
    Hover,
    /// Mettler's R-50 with stabiliser bar and yaw gyro: 13 states.
    R50,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Yaw,
        Self::Heave,
        Self::RollPitch,
        Self::Flapping,
        Self::Hybrid,
        Self::Hover,
        Self::R50,
    ];

    /// Parts into which the equations decouple. Each part is identified on its own, with the motion of the other parts
    /// as known inputs. Empty for equations that do not decouple.
    #[must_use]
    pub const fn parts(self) -> &'static [Self] {
        match self {
            Self::Hybrid => &[Self::Flapping, Self::Heave, Self::Yaw],
            Self::Hover => &[Self::RollPitch, Self::Heave, Self::Yaw],
            _ => &[],
        }
    }

    /// Name of the delay parameter of a part that has a stick of its own.
    pub(super) const fn own_delay(self) -> Option<&'static str> {
        match self {
            Self::Yaw => Some("tau_ped"),
            Self::Heave => Some("tau_col"),
            _ => None,
        }
    }

    /// Name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Yaw => "yaw",
            Self::Heave => "heave",
            Self::RollPitch => "roll-pitch",
            Self::Flapping => "flapping",
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

/// An unknown name of a model.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("found \"{0}\", expected yaw, heave, roll-pitch, flapping, hybrid, hover or r50")]
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
