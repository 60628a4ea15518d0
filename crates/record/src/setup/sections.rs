//! The sections of `fly.toml`.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::mavlink::MavlinkConfig;
use hovernav::controls::Channels;
use hovernav::gps::Protocol;
use hovernav::gps::quality::Limits;
use hovernav::servo::{ChannelConfig, SignalConfig, Swashplate};

/// `[site]`: position of the flight, to a few kilometres; with a geofence, its centre on the ground.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct SiteSection {
    /// Latitude, °.
    pub latitude_deg: f64,
    /// Longitude, °.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m; 0 where not set. Required for a geofence.
    #[serde(default)]
    pub height_m: f64,
}

/// `[dmu]`: the IMU and its line. Its full-scale ranges are `navigation.imu.gyro_range_degps` and `accel_range_g`, 200
/// °/s and 4 g where not given.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct DmuSection {
    /// The serial port.
    pub port: PathBuf,
    /// Baud rate.
    pub baud: u32,
    /// Type of the packets.
    pub mode: DmuMode,
    /// Packet rate, Hz, 20 to 70; without it, the IMU sends as fast as it can.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Time from a sample to the arrival of its packet's last byte, s; without it, the transmission time on the line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latency_s: Option<f64>,
    /// Whether the accelerometers x, y, z report specific force along (`+`) or against (`-`) their axes.
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

/// Type of the packets with samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DmuMode {
    /// Packets with the IMU's own attitude.
    Angle,
    /// Packets without attitude.
    Scaled,
}

/// Sign of an accelerometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum AccelerationSign {
    /// Along its axis.
    #[serde(rename = "+")]
    Plus,
    /// Against its axis.
    #[serde(rename = "-")]
    Minus,
}

/// `[receiver]`: the GPS receiver and its line. `navigation.gps.latency_s` is the time from the validity of a fix to
/// its arrival.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct ReceiverSection {
    /// The serial port.
    pub port: PathBuf,
    /// Baud rate; without it, the initial rate of the protocol's receivers: 9600, or 4800 for NMEA.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baud: Option<u32>,
    /// Protocol of the receiver.
    pub protocol: ReceiverProtocol,
    /// Rate of fixes of a u-blox receiver, Hz, 1 to 10. For a Trimble receiver 0 leaves the receiver unchanged, any
    /// other number requests the necessary reports.
    pub rate_hz: u8,
    /// Height of the geoid above the ellipsoid at the site, m, for a receiver that does not send it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geoid_separation_m: Option<f64>,
    /// Limits for usable fixes.
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

/// Protocols of receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ReceiverProtocol {
    /// TSIP of Trimble receivers.
    Tsip,
    /// NMEA 0183.
    Nmea,
    /// UBX of u-blox receivers.
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

/// `[record]`: the flight record.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct RecordSection {
    /// Directory of the records, one file for each flight, named after its start.
    pub directory: PathBuf,
    /// Whether `fly` refuses a flight without a record, on the ground. Otherwise it reports a full or read-only
    /// directory and flies without a record.
    pub required: bool,
}

impl Default for RecordSection {
    fn default() -> Self {
        Self { directory: "records".into(), required: false }
    }
}

impl ReceiverSection {
    /// Baud rate of the line.
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
    /// Time for which the last width is repeated without a command, s; then the servos go to trim.
    pub hold_s: f64,
    /// Criteria for a loss of the pilot's signal.
    pub signal: SignalConfig,
    /// Source of the pilot's pulses; without it, there is no pilot and the servos get no pulses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub capture: Option<CaptureSection>,
    /// PWM outputs of the servos; channels without one are not driven.
    pub output: Channels<Option<PwmLine>>,
    /// Serial line to a microcontroller that drives the servos, as in `docs/servo-packet.md`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stream: Option<LineSection>,
    /// Geometry of the swashplate.
    pub swashplate: Swashplate,
    /// Trim, range, direction and rate limit of each servo.
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

/// `[servo.capture]`: source of the pilot's pulses.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CaptureSection {
    /// `serial = { port = …, baud = … }`: a microcontroller that sends servo packets.
    Serial(LineSection),
    /// `gpio = { chip = …, lines = { throttle = 4, … } }`: lines of a Linux GPIO chip.
    Gpio {
        /// The chip, for example `/dev/gpiochip0`.
        chip: PathBuf,
        /// Number of each channel's line.
        lines: Channels<u32>,
        /// Number of the line of the autopilot's switch, if there is one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        aux: Option<u32>,
    },
}

/// A serial line.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct LineSection {
    /// The serial port.
    pub port: PathBuf,
    /// Baud rate.
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
    /// Baud rate.
    #[serde(default = "telemetry_baud")]
    pub baud: u32,
    /// Destination of datagrams, `host:port`; either this or `port`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub udp: Option<String>,
}

/// `[mavlink]`: telemetry in MAVLink 2, on a separate line.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct MavlinkSection {
    /// The serial port; either this or `udp`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub port: Option<PathBuf>,
    /// Baud rate.
    #[serde(default = "telemetry_baud")]
    pub baud: u32,
    /// Destination of datagrams, `host:port`; either this or `port`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub udp: Option<String>,
    /// Sender and message rates.
    #[serde(default)]
    pub speaker: MavlinkConfig,
}

/// An output of the kernel's PWM: `pwmchip{chip}/pwm{output}`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PwmLine {
    /// Number of the chip.
    pub chip: u32,
    /// Number of the output on its chip.
    pub output: u32,
}
