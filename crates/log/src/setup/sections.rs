//! The sections of `fly.toml`.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::mavlink::MavlinkConfig;
use hovernav::controls::Channels;
use hovernav::gps::Protocol;
use hovernav::gps::quality::Limits;
use hovernav::servo::{ChannelConfig, SignalConfig, Swashplate};

/// `[site]`: where the flight is, to a few kilometres; with a fence, its middle on the ground.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct SiteSection {
    /// Latitude, °.
    pub latitude_deg: f64,
    /// Longitude, °.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m, 0 where not set; a fence needs it.
    #[serde(default)]
    pub height_m: f64,
}

/// `[dmu]`: the inertial unit and its line. Its ranges are `navigation.imu.gyro_range_degps` and
/// `accel_range_g`, 200 °/s and 4 g where not given.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct DmuSection {
    /// The serial port.
    pub port: PathBuf,
    /// Its speed, baud.
    pub baud: u32,
    /// Which packets to ask for.
    pub mode: DmuMode,
    /// Packets asked for in a second, 20 to 70; without, the unit sends as fast as it can.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// From a sample to the arrival of its packet's last byte, s; without, the time on the line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency_s: Option<f64>,
    /// Whether the accelerometers x, y, z count specific force along (`+`) or against (`-`) their
    /// axes.
    pub acceleration_signs: [AccelerationSign; 3],
}

impl Default for DmuSection {
    fn default() -> Self {
        Self {
            port: PathBuf::new(),
            baud: 38_400,
            mode: DmuMode::Angle,
            rate_hz: Some(33.0),
            latency_s: None,
            acceleration_signs: [AccelerationSign::Minus; 3],
        }
    }
}

/// The packets that hold samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DmuMode {
    /// With the unit's own attitude.
    Angle,
    /// Without.
    Scaled,
}

/// Which way an accelerometer counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum AccelerationSign {
    /// Along its axis.
    #[serde(rename = "+")]
    Plus,
    /// Against its axis.
    #[serde(rename = "-")]
    Minus,
}

/// `[receiver]`: the GPS receiver and its line. The time a fix takes to arrive is
/// `navigation.gps.latency_s`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct ReceiverSection {
    /// The serial port.
    pub port: PathBuf,
    /// Its speed, baud; without, what the protocol's receivers start with: 9600, 4800 of NMEA.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baud: Option<u32>,
    /// Its language.
    pub protocol: ReceiverProtocol,
    /// Fixes a second to set a u-blox receiver to, 1 to 10; for a Trimble receiver any number here
    /// means that it is told which reports to send. 0 leaves the receiver as it is.
    pub rate_hz: u8,
    /// The geoid's height above the ellipsoid at the site, m, for a receiver that does not send it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geoid_separation_m: Option<f64>,
    /// Which fixes are good enough.
    pub limits: Limits,
}

impl Default for ReceiverSection {
    fn default() -> Self {
        Self {
            port: PathBuf::new(),
            baud: None,
            protocol: ReceiverProtocol::Tsip,
            rate_hz: 1,
            geoid_separation_m: None,
            limits: Limits::default(),
        }
    }
}

/// The languages of receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ReceiverProtocol {
    /// Trimble's.
    Tsip,
    /// NMEA 0183.
    Nmea,
    /// u-blox's.
    Ubx,
}

impl From<ReceiverProtocol> for Protocol {
    fn from(protocol: ReceiverProtocol) -> Self {
        match protocol {
            ReceiverProtocol::Tsip => Self::Tsip,
            ReceiverProtocol::Nmea => Self::Nmea,
            ReceiverProtocol::Ubx => Self::Ubx,
        }
    }
}

/// `[record]`: where the flight record goes.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct RecordSection {
    /// The directory that takes one file a flight, named after the moment it began.
    pub directory: PathBuf,
}

impl Default for RecordSection {
    fn default() -> Self {
        Self { directory: "records".into() }
    }
}

impl ReceiverSection {
    /// The line's speed, baud.
    #[must_use]
    pub fn baud(&self) -> u32 {
        self.baud.unwrap_or(match self.protocol {
            ReceiverProtocol::Nmea => 4_800,
            ReceiverProtocol::Tsip | ReceiverProtocol::Ubx => 9_600,
        })
    }
}

/// `[servo]`: the pilot's pulses and the servos.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct ServoSection {
    /// How long the last width is sent on when there is no command, s; then the servos go to trim.
    pub hold_s: f64,
    /// When the pilot counts as lost.
    pub signal: SignalConfig,
    /// Where the pilot's pulses come from; without, there is no pilot and the servos stay silent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capture: Option<CaptureSection>,
    /// The PWM outputs of the servos; channels without one are not driven.
    pub output: Channels<Option<PwmLine>>,
    /// A serial line to a microcontroller that drives the servos, by `docs/servo-packet.md`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stream: Option<LineSection>,
    /// How the servos carry the swashplate.
    pub swashplate: Swashplate,
    /// Trim, range, direction and speed of each.
    pub channels: Channels<ChannelConfig>,
}

impl Default for ServoSection {
    fn default() -> Self {
        Self {
            hold_s: 0.5,
            signal: SignalConfig::default(),
            capture: None,
            output: Channels::default(),
            stream: None,
            swashplate: Swashplate::default(),
            channels: Channels::default(),
        }
    }
}

/// `[servo.capture]`: one of the ways to have the pilot's pulses.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CaptureSection {
    /// `serial = { port = …, baud = … }`: a microcontroller that sends servo packets.
    Serial(LineSection),
    /// `gpio = { chip = …, lines = { throttle = 4, … } }`: lines of a Linux GPIO chip.
    Gpio {
        /// The chip, `/dev/gpiochip0` say.
        chip: PathBuf,
        /// Number of each channel's line.
        lines: Channels<u32>,
        /// Number of the line of the switch for the autopilot, where there is one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        aux: Option<u32>,
    },
}

/// A serial line.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct LineSection {
    /// The serial port.
    pub port: PathBuf,
    /// Its speed, baud.
    #[serde(default = "telemetry_baud")]
    pub baud: u32,
}

const fn telemetry_baud() -> u32 {
    57_600
}

/// `[telemetry]`: telemetry in packed frames, on a serial port or by UDP.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct TelemetrySection {
    /// The serial port; either this or `udp`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub port: Option<PathBuf>,
    /// Its speed, baud.
    #[serde(default = "telemetry_baud")]
    pub baud: u32,
    /// Where datagrams go, `host:port`; either this or `port`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub udp: Option<String>,
}

/// `[mavlink]`: telemetry in MAVLink 2, on a line of its own.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct MavlinkSection {
    /// The serial port; either this or `udp`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub port: Option<PathBuf>,
    /// Its speed, baud.
    #[serde(default = "telemetry_baud")]
    pub baud: u32,
    /// Where datagrams go, `host:port`; either this or `port`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub udp: Option<String>,
    /// Who speaks, and how much.
    #[serde(default)]
    pub speaker: MavlinkConfig,
}

/// One output of the kernel's PWM: `pwmchip{chip}/pwm{output}`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PwmLine {
    /// Number of the chip.
    pub chip: u32,
    /// Number of the output on its chip.
    pub output: u32,
}
