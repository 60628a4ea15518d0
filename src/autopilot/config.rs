//! The autopilot's configuration as plain data, and its checks.

use super::check::{ConfigError, finite, within};
use super::guidance::GuidanceConfig;
use super::limits::StickLimits;
use super::pid::PidGains;
use super::regulator::RegulatorGains;
use super::transfer::TransferConfig;
use super::trim::Trim;
use crate::health::HealthLimits;
use crate::scalar::Scalar;

/// Gains of the hybrid controller, for the sample period for which they were designed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(deny_unknown_fields)
)]
pub struct Gains<T = f64> {
    /// Gains from the downward velocity w, body axes, to collective.
    pub heave: PidGains<T>,
    /// Gains from r, ψ to pedal; one hidden state in addition to that of the servo.
    pub yaw: RegulatorGains<2, 2, 1, T>,
    /// Gain from collective to pedal, which compensates the yaw caused by collective.
    pub pedal_per_collective: T,
    /// Gains from p, q, φ, θ, u, v to lateral and longitudinal cyclic. The hidden states are up to four states of rotor
    /// and stabilizer bar, and two states of the servos.
    pub roll_pitch: RegulatorGains<6, 6, 2, T>,
    /// Gains from p, q, φ, θ alone to lateral and longitudinal cyclic, for flight without a known velocity.
    pub attitude: RegulatorGains<4, 6, 2, T>,
}

impl<T: Scalar> Default for Gains<T> {
    /// Gains of zero.
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
    /// The same gains in another number type.
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

/// The complete configuration of the autopilot, as in `autopilot.toml`. [`HoverConfig::new`] creates it with defaults;
/// the `with` methods or the fields change it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(deny_unknown_fields),
    serde(bound(deserialize = "T: serde::Deserialize<'de> + Default, StickLimits<T>: Default, \
                               GuidanceConfig<T>: Default, HealthLimits<T>: Default, \
                               TransferConfig<T>: Default"))
)]
pub struct HoverConfig<T = f64> {
    /// Period of the control loop, s, for which the gains were designed.
    pub period_s: f64,
    /// Initial trim; the autopilot learns a better trim in flight.
    #[cfg_attr(feature = "serde", serde(default))]
    pub trim: Trim<T>,
    /// Range and rate of the commands.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: StickLimits<T>,
    /// Limits and gains of guidance.
    #[cfg_attr(feature = "serde", serde(default))]
    pub guidance: GuidanceConfig<T>,
    /// Accuracy of the estimate required to fly.
    #[cfg_attr(feature = "serde", serde(default))]
    pub health: HealthLimits<T>,
    /// Transitions between modes.
    #[cfg_attr(feature = "serde", serde(default))]
    pub transfer: TransferConfig<T>,
    /// The gains.
    pub gains: Gains<T>,
}

impl HoverConfig {
    /// A configuration with `gains` designed for `period_s`, and defaults for everything else.
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

    /// The same configuration with another initial trim.
    #[must_use]
    pub const fn with_trim(self, trim: Trim) -> Self {
        Self { trim, ..self }
    }

    /// The same configuration with other limits of the commands.
    #[must_use]
    pub const fn with_limits(self, limits: StickLimits) -> Self {
        Self { limits, ..self }
    }

    /// The same configuration with other guidance.
    #[must_use]
    pub const fn with_guidance(self, guidance: GuidanceConfig) -> Self {
        Self { guidance, ..self }
    }

    /// The same configuration with other limits on the accuracy of the estimate.
    #[must_use]
    pub const fn with_health(self, health: HealthLimits) -> Self {
        Self { health, ..self }
    }

    /// The same configuration with other transitions between modes.
    #[must_use]
    pub const fn with_transfer(self, transfer: TransferConfig) -> Self {
        Self { transfer, ..self }
    }
}

impl<T: Scalar> HoverConfig<T> {
    /// The same configuration in another number type, for an autopilot that computes in it: `config.cast::<f32>()`.
    /// The period keeps its type.
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

    /// Checks that the autopilot can fly with the configuration.
    ///
    /// # Errors
    /// [`ConfigError`] names the first invalid value.
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
