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
    /// Their names in files and models, in the order of [`Sticks::to_array`].
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

    /// These positions in numbers of another type.
    #[must_use]
    #[inline(always)]
    pub fn cast<U: Scalar>(self) -> Sticks<U> {
        Sticks::from_array(self.to_array().map(|stick| U::of(stick.wide())))
    }

    /// Whether every control is a number.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.to_array().iter().all(|stick| stick.is_finite())
    }

    /// Combines each control of this and of `other` by `rule`.
    #[must_use]
    pub(crate) fn zip(self, other: Self, rule: impl Fn(T, T) -> T) -> Self {
        Self {
            lateral: rule(self.lateral, other.lateral),
            longitudinal: rule(self.longitudinal, other.longitudinal),
            collective: rule(self.collective, other.collective),
            pedal: rule(self.pedal, other.pedal),
        }
    }

    /// All controls times `factor`.
    #[must_use]
    pub(crate) fn scaled(self, factor: T) -> Self {
        Self::from_array(self.to_array().map(|stick| stick * factor))
    }

    /// The largest difference of any control to `other`.
    #[must_use]
    pub(crate) fn farthest_from(self, other: Self) -> T {
        let apart = self.zip(other, |a, b| (a - b).abs()).to_array();
        apart.into_iter().fold(T::ZERO, T::max)
    }
}
