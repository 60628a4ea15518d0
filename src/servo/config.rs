//! Trim, range, direction and rate of one servo, and the conversion between pulse widths and stick fractions.

use core::fmt;

use super::width::{LONGEST_MS, SHORTEST_MS};
use crate::controls::{Channel, Channels};
use crate::scalar::Readable;

/// Direction in which a positive stick changes the pulse width of a servo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(rename_all = "lowercase")
)]
pub enum Direction {
    /// A positive stick lengthens the pulse.
    #[default]
    Normal,
    /// A positive stick shortens the pulse.
    Reversed,
}

/// Configuration of one channel: conversion between widths and sticks, and the range of the servo.
///
/// A stick fraction is a width about trim, in units of `travel_ms`, the same on both sides. A linear model or
/// controller thus has one gain, even for an asymmetric range. If an end of the range is closer to trim than
/// `travel_ms`, full stick reaches only that end.
///
/// In TOML it is the section `[servo.lateral]`, and likewise for the other channels. A missing key has its default; an
/// invalid value is rejected with the reason.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields, remote = "Self")
)]
pub struct ChannelConfig {
    /// Width at stick fraction 0, ms, inside the range.
    pub trim_ms: f64,
    /// Shortest width for the servo, ms, at least 0.5.
    pub min_ms: f64,
    /// Longest width for the servo, ms, at most 2.5.
    pub max_ms: f64,
    /// Change of width for a stick fraction of 1, ms, from 0.05 to 2.
    pub travel_ms: f64,
    /// Direction in which a positive stick changes the width.
    pub direction: Direction,
    /// Width, ms, when commands are missing; for the throttle, the width that closes it. Without it, the trim.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub failsafe_ms: Option<f64>,
    /// Largest rate of the servo's width, ms/s, above 0. 10 ms/s suits a fast cyclic servo, which turns 60° in 0.1 s if
    /// 1 ms of width corresponds to 60°.
    pub rate_limit_ms_per_s: f64,
}

impl Default for ChannelConfig {
    fn default() -> Self {
        Self {
            trim_ms: 1.5,
            min_ms: 1.0,
            max_ms: 2.0,
            travel_ms: 0.5,
            direction: Direction::Normal,
            failsafe_ms: None,
            rate_limit_ms_per_s: 10.0,
        }
    }
}

impl ChannelConfig {
    /// The stick fraction of a width: 0 at trim, ±1 at `travel_ms` from it; not limited.
    ///
    /// ```
    /// use hovernav::servo::{ChannelConfig, Direction};
    /// let tail = ChannelConfig { trim_ms: 1.52, direction: Direction::Reversed, ..Default::default() };
    /// assert!((tail.stick(1.47) - 0.1).abs() < 1e-12);
    /// assert!((tail.width_ms(0.1) - 1.47).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn stick(&self, width_ms: f64) -> f64 {
        (width_ms - self.trim_ms) / self.signed_travel_ms()
    }

    /// The width, ms, of a stick fraction; not limited: [`Limiter`](super::Limiter) does this.
    #[must_use]
    pub fn width_ms(&self, stick: f64) -> f64 {
        self.trim_ms + stick * self.signed_travel_ms()
    }

    /// Checks that every setting is finite and in its range, and that trim lies inside the servo's range.
    ///
    /// # Errors
    /// [`ConfigError`] with the first invalid setting.
    pub fn check(&self) -> Result<(), ConfigError> {
        within("min_ms", self.min_ms, SHORTEST_MS, LONGEST_MS)?;
        within("max_ms", self.max_ms, self.min_ms, LONGEST_MS)?;
        within("trim_ms", self.trim_ms, self.min_ms, self.max_ms)?;
        within("travel_ms", self.travel_ms, 0.05, 2.0)?;
        within("failsafe_ms", self.failsafe_ms(), self.min_ms, self.max_ms)?;
        within("rate_limit_ms_per_s", self.rate_limit_ms_per_s, 0.01, 1e3)
    }

    /// The width, ms, for the servo when commands are missing.
    #[must_use]
    pub fn failsafe_ms(&self) -> f64 {
        self.failsafe_ms.unwrap_or(self.trim_ms)
    }

    fn signed_travel_ms(&self) -> f64 {
        match self.direction {
            Direction::Normal => self.travel_ms,
            Direction::Reversed => -self.travel_ms,
        }
    }
}

impl Channels<ChannelConfig> {
    /// Checks the configurations of all five channels: see [`ChannelConfig::check`].
    ///
    /// # Errors
    /// [`ConfigError`] with the first setting out of its range, and its channel.
    pub fn check(&self) -> Result<(), ConfigError> {
        self.iter().try_for_each(|(channel, config)| {
            config.check().map_err(|error| ConfigError { channel: Some(channel), ..error })
        })
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for ChannelConfig {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let config = Self::deserialize(deserializer)?;
        config.check().map_err(serde::de::Error::custom)?;
        Ok(config)
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for ChannelConfig {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

/// Rejects NaN and values outside `from` to `to`.
pub(crate) fn within(key: &'static str, value: f64, from: f64, to: f64) -> Result<(), ConfigError> {
    if value >= from && value <= to {
        Ok(())
    } else {
        Err(ConfigError { channel: None, key, value, from, to })
    }
}

/// An invalid setting of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfigError {
    /// The channel; `None` for a setting without a channel.
    pub channel: Option<Channel>,
    /// Key of the setting.
    pub key: &'static str,
    /// The value found.
    pub value: f64,
    /// The smallest valid value.
    pub from: f64,
    /// The largest valid value.
    pub to: f64,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(channel) = self.channel {
            write!(f, "{channel}: ")?;
        }
        let Self { key, value, from, to, .. } = self;
        write!(f, "{key}: found {}, expected {from} to {to}", Readable(*value))
    }
}

impl core::error::Error for ConfigError {}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn stick_and_width_are_inverse(
            stick in -1.5f64..1.5,
            trim_ms in 1.2f64..1.8,
            travel_ms in 0.1f64..1.0,
            reversed: bool,
        ) {
            let direction = if reversed { Direction::Reversed } else { Direction::Normal };
            let config = ChannelConfig { trim_ms, travel_ms, direction, ..Default::default() };
            prop_assert!((config.stick(config.width_ms(stick)) - stick).abs() < 1e-12);
            prop_assert_eq!(config.stick(trim_ms), 0.0);
        }
    }

    #[test]
    fn a_lopsided_range_keeps_one_gain_on_both_sides_of_trim() {
        let config = ChannelConfig { trim_ms: 1.2, ..Default::default() };
        let (up, down) = (config.stick(1.3), config.stick(1.1));
        assert_abs_diff_eq!(up, -down, epsilon = 1e-12);
        assert_abs_diff_eq!(up, 0.2, epsilon = 1e-12);
    }

    #[test]
    fn settings_that_cannot_fly_are_refused_by_name() {
        let good = ChannelConfig::default();
        assert_eq!(good.check(), Ok(()));
        for (bad, key) in [
            (ChannelConfig { min_ms: 0.4, ..good }, "min_ms"),
            (ChannelConfig { max_ms: f64::NAN, ..good }, "max_ms"),
            (ChannelConfig { min_ms: 1.8, max_ms: 1.2, ..good }, "max_ms"),
            (ChannelConfig { trim_ms: 2.1, ..good }, "trim_ms"),
            (ChannelConfig { travel_ms: 0.0, ..good }, "travel_ms"),
            (ChannelConfig { failsafe_ms: Some(0.9), ..good }, "failsafe_ms"),
            (ChannelConfig { rate_limit_ms_per_s: -1.0, ..good }, "rate_limit_ms_per_s"),
            (ChannelConfig { rate_limit_ms_per_s: f64::INFINITY, ..good }, "rate_limit_ms_per_s"),
        ] {
            assert_eq!(bad.check().unwrap_err().key, key);
        }
        let all = Channels { pedal: ChannelConfig { trim_ms: 3.0, ..good }, ..Channels::default() };
        let error = all.check().unwrap_err();
        assert_eq!(error.to_string(), "pedal: trim_ms: found 3, expected 1 to 2");
    }

    #[cfg(feature = "serde")]
    #[test]
    fn a_file_sets_what_it_names_and_is_refused_where_it_is_wrong() {
        let read = toml::from_str::<Channels<ChannelConfig>>;
        let config = read("[lateral]\ntrim_ms = 1.48\ndirection = 'reversed'").unwrap();
        assert_eq!(config.lateral.trim_ms, 1.48);
        assert_eq!(config.lateral.direction, Direction::Reversed);
        assert_eq!(config.pedal, ChannelConfig::default());
        let text = toml::to_string(&config).unwrap();
        assert_eq!(read(&text).unwrap(), config);

        let refusal = |text| read(text).unwrap_err().to_string();
        assert!(refusal("[lateral]\nmax_ms = 3.0").contains("max_ms: found 3, expected 1 to 2.5"));
        assert!(refusal("[latteral]\nmax_ms = 1.9").contains("latteral"));
        assert!(refusal("[lateral]\ntrimm_ms = 1.5").contains("trimm_ms"));
        assert!(refusal("[lateral]\ntrim_ms = nan").contains("trim_ms: found NaN"));
    }
}
