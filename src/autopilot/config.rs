//! The autopilot's configuration as plain data, and what it must keep to.

use super::guidance::GuidanceConfig;
use super::health::HealthLimits;
use super::limits::StickLimits;
use super::pid::PidGains;
use super::regulator::RegulatorGains;
use super::trim::Trim;

/// A value no autopilot can fly with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfigError {
    /// Which value.
    pub what: &'static str,
    /// What was found.
    pub found: f64,
    /// What would have been right.
    pub expected: &'static str,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "autopilot: {}: found {}, expected {}", self.what, self.found, self.expected)
    }
}

impl core::error::Error for ConfigError {}

pub(super) fn finite(what: &'static str, found: f64) -> Result<(), ConfigError> {
    if found.is_finite() {
        Ok(())
    } else {
        Err(ConfigError { what, found, expected: "a finite number" })
    }
}

pub(super) fn within(
    what: &'static str,
    found: f64,
    lowest: f64,
    highest: f64,
    expected: &'static str,
) -> Result<(), ConfigError> {
    if found >= lowest && found <= highest {
        Ok(())
    } else {
        Err(ConfigError { what, found, expected })
    }
}

/// Every gain of the hybrid, at the sample period they were designed for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(deny_unknown_fields)
)]
pub struct Gains {
    /// Collective from the downward velocity w, body axes.
    pub heave: PidGains,
    /// Pedal from r, ψ; one hidden state beside the servo.
    pub yaw: RegulatorGains<2, 2, 1>,
    /// Pedal per collective: takes out what collective does to the heading.
    pub pedal_per_collective: f64,
    /// Lateral and longitudinal cyclic from p, q, φ, θ, u, v; hidden are up to four states of rotor
    /// and bar, and two servos.
    pub roll_pitch: RegulatorGains<6, 6, 2>,
    /// Lateral and longitudinal cyclic from p, q, φ, θ alone, for when velocity is not known.
    pub attitude: RegulatorGains<4, 6, 2>,
}

impl Gains {
    fn check(&self) -> Result<(), ConfigError> {
        self.heave.check("gains.heave")?;
        self.yaw.check("gains.yaw")?;
        finite("gains.pedal_per_collective", self.pedal_per_collective)?;
        self.roll_pitch.check("gains.roll_pitch")?;
        self.attitude.check("gains.attitude")
    }
}

/// How modes give way to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct TransferConfig {
    /// Time constant by which the difference between the last command of one mode and the first of
    /// the next fades, s.
    pub fade_s: f64,
    /// The same when the pilot takes over, s.
    pub hand_back_s: f64,
    /// Time constant by which the sticks go to trim when attitude is not known, s.
    pub neutral_s: f64,
    /// A stick moved further than this from where it was when the autopilot took over is the
    /// pilot's override.
    pub override_travel: f64,
    /// How long attitude is held without velocity before the descent begins, s.
    pub patience_s: f64,
    /// Sink rate of the descent, m/s.
    pub descent_mps: f64,
    /// Stick taken off the trimmed collective in a descent without vertical velocity, in the
    /// direction that sinks, from 0.
    pub descent_collective: f64,
    /// Time constant by which trim is learned in a steady hover, s.
    pub trim_s: f64,
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

impl TransferConfig {
    fn check(&self) -> Result<(), ConfigError> {
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

/// Everything the autopilot is told: `autopilot.toml`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(deny_unknown_fields)
)]
pub struct HoverConfig {
    /// The loop's period, s, for which the gains were designed.
    pub period_s: f64,
    /// Trim to begin with; better is learned in flight.
    #[cfg_attr(feature = "serde", serde(default))]
    pub trim: Trim,
    /// Range and rate of the commands.
    #[cfg_attr(feature = "serde", serde(default))]
    pub limits: StickLimits,
    /// How set-points are flown.
    #[cfg_attr(feature = "serde", serde(default))]
    pub guidance: GuidanceConfig,
    /// What is good enough to fly on.
    #[cfg_attr(feature = "serde", serde(default))]
    pub health: HealthLimits,
    /// How modes give way to each other.
    #[cfg_attr(feature = "serde", serde(default))]
    pub transfer: TransferConfig,
    /// The gains.
    pub gains: Gains,
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
