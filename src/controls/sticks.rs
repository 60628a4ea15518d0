//! The four controls.

use super::Channel;

/// Where the four controls stand about hover trim, each from −1 to 1 of full travel: what the pilot
/// commands, what the autopilot commands, the columns of `controls.csv` and the inputs of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Sticks {
    /// Lateral cyclic.
    pub lateral: f64,
    /// Longitudinal cyclic.
    pub longitudinal: f64,
    /// Collective.
    pub collective: f64,
    /// Pedal.
    pub pedal: f64,
}

impl Sticks {
    /// Their names in files and models, in the order of [`Sticks::to_array`].
    pub const NAMES: [&'static str; 4] = [
        Channel::Lateral.name(),
        Channel::Longitudinal.name(),
        Channel::Collective.name(),
        Channel::Pedal.name(),
    ];

    /// All at trim.
    pub const NEUTRAL: Self = Self::from_array([0.0; 4]);

    /// From lateral, longitudinal, collective, pedal.
    #[must_use]
    pub const fn from_array([lateral, longitudinal, collective, pedal]: [f64; 4]) -> Self {
        Self { lateral, longitudinal, collective, pedal }
    }

    /// Lateral, longitudinal, collective, pedal.
    #[must_use]
    pub const fn to_array(self) -> [f64; 4] {
        [self.lateral, self.longitudinal, self.collective, self.pedal]
    }

    /// Whether every control is a number.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.to_array().iter().all(|stick| stick.is_finite())
    }

    /// Each control of this and of `other` put together by `rule`.
    #[must_use]
    pub(crate) fn zip(self, other: Self, rule: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            lateral: rule(self.lateral, other.lateral),
            longitudinal: rule(self.longitudinal, other.longitudinal),
            collective: rule(self.collective, other.collective),
            pedal: rule(self.pedal, other.pedal),
        }
    }

    /// All controls times `factor`.
    #[must_use]
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self::from_array(self.to_array().map(|stick| stick * factor))
    }

    /// The largest difference of any control to `other`.
    #[must_use]
    pub(crate) fn farthest_from(self, other: Self) -> f64 {
        let apart = self.zip(other, |a, b| libm::fabs(a - b)).to_array();
        apart.into_iter().fold(0.0, f64::max)
    }
}
