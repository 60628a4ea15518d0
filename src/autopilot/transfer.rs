//! Transitions between modes.

use super::check::{ConfigError, within};
use crate::scalar::Scalar;

/// Transitions between modes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct TransferConfig<T = f64> {
    /// Time constant, s, with which the change of the command at a transition fades out: the last command of one mode
    /// minus the first command of the next mode.
    pub fade_s: T,
    /// Time constant, s, with which the difference between autopilot and pilot fades out when the pilot takes over.
    pub hand_back_s: T,
    /// Time constant, s, with which the sticks go to trim when attitude is unknown.
    pub neutral_s: T,
    /// Deflection of a stick from its position at engagement that counts as the pilot's override.
    pub override_travel: T,
    /// Time, s, for which the autopilot holds attitude without a good velocity before it descends.
    pub patience_s: T,
    /// Sink rate of the descent, m/s.
    pub descent_mps: T,
    /// Change of the collective from trim, in the sinking direction, during a descent without a good vertical velocity;
    /// 0 or more.
    pub descent_collective: T,
    /// Time constant, s, with which trim is learned in a steady hover.
    pub trim_s: T,
}

impl Default for TransferConfig {
    fn default() -> Self {
        Self {
            fade_s: 0.7,
            hand_back_s: 0.25,
            neutral_s: 1.0,
            override_travel: 0.15,
            patience_s: 40.0,
            descent_mps: 0.5,
            descent_collective: 0.05,
            trim_s: 10.0,
        }
    }
}

impl<T: Scalar> TransferConfig<T> {
    /// The same configuration in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> TransferConfig<U> {
        let number = |value: T| U::of(value.wide());
        TransferConfig {
            fade_s: number(self.fade_s),
            hand_back_s: number(self.hand_back_s),
            neutral_s: number(self.neutral_s),
            override_travel: number(self.override_travel),
            patience_s: number(self.patience_s),
            descent_mps: number(self.descent_mps),
            descent_collective: number(self.descent_collective),
            trim_s: number(self.trim_s),
        }
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        const TIME: &str = "0.01 to 1000 s";
        within("transfer.fade_s", self.fade_s, 0.01, 1e3, TIME)?;
        within("transfer.hand_back_s", self.hand_back_s, 0.01, 1e3, TIME)?;
        within("transfer.neutral_s", self.neutral_s, 0.01, 1e3, TIME)?;
        within("transfer.override_travel", self.override_travel, 0.01, 1.0, "0.01 to 1")?;
        within("transfer.patience_s", self.patience_s, 0.0, 1e6, "0 s or more")?;
        within("transfer.descent_mps", self.descent_mps, 0.0, 3.0, "0 to 3 m/s")?;
        within("transfer.descent_collective", self.descent_collective, 0.0, 0.5, "0 to 0.5")?;
        within("transfer.trim_s", self.trim_s, 0.1, 1e4, "0.1 to 10000 s")
    }
}
