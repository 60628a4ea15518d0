//! Limits of the commands to the servos.

use super::check::{ConfigError, within};
use crate::controls::Sticks;
use crate::scalar::Scalar;

/// Range and rate limits of the autopilot's commands, for each control.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields),
    serde(bound(deserialize = "T: serde::Deserialize<'de> + Default, StickLimits<T>: Default"))
)]
pub struct StickLimits<T = f64> {
    /// Lowest position of each stick, −1 to 0.
    pub lowest: Sticks<T>,
    /// Highest position of each stick, 0 to 1.
    pub highest: Sticks<T>,
    /// Largest rate of each stick, 1/s, above 0. The travel from neutral to a stop is 1.
    pub rate_per_s: Sticks<T>,
}

impl Default for StickLimits {
    /// The whole range, and a rate that moves a stick from stop to stop in 0.5 s.
    fn default() -> Self {
        Self {
            lowest: Sticks::from_array([-1.0; 4]),
            highest: Sticks::from_array([1.0; 4]),
            rate_per_s: Sticks::from_array([4.0; 4]),
        }
    }
}

/// Largest deflection of the pilot's sticks that counts as valid: a transmitter's travel at 125 %.
pub const FARTHEST_PILOT: f64 = 1.25;

impl<T: Scalar> StickLimits<T> {
    /// The same limits in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> StickLimits<U> {
        StickLimits {
            lowest: self.lowest.cast(),
            highest: self.highest.cast(),
            rate_per_s: self.rate_per_s.cast(),
        }
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        for lowest in self.lowest.to_array() {
            within("limits.lowest", lowest, -1.0, 0.0, "-1 to 0")?;
        }
        for highest in self.highest.to_array() {
            within("limits.highest", highest, 0.0, 1.0, "0 to 1")?;
        }
        for rate in self.rate_per_s.to_array() {
            within("limits.rate_per_s", rate, 1e-3, 1e3, "0.001 to 1000 a second")?;
        }
        Ok(())
    }

    /// `wanted` limited to the range.
    #[must_use]
    pub fn in_range(&self, wanted: Sticks<T>) -> Sticks<T> {
        wanted.zip(self.lowest, T::max).zip(self.highest, T::min)
    }

    /// `wanted` limited to the range. Where the pilot's sticks `own` are beyond the range, it is extended to them. Only
    /// the servos and the travel of a transmitter, [`FARTHEST_PILOT`], limit the pilot.
    #[must_use]
    pub fn in_range_with_pilot(&self, wanted: Sticks<T>, own: Sticks<T>) -> Sticks<T> {
        let farthest = T::of(FARTHEST_PILOT);
        // Written so that a NaN stays a NaN.
        let possible = |stick: T| match stick {
            high if high > farthest => farthest,
            low if low < -farthest => -farthest,
            _ => stick,
        };
        let own = Sticks::from_array(own.to_array().map(possible));
        wanted.zip(self.lowest.zip(own, T::min), T::max).zip(self.highest.zip(own, T::max), T::min)
    }

    /// `wanted` limited to the range, and to the positions that the controls can reach from `last` within `period_s`.
    ///
    /// # Source
    /// Equation (C9) of docs/equations.md.
    #[must_use]
    pub fn reachable(&self, wanted: Sticks<T>, last: Sticks<T>, period_s: T) -> Sticks<T> {
        let travel = self.rate_per_s.scaled(period_s);
        self.in_range(wanted)
            .zip(last.zip(travel, |last, travel| last - travel), T::max)
            .zip(last.zip(travel, |last, travel| last + travel), T::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sticks(range: core::ops::Range<f64>) -> impl Strategy<Value = Sticks> {
        prop::array::uniform4(range).prop_map(Sticks::from_array)
    }

    proptest! {
        #[test]
        fn commands_keep_to_range_and_rate(last in sticks(-1.0..1.0), wanted in sticks(-9.0..9.0)) {
            let limits = StickLimits::default();
            let out = limits.reachable(wanted, last, 0.03);
            prop_assert!(out.to_array().iter().all(|stick| (-1.0..=1.0).contains(stick)));
            prop_assert!(out.farthest_from(last) <= 4.0 * 0.03 + 1e-12);
        }
    }
}
