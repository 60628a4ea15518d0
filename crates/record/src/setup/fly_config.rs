//! `fly.toml`: the devices and their lines, and the vehicle.

use std::path::{Path, PathBuf};

use chrono::{DateTime, Datelike as _, Timelike as _};
use serde::{Deserialize, Serialize};

use super::autopilot_section::AutopilotSection;
use super::check::check_numbers;
use super::error::FlyConfigError;
use super::sections::{
    AccelerationSign, DmuMode, DmuSection, MavlinkSection, ReceiverSection, RecordSection,
    ServoSection, SiteSection, TelemetrySection,
};
use hovernav::dmu::{Calibration, Flow, Mode, Sign};
use hovernav::earth::Geodetic;
use hovernav::ekf::EstimatorConfig;
use hovernav::flight_control::FlightControlConfig;
use hovernav::sensors::{DmuConfig, GpsConfig};
use hovernav_dataset::LogError;
use hovernav_dataset::{HeadingReference, Manifest};
use hovernav_toml::TomlError;

/// `fly.toml`: all settings of a flight. An unknown key is an error: on a flight computer a misspelt setting must not
/// fall back to a default.
///
/// ```
/// use hovernav_record::FlyConfig;
/// let text = "
///     [dmu]
///     port = '/dev/ttyS0'
///     [receiver]
///     port = '/dev/ttyS1'
///     protocol = 'ubx'
///     rate_hz = 5
///     [navigation.imu]
///     lever_arm_m = [0.03, -0.02, 0.28]
///     gyro_range_degps = 200
///     accel_range_g = 4
/// ";
/// let config = FlyConfig::parse(text, "fly.toml".as_ref())?;
/// assert_eq!(config.dmu.rate_hz, Some(33.0));
/// assert_eq!(config.sensors()?.1.rate_hz, Some(5));
/// # Ok::<(), hovernav_record::FlyConfigError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct FlyConfig {
    /// Real-time priority of the loop's thread, 1 to 99; ordinary priority if not set. If the permission
    /// (`CAP_SYS_NICE`) is missing, the flight reports it and continues.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub realtime_priority: Option<u8>,
    /// The IMU.
    pub dmu: DmuSection,
    /// The GPS receiver.
    pub receiver: ReceiverSection,
    /// The pilot's pulses and the servos.
    pub servo: ServoSection,
    /// The autopilot, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub autopilot: Option<AutopilotSection>,
    /// Telemetry in packed frames, sent while the ground station requests it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub telemetry: Option<TelemetrySection>,
    /// Telemetry in MAVLink 2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mavlink: Option<MavlinkSection>,
    /// The flight record.
    pub record: RecordSection,
    /// Position of the flight, required without a magnetic declination.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub site: Option<SiteSection>,
    /// Mounting and accuracy of the sensors, and the estimator's settings: the keys of a `dataset.toml`. The IMU's
    /// heading counts as magnetic unless `imu.heading_reference` is set otherwise.
    pub navigation: Manifest,
}

impl FlyConfig {
    /// Reads a configuration for a flight; checks every value, and that every device has a separate line.
    ///
    /// # Errors
    /// [`FlyConfigError`].
    pub fn read(path: &Path) -> Result<Self, FlyConfigError> {
        let config = Self::parse(&hovernav_toml::read_text(path)?, path)?;
        config.check_lines()?;
        Ok(config)
    }

    /// Parses the configuration in `text`, and checks that every number permits a flight; `path` names it in messages.
    ///
    /// # Errors
    /// [`FlyConfigError`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, FlyConfigError> {
        // Before the conversion to types, so that NaN is reported like any other number out of range.
        check_numbers(&[], &toml::Value::Table(hovernav_toml::parse_table(text, path)?))?;
        let config = Self::parse_flown(text, path)?;
        if let Some(section) = &config.autopilot {
            section.check_sticks(&config.servo)?;
        }
        Ok(config)
    }

    /// Checks that every number permits a flight. NaN, which would disable a check, never does. The autopilot's own
    /// numbers are included once its file is loaded.
    fn check_ranges(&self) -> Result<(), FlyConfigError> {
        let spelled = hovernav_toml::to_value(self)
            .map_err(|error| FlyConfigError::value("", "settings", &error))?;
        check_numbers(&[], &spelled)
    }

    /// Parses the configuration in `text` without checks of the numbers, for a configuration that has flown: its record
    /// must stay readable.
    ///
    /// # Errors
    /// [`FlyConfigError`].
    pub(crate) fn parse_flown(text: &str, path: &Path) -> Result<Self, FlyConfigError> {
        let table = toml::Value::Table(hovernav_toml::parse_table(text, path)?);
        let (mut config, keys): (Self, _) = hovernav_toml::parse(text, path)?;
        if !keys.is_empty() {
            return Err(FlyConfigError::UnknownKeys { path: path.to_path_buf(), keys });
        }
        let heading = ["navigation", "imu", "heading_reference"];
        if heading.iter().try_fold(&table, |value, key| value.get(key)).is_none() {
            config.navigation.imu.heading_reference = HeadingReference::Magnetic;
        }
        let site_height = table.get("site").and_then(|site| site.get("height_m"));
        if config.autopilot.as_ref().is_some_and(|own| own.geofence.is_some())
            && config.site.is_some()
            && site_height.is_none()
        {
            let why = "found none, expected one: the height of the geofence is measured from it";
            return Err(value("site", "height_m", &why));
        }
        config.sensors()?;
        config.check_servos()?;
        if let Some(section) = &config.telemetry {
            check_ground_line("telemetry", section.port.as_deref(), section.udp.as_deref())?;
        }
        if let Some(section) = &config.mavlink {
            check_ground_line("mavlink", section.port.as_deref(), section.udp.as_deref())?;
        }
        if let Some(section) = &config.mavlink {
            section.speaker.check().map_err(|(key, why)| value("mavlink", key, &why))?;
        }
        Ok(config)
    }

    /// Fills in the values that depend on the time of the flight, `unix_s` seconds after the start of 1970. Without a
    /// date or a magnetic declination it sets them, the declination from the World Magnetic Model for the site on that
    /// day. The remark states its origin. Afterwards the settings depend only on this configuration.
    ///
    /// # Errors
    /// Neither a declination nor a site; a site that is not on Earth; impossible settings of the estimator.
    pub fn settle(&mut self, unix_s: i64) -> Result<Option<String>, FlyConfigError> {
        let mut remark = None;
        if self.navigation.date.is_none()
            && let Some(now) = DateTime::from_timestamp_secs(unix_s)
        {
            self.navigation.date =
                format!("{:04}-{:02}-{:02}", now.year(), now.month(), now.day()).parse().ok();
        }
        if self.navigation.imu.magnetic_declination_deg.is_none() {
            let Some(site) = self.site else {
                return Err(value(
                    "navigation.imu",
                    "magnetic_declination_deg",
                    &"found neither this nor a [site], expected one, for a heading from true north",
                ));
            };
            let place =
                Geodetic::from_degrees(site.latitude_deg, site.longitude_deg, site.height_m)
                    .ok_or_else(|| {
                        let found = format!("{} and {}", site.latitude_deg, site.longitude_deg);
                        value("site", "latitude_deg", &expected(found, "a position on Earth"))
                    })?;
            let settings =
                self.navigation.settings(true, Some(&place)).map_err(navigation_value)?;
            self.navigation.imu.magnetic_declination_deg =
                Some(settings.0.alignment.declination_rad.to_degrees());
            remark = settings.1.map(|how| how.to_string());
        }
        self.settings()?;
        Ok(remark)
    }

    /// The estimator's settings.
    ///
    /// # Errors
    /// Impossible settings.
    pub fn settings(&self) -> Result<EstimatorConfig, FlyConfigError> {
        Ok(self.navigation.settings(true, None).map_err(navigation_value)?.0)
    }

    /// Path of the record of a flight that starts `unix_s` seconds after the start of 1970. It is a file in the
    /// directory `record.directory`, named after the second in UTC.
    #[must_use]
    pub fn record_path(&self, unix_s: i64) -> PathBuf {
        let name = DateTime::from_timestamp_secs(unix_s).map_or_else(
            || format!("{unix_s}.mcap"),
            |at| {
                let (year, month, day) = (at.year(), at.month(), at.day());
                let (hour, minute, second) = (at.hour(), at.minute(), at.second());
                format!("{year:04}-{month:02}-{day:02}T{hour:02}-{minute:02}-{second:02}Z.mcap")
            },
        );
        self.record.directory.join(name)
    }

    /// Reads the autopilot's file, whose relative path is relative to `directory`, and stores its parameters, so that
    /// the configuration is complete without the file.
    ///
    /// # Errors
    /// See [`AutopilotSection::load`].
    pub fn load_autopilot(&mut self, directory: &Path) -> Result<(), FlyConfigError> {
        if let Some(section) = &mut self.autopilot {
            let flown = section.load(directory, &self.servo)?;
            let (period_s, rate_hz) = (flown.period_s, self.dmu.rate_hz);
            if let Some(rate_hz) = rate_hz
                && (rate_hz * period_s - 1.0).abs() > 0.02
            {
                let designed_hz = 1.0 / period_s;
                let why = format!(
                    "found gains for {designed_hz:.2} Hz, expected the loop's {rate_hz} Hz, dmu.rate_hz"
                );
                return Err(value("autopilot", "file", &why));
            }
            section.flown = Some(flown);
        }
        self.check_ranges()?;
        self.flight_control()?;
        Ok(())
    }

    /// Configuration of flight control; `None` without an autopilot, or before its file is loaded.
    ///
    /// # Errors
    /// A value with which no flight is possible.
    pub fn flight_control(&self) -> Result<Option<FlightControlConfig>, FlyConfigError> {
        let section = self.autopilot.as_ref();
        let config =
            section.and_then(|section| section.flight_control(&self.servo, self.site.as_ref()));
        if let Some(config) = &config {
            config.check().map_err(|error| value("autopilot", "settings", &error))?;
        }
        Ok(config)
    }

    /// Checks swashplate, channels, and the parts of the autopilot that do not need its file.
    fn check_servos(&self) -> Result<(), FlyConfigError> {
        let servo = &self.servo;
        servo
            .swashplate
            .check(&servo.channels)
            .map_err(|error| value("servo", "swashplate", &error))?;
        if servo.stream.is_some() && servo.output.iter().any(|(_, line)| line.is_some()) {
            let why = "found [servo.output] too, expected one way to the servos";
            return Err(value("servo", "stream", &why));
        }
        let Some(section) = &self.autopilot else { return Ok(()) };
        if section.geofence.is_some() && self.site.is_none() {
            let why = "found no [site], expected one: it is the centre of the geofence";
            return Err(value("autopilot", "geofence", &why));
        }
        section.check(servo)
    }

    /// The configuration as a TOML file with every key.
    ///
    /// # Errors
    /// Values that TOML cannot hold; a parsed configuration has none.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        hovernav_toml::to_string(self)
    }

    /// Configurations of the sensors, for [`Sensors::new`](hovernav::sensors::Sensors::new).
    ///
    /// # Errors
    /// [`FlyConfigError::Value`] for an impossible range, rate or latency.
    pub fn sensors(&self) -> Result<(DmuConfig, GpsConfig), FlyConfigError> {
        if let Some(found) = self.realtime_priority.filter(|found| !(1..=99).contains(found)) {
            return Err(value("", "realtime_priority", &expected(found, "1 to 99")));
        }
        let mode = match self.dmu.mode {
            DmuMode::Angle => Mode::Angle,
            DmuMode::Scaled => Mode::Scaled,
        };
        let imu = &self.navigation.imu;
        let calibration = Calibration::new(
            imu.gyro_range_degps.unwrap_or(200.0),
            imu.accel_range_g.unwrap_or(4.0),
        )
        .map_err(|error| value("navigation.imu", "gyro_range_degps, accel_range_g", &error))?
        .with_acceleration_signs(self.dmu.acceleration_signs.map(|sign| match sign {
            AccelerationSign::Plus => Sign::Positive,
            AccelerationSign::Minus => Sign::Negative,
        }));
        let flow = match self.dmu.rate_hz {
            None => Flow::Continuous,
            Some(rate_hz) if (20.0..=70.0).contains(&rate_hz) => {
                Flow::Polled { cycle_s: 1.0 / rate_hz }
            }
            Some(rate_hz) => {
                return Err(value("dmu", "rate_hz", &expected(rate_hz, "20 to 70 a second")));
            }
        };
        let latency_s = self.dmu.latency_s.unwrap_or_else(|| mode.transfer_time_s());
        if !(0.0..=0.1).contains(&latency_s) {
            return Err(value("dmu", "latency_s", &expected(latency_s, "0 to 0.1 s")));
        }
        let separation_m = self.receiver.geoid_separation_m;
        if let Some(found) = separation_m.filter(|found| !(-120.0..=100.0).contains(found)) {
            return Err(value("receiver", "geoid_separation_m", &expected(found, "-120 to 100 m")));
        }
        let rate_hz = self.receiver.rate_hz;
        if rate_hz > 10 {
            return Err(value("receiver", "rate_hz", &expected(rate_hz, "0 to 10 a second")));
        }
        Ok((
            DmuConfig { mode, flow, calibration, latency_s },
            GpsConfig {
                protocol: self.receiver.protocol.into(),
                rate_hz: (rate_hz > 0).then_some(rate_hz),
                latency_s: self.navigation.gps.latency_s,
                geoid_separation_m: separation_m,
                limits: self.receiver.limits,
            },
        ))
    }
}

/// Checks that a line to the ground has either a port or an address.
fn check_ground_line(
    section: &'static str,
    port: Option<&Path>,
    udp: Option<&str>,
) -> Result<(), FlyConfigError> {
    let Some(address) = udp else {
        return match port {
            Some(_) => Ok(()),
            None => Err(value(section, "port", &"found neither port nor udp, expected one")),
        };
    };
    if port.is_some() {
        return Err(value(section, "udp", &"found port too, expected one of the two"));
    }
    let number = address.rsplit_once(':').filter(|(host, _)| !host.is_empty());
    match number.and_then(|(_, number)| number.parse::<u16>().ok()) {
        Some(1..) => Ok(()),
        _ => Err(value(section, "udp", &expected(format!("\"{address}\""), "host:port"))),
    }
}

fn expected(found: impl std::fmt::Display, range: &str) -> String {
    format!("found {found}, expected {range}")
}

fn value(
    section: &'static str,
    key: &'static str,
    reason: &impl std::fmt::Display,
) -> FlyConfigError {
    FlyConfigError::value(section, key, reason)
}

fn navigation_value(error: LogError) -> FlyConfigError {
    match error {
        // An error in a section with its own parser already contains the key: "[filter] …".
        LogError::Toml(TomlError::Text { reason, .. }) => {
            match reason.strip_prefix('[').and_then(|rest| rest.split_once("] ")) {
                Some((section, rest)) if rest.contains(": ") => {
                    let (key, why) = rest.split_once(": ").unwrap_or((rest, ""));
                    FlyConfigError::value(format!("navigation.{section}"), key, &why)
                }
                _ => value("navigation", "settings", &reason),
            }
        }
        other => value("navigation", "settings", &other),
    }
}
