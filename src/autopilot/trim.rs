//! Trim: what keeps the vehicle where it is, as flown.

use super::check::{ConfigError, within};
use crate::controls::Sticks;

/// Where the sticks stand in a steady hover and how the vehicle hangs in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Trim {
    /// The controls.
    pub sticks: Sticks,
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
}

impl Trim {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        for stick in self.sticks.to_array() {
            within("trim.sticks", stick, -1.0, 1.0, "-1 to 1")?;
        }
        within("trim.roll_rad", self.roll_rad, -0.5, 0.5, "-0.5 to 0.5 rad")?;
        within("trim.pitch_rad", self.pitch_rad, -0.5, 0.5, "-0.5 to 0.5 rad")
    }

    /// This trim moved by `share` of the way to what is flown now.
    pub(super) fn towards(self, now: &Self, share: f64) -> Self {
        let blend = |old: f64, new: f64| old + share * (new - old);
        Self {
            sticks: self.sticks.zip(now.sticks, blend),
            roll_rad: blend(self.roll_rad, now.roll_rad),
            pitch_rad: blend(self.pitch_rad, now.pitch_rad),
        }
    }

    /// Whether a vehicle so trimmed is one that hovers: tilt within a quarter of a right angle.
    pub(super) fn is_plausible(&self) -> bool {
        libm::fabs(self.roll_rad) < 0.4 && libm::fabs(self.pitch_rad) < 0.4
    }
}
