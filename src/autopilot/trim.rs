//! Trim: the sticks and the tilt that hold the vehicle in a hover.

use super::check::{ConfigError, within};
use crate::controls::Sticks;
use crate::scalar::Scalar;

/// Positions of the sticks in a steady hover, and the roll and pitch of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields),
    serde(bound(deserialize = "T: serde::Deserialize<'de> + Default"))
)]
pub struct Trim<T = f64> {
    /// Positions of the controls.
    pub sticks: Sticks<T>,
    /// Roll, rad.
    pub roll_rad: T,
    /// Pitch, rad.
    pub pitch_rad: T,
}

impl<T: Scalar> Trim<T> {
    /// The same trim in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> Trim<U> {
        let number = |value: T| U::of(value.wide());
        Trim {
            sticks: self.sticks.cast(),
            roll_rad: number(self.roll_rad),
            pitch_rad: number(self.pitch_rad),
        }
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        for stick in self.sticks.to_array() {
            within("trim.sticks", stick, -1.0, 1.0, "-1 to 1")?;
        }
        within("trim.roll_rad", self.roll_rad, -0.5, 0.5, "-0.5 to 0.5 rad")?;
        within("trim.pitch_rad", self.pitch_rad, -0.5, 0.5, "-0.5 to 0.5 rad")
    }

    /// This trim moved towards `now` by the fraction `share` of their difference.
    pub(super) fn towards(self, now: &Self, share: T) -> Self {
        let blend = |old: T, new: T| old + share * (new - old);
        Self {
            sticks: self.sticks.zip(now.sticks, blend),
            roll_rad: blend(self.roll_rad, now.roll_rad),
            pitch_rad: blend(self.pitch_rad, now.pitch_rad),
        }
    }

    /// Whether a vehicle with this trim can hover: roll and pitch are less than 0.4 rad.
    pub(super) fn is_plausible(&self) -> bool {
        self.roll_rad.abs() < T::of(0.4) && self.pitch_rad.abs() < T::of(0.4)
    }
}
