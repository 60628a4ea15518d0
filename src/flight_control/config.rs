//! The configuration of flight control.

use core::fmt;

use crate::autopilot::{
    self, ExcitationError, ExcitationProgramme, HoverConfig, ReadinessLimits, SteeringConfig,
};
use crate::controls::Channels;
use crate::earth::Geodetic;
use crate::servo::{self, ChannelConfig, SignalConfig, Swashplate, SwitchConfig, within};

/// Limits of the vehicle's position while the autopilot flies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geofence {
    /// Centre of the geofence, on the ground.
    pub centre: Geodetic,
    /// Horizontal distance from the centre, m, from 5 to 10 000.
    pub radius_m: f64,
    /// Height above the centre, m, from 5 to 1000.
    pub height_m: f64,
}

/// Responses of flight control to the loss of a signal or of time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct FailsafeConfig {
    /// Time, s, for which the autopilot holds position without a pilot before it descends, 0 to 600.
    pub pilot_lost_hold_s: f64,
    /// Sink rate of the descent without a pilot, m/s, 0.1 to 2.
    pub descent_mps: f64,
    /// Number of consecutive late cycles after which the pilot gets the sticks back, 1 to 100.
    pub late_cycles: u8,
    /// Time, s, for which a stick must be at its end before a notice reports it, 0.1 to 60.
    pub saturation_s: f64,
}

impl Default for FailsafeConfig {
    fn default() -> Self {
        Self { pilot_lost_hold_s: 10.0, descent_mps: 0.5, late_cycles: 3, saturation_s: 1.0 }
    }
}

/// The complete configuration of flight control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightControlConfig {
    /// The autopilot.
    pub hover: HoverConfig,
    /// The pilot's switch on the aux channel.
    pub switch: SwitchConfig,
    /// Conditions for the loss of the pilot's signal.
    pub signal: SignalConfig,
    /// Limits of the readiness checks for the autopilot to take over.
    pub ready: ReadinessLimits,
    /// Motion that the pilot's sticks request while the autopilot flies. With `None`, a moved stick gives the sticks
    /// back to the pilot.
    pub steering: Option<SteeringConfig>,
    /// Whether the throttle stays at its position at engagement. Otherwise the pilot's throttle is passed through;
    /// without a pilot the throttle stays at its last position.
    pub hold_throttle: bool,
    /// Responses to the loss of a signal or of time.
    pub failsafe: FailsafeConfig,
    /// Limits of the vehicle's position; `None` for no limits.
    pub geofence: Option<Geofence>,
    /// Test inputs that the autopilot flies by itself.
    pub excitation: Option<ExcitationProgramme>,
    /// The servos.
    pub channels: Channels<ChannelConfig>,
    /// Mixing of the swashplate's servos.
    pub swashplate: Swashplate,
}

impl FlightControlConfig {
    /// A configuration with `hover`, and defaults for everything else.
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
            geofence: None,
            excitation: None,
            channels: Channels::default(),
            swashplate: Swashplate::default(),
        }
    }

    /// Checks that flight control can fly with the configuration.
    ///
    /// # Errors
    /// [`FlightControlError`] with the first invalid value.
    pub fn check(&self) -> Result<(), FlightControlError> {
        self.hover.check()?;
        self.ready.check()?;
        if let Some(steering) = &self.steering {
            steering.check()?;
            // Guidance rejects a faster set-point: a stick pushed further would then have no effect.
            let guidance = &self.hover.guidance;
            within("steering.speed_mps", steering.speed_mps, 0.1, guidance.speed_mps)?;
            within("steering.climb_mps", steering.climb_mps, 0.1, guidance.climb_mps)?;
            within(
                "steering.yaw_rate_radps",
                steering.yaw_rate_radps,
                0.05,
                guidance.yaw_rate_radps,
            )?;
        }
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
        if let Some(geofence) = &self.geofence {
            within("geofence.radius_m", geofence.radius_m, 5.0, 10_000.0)?;
            within("geofence.height_m", geofence.height_m, 5.0, 1_000.0)?;
            if !geofence.centre.is_navigable() {
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
    /// The centre of the geofence is not a position where navigation is possible.
    Centre,
}

impl fmt::Display for FlightControlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Autopilot(error) => error.fmt(f),
            Self::Servo(error) => error.fmt(f),
            Self::Excitation(error) => error.fmt(f),
            Self::Centre => {
                f.write_str("geofence: the centre is not a position where navigation is possible")
            }
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
