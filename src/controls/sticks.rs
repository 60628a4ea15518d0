//! The four controls.

use super::Channel;
use crate::scalar::Scalar;

/// Positions of the four controls about hover trim, each from −1 to 1 of full travel. Used for the commands of the
/// pilot and the autopilot, the columns of `controls.csv` and the inputs of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Sticks<T = f64> {
    /// Lateral cyclic.
    pub lateral: T,
    /// Longitudinal cyclic.
    pub longitudinal: T,
    /// Collective.
    pub collective: T,
    /// Pedal.
    pub pedal: T,
}

impl Sticks {
    /// Names of the controls in files and models, in the order of [`Sticks::to_array`].
    pub const NAMES: [&'static str; 4] = [
        Channel::Lateral.name(),
        Channel::Longitudinal.name(),
        Channel::Collective.name(),
        Channel::Pedal.name(),
    ];
}

impl<T: Scalar> Sticks<T> {
    /// All sticks at trim.
    pub const NEUTRAL: Self = Self::from_array([T::ZERO; 4]);

    /// Sticks from lateral, longitudinal, collective, pedal.
    #[must_use]
    pub const fn from_array([lateral, longitudinal, collective, pedal]: [T; 4]) -> Self {
        Self { lateral, longitudinal, collective, pedal }
    }

    /// The four positions in the order lateral, longitudinal, collective, pedal.
    #[must_use]
    pub const fn to_array(self) -> [T; 4] {
        [self.lateral, self.longitudinal, self.collective, self.pedal]
    }

    /// The same positions in another number type.
    #[must_use]
    #[inline(always)]
    pub fn cast<U: Scalar>(self) -> Sticks<U> {
        Sticks::from_array(self.to_array().map(|stick| U::of(stick.wide())))
    }

    /// Whether every control is finite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.to_array().iter().all(|stick| stick.is_finite())
    }

    /// Combines this and `other` with `rule`, control by control.
    #[must_use]
    pub(crate) fn zip(self, other: Self, rule: impl Fn(T, T) -> T) -> Self {
        Self {
            lateral: rule(self.lateral, other.lateral),
            longitudinal: rule(self.longitudinal, other.longitudinal),
            collective: rule(self.collective, other.collective),
            pedal: rule(self.pedal, other.pedal),
        }
    }

    /// The positions of all controls multiplied by `factor`.
    #[must_use]
    pub(crate) fn scaled(self, factor: T) -> Self {
        Self::from_array(self.to_array().map(|stick| stick * factor))
    }

    /// Largest difference between these sticks and `other`, on any control.
    #[must_use]
    pub(crate) fn farthest_from(self, other: Self) -> T {
        let apart = self.zip(other, |a, b| (a - b).abs()).to_array();
        apart.into_iter().fold(T::ZERO, T::max)
    }
}
