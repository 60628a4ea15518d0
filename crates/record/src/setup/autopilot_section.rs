//! `[autopilot]` of `fly.toml`: the autopilot that flies while the pilot's switch is closed, and its conditions.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::autopilot::read_autopilot;
use super::check::check_numbers;
use super::error::FlyConfigError;
use super::excitation_section::ExcitationSection;
use super::reach;
use super::sections::{CaptureSection, ServoSection, SiteSection};
use hovernav::autopilot::{HoverConfig, ReadinessLimits, SteeringConfig};
use hovernav::earth::Geodetic;
use hovernav::flight_control::{FailsafeConfig, FlightControlConfig, Geofence};
use hovernav::servo::SwitchConfig;

/// `[autopilot]`: the autopilot that flies while the pilot's switch is closed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct AutopilotSection {
    /// Output of `hovernav design`; a relative path is relative to the directory of `fly.toml`.
    pub file: PathBuf,
    /// Model of the vehicle: a `model.toml`, relative to the directory of `fly.toml`, or the name of a model that comes
    /// with hovernav. Gains that are unstable with it are rejected before the flight; without it they are not tested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<PathBuf>,
    /// The switch on the aux channel.
    #[serde(default)]
    pub switch: SwitchConfig,
    /// Conditions for engagement.
    #[serde(default)]
    pub ready: ReadinessLimits,
    /// Effect of the pilot's sticks while the autopilot flies.
    #[serde(default)]
    pub pilot: PilotRole,
    /// With `pilot = "steer"`: the commands of the sticks. With `pilot = "override"` other values than the defaults are
    /// rejected, because they would have no effect.
    #[serde(default)]
    pub steering: SteeringConfig,
    /// With `pilot = "steer"`: deflection of a stick from its position at engagement that returns control to the pilot,
    /// above `steering.full_stick`, up to 1; 0.8 where not set. With `pilot = "override"` it is rejected:
    /// `transfer.override_travel` of the file applies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub override_travel: Option<f64>,
    /// Throttle while the autopilot flies.
    #[serde(default)]
    pub throttle: ThrottleSource,
    /// Response to a loss of sensors, pilot or servos.
    #[serde(default)]
    pub failsafe: FailsafeConfig,
    /// Limits of the distance from `[site]`; unlimited if not set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[serde(alias = "fence")]
    pub geofence: Option<GeofenceSection>,
    /// Test inputs that the autopilot flies automatically; no test inputs if not set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excitation: Option<ExcitationSection>,
    /// The autopilot's parameters in flight: its file with the changes of this section. Set at the start of a flight,
    /// so that the record is complete.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flown: Option<HoverConfig>,
}

/// [`AutopilotSection::override_travel`] if it is not set.
const STEERED_OVERRIDE: f64 = 0.8;

/// `[autopilot.geofence]`: limits of the distance from `[site]`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GeofenceSection {
    /// Horizontal distance, m, from 5 to 10 000.
    pub radius_m: f64,
    /// Height above the site, m, from 5 to 1000.
    pub height_m: f64,
}

/// Effect of the pilot's sticks while the autopilot flies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PilotRole {
    /// A moved stick returns control to the pilot.
    #[default]
    Override,
    /// A moved stick commands a velocity, a released one a hold.
    Steer,
}

/// Throttle while the autopilot flies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ThrottleSource {
    /// The pilot's pulses pass through; without a pilot the throttle keeps its last value.
    #[default]
    Pass,
    /// The throttle keeps its value at engagement.
    Hold,
}

impl AutopilotSection {
    /// Loads the autopilot from `file`, a relative path relative to `directory`, and applies the changes of this
    /// section.
    ///
    /// # Errors
    /// A file that cannot be read or flown with, and every impossible value in this section: see [`FlyConfigError`].
    pub fn load(
        &self,
        directory: &Path,
        servo: &ServoSection,
    ) -> Result<HoverConfig, FlyConfigError> {
        if let Some(flown) = self.flown {
            return Ok(flown);
        }
        self.check(servo)?;
        let path = directory.join(&self.file);
        if !path.exists() {
            let why = format!(
                "found no file {}, expected an autopilot: run `hovernav design` first",
                path.display()
            );
            return Err(FlyConfigError::value("autopilot", "file", &why));
        }
        let reject =
            |error: &dyn std::fmt::Display| FlyConfigError::value("autopilot", "file", &error);
        let text = hovernav_toml::read_text(&path).map_err(|error| reject(&error))?;
        let table = hovernav_toml::parse_table(&text, &path).map_err(|error| reject(&error))?;
        check_numbers(&["autopilot", "flown"], &toml::Value::Table(table))?;
        let mut config = read_autopilot(&path).map_err(|error| reject(&error))?;
        check_room(&config)?;
        config.limits = reach::within_servos(&config, servo)?;
        if self.pilot == PilotRole::Steer {
            config.transfer.override_travel =
                self.override_travel.unwrap_or(STEERED_OVERRIDE).min(1.0);
            let guidance = config.guidance;
            for (key, asked, most) in [
                ("steering.speed_mps", self.steering.speed_mps, guidance.speed_mps),
                ("steering.climb_mps", self.steering.climb_mps, guidance.climb_mps),
                ("steering.yaw_rate_radps", self.steering.yaw_rate_radps, guidance.yaw_rate_radps),
            ] {
                if asked > most {
                    let why = format!(
                        "found {asked}, expected at most {most}, the limit under [guidance] of its file"
                    );
                    return Err(FlyConfigError::value("autopilot", key, &why));
                }
            }
        }
        Ok(config)
    }

    /// The geofence, with its centre at `site`; `None` without either.
    #[must_use]
    pub fn geofence_about(&self, site: Option<&SiteSection>) -> Option<Geofence> {
        let (geofence, site) = self.geofence.zip(site)?;
        let centre = Geodetic::from_degrees(site.latitude_deg, site.longitude_deg, site.height_m)?;
        Some(Geofence { centre, radius_m: geofence.radius_m, height_m: geofence.height_m })
    }

    /// Configuration of flight control; `None` before the autopilot's file is loaded.
    #[must_use]
    pub fn flight_control(
        &self,
        servo: &ServoSection,
        site: Option<&SiteSection>,
    ) -> Option<FlightControlConfig> {
        let steers = self.pilot == PilotRole::Steer;
        let mut config = FlightControlConfig::new(self.flown?);
        config.switch = self.switch;
        config.signal = servo.signal;
        config.ready = self.ready;
        config.steering = steers.then_some(self.steering);
        config.hold_throttle = self.throttle == ThrottleSource::Hold;
        config.failsafe = self.failsafe;
        config.geofence = self.geofence_about(site);
        config.excitation = self.excitation.as_ref().and_then(|section| section.programme().ok());
        config.channels = servo.channels;
        config.swashplate = servo.swashplate;
        Some(config)
    }

    /// Checks everything that does not need the file.
    pub(super) fn check(&self, servo: &ServoSection) -> Result<(), FlyConfigError> {
        let reject = |key, error: &dyn std::fmt::Display| {
            Err(FlyConfigError::value("autopilot", key, &error.to_string()))
        };
        if servo.capture.is_none() {
            return reject(
                "switch",
                &"found no [servo.capture], expected one: it contains the pilot's switch",
            );
        }
        if let Some(CaptureSection::Gpio { aux: None, .. }) = servo.capture {
            return reject("switch", &"found no aux line in [servo.capture] gpio, expected one");
        }
        if let Err(error) = self.switch.check() {
            return reject("switch", &error);
        }
        if let Err(error) = self.ready.check() {
            return reject("ready", &error);
        }
        if let Err(error) = self.steering.check() {
            return reject("steering", &error);
        }
        if let Some(Err(error)) = self.excitation.as_ref().map(ExcitationSection::programme) {
            return reject("excitation", &error);
        }
        let travel = self.override_travel.unwrap_or(STEERED_OVERRIDE);
        let full_stick = self.steering.full_stick;
        if self.pilot == PilotRole::Steer && !(travel > full_stick && travel <= 1.0) {
            let why = format!(
                "found {travel}, expected more than steering.full_stick, {full_stick}, to 1"
            );
            return reject("override_travel", &why);
        }
        Ok(())
    }

    /// Checks that do not apply to the records of earlier flights: keys without an effect, and servos that move one way
    /// only.
    pub(super) fn check_sticks(&self, servo: &ServoSection) -> Result<(), FlyConfigError> {
        if let (PilotRole::Override, Some(found)) = (self.pilot, self.override_travel) {
            let why = format!(
                "found {found} with pilot = \"override\", expected no value, because transfer.override_travel of the \
                 autopilot's file applies; or set pilot = \"steer\""
            );
            return Err(FlyConfigError::value("autopilot", "override_travel", &why));
        }
        if self.pilot == PilotRole::Override && self.steering != SteeringConfig::default() {
            let why = "found values with pilot = \"override\", expected no values, because the sticks command nothing; \
                       or set pilot = \"steer\"";
            return Err(FlyConfigError::value("autopilot", "steering", &why));
        }
        reach::check_travel(servo)
    }
}

/// Checks that every control can move both ways from its position in hover.
fn check_room(config: &HoverConfig) -> Result<(), FlyConfigError> {
    let HoverConfig { limits, trim, .. } = config;
    let ends = limits.lowest.to_array().into_iter().zip(limits.highest.to_array());
    for ((lowest, highest), trim) in ends.zip(trim.sticks.to_array()) {
        if trim - lowest < reach::ROOM || highest - trim < reach::ROOM {
            let why = format!(
                "its limits.lowest and limits.highest: found {lowest} to {highest} about trim.sticks at {trim}, \
                 expected {} of full stick to either side",
                reach::ROOM
            );
            return Err(FlyConfigError::value("autopilot", "file", &why));
        }
    }
    Ok(())
}
