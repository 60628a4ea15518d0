//! What flight control is set up with.

use core::fmt;

use crate::autopilot::{
    self, ExcitationError, ExcitationProgramme, HoverConfig, ReadinessLimits, SteeringConfig,
};
use crate::controls::Channels;
use crate::earth::Geodetic;
use crate::servo::{self, ChannelConfig, SignalConfig, Swashplate, SwitchConfig, within};

/// How far the vehicle may go while the autopilot flies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fence {
    /// Its middle, on the ground.
    pub centre: Geodetic,
    /// Horizontal distance from the middle, m, from 5 to 10 000.
    pub radius_m: f64,
    /// Height above the middle, m, from 5 to 1000.
    pub height_m: f64,
}

/// What flight control does when something is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
#[non_exhaustive]
pub struct FailsafeConfig {
    /// How long the autopilot holds its place without a pilot before it descends, s, 0 to 600.
    pub pilot_lost_hold_s: f64,
    /// How fast it then descends, m/s, 0.1 to 2.
    pub descent_mps: f64,
    /// So many cycles late, one after the other, give the sticks back, 1 to 100.
    pub late_cycles: u8,
    /// A stick at its end for so long is told, s, 0.1 to 60.
    pub saturation_s: f64,
}

impl Default for FailsafeConfig {
    fn default() -> Self {
        Self { pilot_lost_hold_s: 10.0, descent_mps: 0.5, late_cycles: 3, saturation_s: 1.0 }
    }
}

/// Everything that flight control is set up with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightControlConfig {
    /// The autopilot.
    pub hover: HoverConfig,
    /// The pilot's switch on the aux channel.
    pub switch: SwitchConfig,
    /// When the pilot's signal counts as lost.
    pub signal: SignalConfig,
    /// When the autopilot may take over.
    pub ready: ReadinessLimits,
    /// What the sticks ask for while it flies; `None`: a stick moved gives the sticks back.
    pub steering: Option<SteeringConfig>,
    /// Whether the throttle stays where it was at engagement; else the pilot's is passed through, and without a
    /// pilot it stays where it was last.
    pub hold_throttle: bool,
    /// What it does when something is lost.
    pub failsafe: FailsafeConfig,
    /// How far it may go.
    pub fence: Option<Fence>,
    /// Test inputs that it flies by itself.
    pub excitation: Option<ExcitationProgramme>,
    /// The servos.
    pub channels: Channels<ChannelConfig>,
    /// How they carry the swashplate.
    pub swashplate: Swashplate,
}

impl FlightControlConfig {
    /// `hover` with defaults for everything else.
    #[must_use]
    pub fn new(hover: HoverConfig) -> Self {
        Self {
            hover,
            switch: SwitchConfig::default(),
            signal: SignalConfig::default(),
            ready: ReadinessLimits::default(),
            steering: None,
            hold_throttle: false,
            failsafe: FailsafeConfig::default(),
            fence: None,
            excitation: None,
            channels: Channels::default(),
            swashplate: Swashplate::default(),
        }
    }

    /// Whether one can fly with it.
    ///
    /// # Errors
    /// The first value that cannot be.
    pub fn check(&self) -> Result<(), FlightControlError> {
        self.hover.check()?;
        self.ready.check()?;
        self.steering.iter().try_for_each(SteeringConfig::check)?;
        self.switch.check()?;
        self.channels.check()?;
        self.swashplate.check(&self.channels)?;
        let failsafe = &self.failsafe;
        within("failsafe.pilot_lost_hold_s", failsafe.pilot_lost_hold_s, 0.0, 600.0)?;
        within("failsafe.descent_mps", failsafe.descent_mps, 0.1, 2.0)?;
        within("failsafe.late_cycles", f64::from(failsafe.late_cycles), 1.0, 100.0)?;
        within("failsafe.saturation_s", failsafe.saturation_s, 0.1, 60.0)?;
        if failsafe.descent_mps > self.hover.guidance.climb_mps {
            let (from, to) = (0.1, self.hover.guidance.climb_mps);
            within("failsafe.descent_mps", failsafe.descent_mps, from, to)?;
        }
        self.excitation.iter().try_for_each(ExcitationProgramme::check)?;
        if let Some(fence) = &self.fence {
            within("fence.radius_m", fence.radius_m, 5.0, 10_000.0)?;
            within("fence.height_m", fence.height_m, 5.0, 1_000.0)?;
            if !fence.centre.is_navigable() {
                return Err(FlightControlError::Centre);
            }
        }
        Ok(())
    }
}

/// A configuration that flight control cannot fly with.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FlightControlError {
    /// A value of the autopilot, of readiness or of steering.
    Autopilot(autopilot::ConfigError),
    /// A value of the servos, the switch or the failsafes.
    Servo(servo::ConfigError),
    /// A value of the test inputs.
    Excitation(ExcitationError),
    /// The fence's middle is no place one can navigate at.
    Centre,
}

impl fmt::Display for FlightControlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Autopilot(error) => error.fmt(f),
            Self::Servo(error) => error.fmt(f),
            Self::Excitation(error) => error.fmt(f),
            Self::Centre => f.write_str("the fence's middle is no place to navigate at"),
        }
    }
}

impl core::error::Error for FlightControlError {}

impl From<autopilot::ConfigError> for FlightControlError {
    fn from(error: autopilot::ConfigError) -> Self {
        Self::Autopilot(error)
    }
}

impl From<servo::ConfigError> for FlightControlError {
    fn from(error: servo::ConfigError) -> Self {
        Self::Servo(error)
    }
}

impl From<ExcitationError> for FlightControlError {
    fn from(error: ExcitationError) -> Self {
        Self::Excitation(error)
    }
}
