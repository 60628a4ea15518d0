//! The autopilot's configuration as plain data, and what it must keep to.

use super::check::{ConfigError, finite, within};
use super::guidance::GuidanceConfig;
use super::health::HealthLimits;
use super::limits::StickLimits;
use super::pid::PidGains;
use super::regulator::RegulatorGains;
use super::transfer::TransferConfig;
use super::trim::Trim;
use crate::scalar::Scalar;

/// Every gain of the hybrid, at the sample period they were designed for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(deny_unknown_fields)
)]
pub struct Gains<T = f64> {
    /// Collective from the downward velocity w, body axes.
    pub heave: PidGains<T>,
    /// Pedal from r, ψ; one hidden state beside the servo.
    pub yaw: RegulatorGains<2, 2, 1, T>,
    /// Pedal per collective: takes out what collective does to the heading.
    pub pedal_per_collective: T,
    /// Lateral and longitudinal cyclic from p, q, φ, θ, u, v; hidden are up to four states of rotor
    /// and bar, and two servos.
    pub roll_pitch: RegulatorGains<6, 6, 2, T>,
    /// Lateral and longitudinal cyclic from p, q, φ, θ alone, for when velocity is not known.
    pub attitude: RegulatorGains<4, 6, 2, T>,
}

impl<T: Scalar> Default for Gains<T> {
    /// Gains that do nothing.
    fn default() -> Self {
        Self {
            heave: PidGains::default(),
            yaw: RegulatorGains::default(),
            pedal_per_collective: T::ZERO,
            roll_pitch: RegulatorGains::default(),
            attitude: RegulatorGains::default(),
        }
    }
}

impl<T: Scalar> Gains<T> {
    /// The same in numbers of another type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> Gains<U> {
        Gains {
            heave: self.heave.cast(),
            yaw: self.yaw.cast(),
            pedal_per_collective: U::of(self.pedal_per_collective.wide()),
            roll_pitch: self.roll_pitch.cast(),
            attitude: self.attitude.cast(),
        }
    }

    fn check(&self) -> Result<(), ConfigError> {
        self.heave.check("gains.heave")?;
        self.yaw.check("gains.yaw")?;
        finite("gains.pedal_per_collective", self.pedal_per_collective)?;
        self.roll_pitch.check("gains.roll_pitch")?;
        self.attitude.check("gains.attitude")
    }
}

/// The whole configuration of the autopilot: `autopilot.toml`. Made by [`HoverConfig::new`]; what differs
/// from the defaults is set by the `with` methods or field by field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(deny_unknown_fields),
    serde(bound(deserialize = "T: serde::Deserialize<'de> + Default, StickLimits<T>: Default, \
                               GuidanceConfig<T>: Default, HealthLimits<T>: Default, \
                               TransferConfig<T>: Default"))
)]
#[non_exhaustive]
pub struct HoverConfig<T = f64> {
    /// The loop's period, s, for which the gains were designed.
    pub period_s: f64,
    /// Trim to begin with; better is learned in flight.
    #[cfg_attr(feature = "serde", serde(default))]
    pub trim: Trim<T>,
    /// Range and rate of the commands.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: StickLimits<T>,
    /// How set-points are flown.
    #[cfg_attr(feature = "serde", serde(default))]
    pub guidance: GuidanceConfig<T>,
    /// What is good enough to fly on.
    #[cfg_attr(feature = "serde", serde(default))]
    pub health: HealthLimits<T>,
    /// How modes give way to each other.
    #[cfg_attr(feature = "serde", serde(default))]
    pub transfer: TransferConfig<T>,
    /// The gains.
    pub gains: Gains<T>,
}

impl HoverConfig {
    /// `gains` designed for `period_s`, and defaults for everything else.
    #[must_use]
    pub fn new(period_s: f64, gains: Gains) -> Self {
        Self {
            period_s,
            trim: Trim::default(),
            limits: StickLimits::default(),
            guidance: GuidanceConfig::default(),
            health: HealthLimits::default(),
            transfer: TransferConfig::default(),
            gains,
        }
    }

    /// The same with another trim to begin with.
    #[must_use]
    pub const fn with_trim(self, trim: Trim) -> Self {
        Self { trim, ..self }
    }

    /// The same with other limits of the commands.
    #[must_use]
    pub const fn with_limits(self, limits: StickLimits) -> Self {
        Self { limits, ..self }
    }

    /// The same with set-points flown otherwise.
    #[must_use]
    pub const fn with_guidance(self, guidance: GuidanceConfig) -> Self {
        Self { guidance, ..self }
    }

    /// The same with other limits of what is good enough to fly by.
    #[must_use]
    pub const fn with_health(self, health: HealthLimits) -> Self {
        Self { health, ..self }
    }

    /// The same with modes that give way to each other otherwise.
    #[must_use]
    pub const fn with_transfer(self, transfer: TransferConfig) -> Self {
        Self { transfer, ..self }
    }
}

impl<T: Scalar> HoverConfig<T> {
    /// The same in numbers of another type, for an autopilot that computes in it: `config.cast::<f32>()`. The
    /// period stays what it is.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> HoverConfig<U> {
        HoverConfig {
            period_s: self.period_s,
            trim: self.trim.cast(),
            limits: self.limits.cast(),
            guidance: self.guidance.cast(),
            health: self.health.cast(),
            transfer: self.transfer.cast(),
            gains: self.gains.cast(),
        }
    }

    /// Whether one can fly with it.
    ///
    /// # Errors
    /// [`ConfigError`] names the first value that cannot be.
    pub fn check(&self) -> Result<(), ConfigError> {
        within("period_s", self.period_s, 1e-3, 0.2, "0.001 to 0.2 s")?;
        self.trim.check()?;
        self.limits.check()?;
        self.guidance.check()?;
        self.health.check()?;
        self.transfer.check()?;
        self.gains.check()
    }
}
