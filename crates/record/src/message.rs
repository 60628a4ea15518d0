//! Messages of a record in their JSON form.

use std::collections::BTreeMap;

use hovernav::glam::DQuat;
use serde::{Deserialize, Serialize};

use crate::entry::Cycle;
use hovernav::autopilot::Mode;
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::ekf::{Innovation, Solution, Verdict};
use hovernav::frames::{Rotation, Vector};
use hovernav::gps::ReceiverFix;
use hovernav::gps::quality::Failures;
use hovernav::time::Time;

#[derive(Debug, Serialize, Deserialize)]
pub struct ConfigurationMessage {
    pub version: String,
    pub start_ns: i64,
    pub start_unix_ns: i64,
    pub fly_toml: String,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct RawMessage {
    pub time_ns: i64,
    /// Whether the next message on this topic continues the same call.
    pub goes_on: bool,
    pub hex: String,
}

impl RawMessage {
    pub fn new(time: Time, goes_on: bool, bytes: &[u8]) -> Self {
        const DIGITS: &[u8; 16] = b"0123456789abcdef";
        let digit = |nibble: u8| char::from(DIGITS[usize::from(nibble & 0xF)]);
        let hex = bytes.iter().flat_map(|byte| [digit(byte >> 4), digit(*byte)]).collect();
        Self { time_ns: time.nanoseconds(), goes_on, hex }
    }

    /// The bytes; `None` if the text is not pairs of hexadecimal digits.
    pub fn bytes(&self) -> Option<Vec<u8>> {
        let value = |digit: u8| char::from(digit).to_digit(16);
        let (pairs, rest) = self.hex.as_bytes().as_chunks::<2>();
        if !rest.is_empty() {
            return None;
        }
        pairs.iter().map(|&[high, low]| Some((value(high)? << 4 | value(low)?) as u8)).collect()
    }
}

#[derive(Debug, Serialize, Deserialize)]
pub struct RestartMessage {
    pub time_ns: i64,
}

#[derive(Debug, Serialize)]
pub struct ImuMessage {
    pub time_ns: i64,
    pub angular_rate_body_radps: [f64; 3],
    pub specific_force_body_mps2: [f64; 3],
    pub magnetic_field_body_gauss: [f64; 3],
    pub temperature_degc: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roll_pitch_yaw_deg: Option<[f64; 3]>,
}

#[derive(Debug, Serialize)]
pub struct FixMessage {
    pub time_ns: i64,
    /// UTC of the fix according to the receiver, ns since the start of 1970.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub utc_ns: Option<i64>,
    pub used: bool,
    #[serde(skip_serializing_if = "String::is_empty")]
    pub refused_for: String,
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub altitude_msl_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_north_east_mps: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_down_mps: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_sigma_ned_m: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_sigma_ned_mps: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub satellites: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_dilution: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub horizontal_dilution: Option<f64>,
}

impl FixMessage {
    pub fn new(fix: &ReceiverFix, failures: &Failures) -> Self {
        let reasons: Vec<String> = failures.iter().map(ToString::to_string).collect();
        Self {
            time_ns: fix.arrival.nanoseconds(),
            utc_ns: fix.time.and_then(|time| time.unix_ns()),
            used: failures.is_empty(),
            refused_for: reasons.join("; "),
            latitude_deg: fix.latitude_rad.to_degrees(),
            longitude_deg: fix.longitude_rad.to_degrees(),
            height_m: fix.height_m,
            altitude_msl_m: fix.altitude_msl_m,
            velocity_north_east_mps: fix.horizontal_velocity_mps,
            velocity_down_mps: fix.down_velocity_mps,
            position_sigma_ned_m: fix.position_sigma_m.map(Vector::to_array),
            velocity_sigma_ned_mps: fix.velocity_sigma_mps.map(Vector::to_array),
            satellites: fix.satellites,
            position_dilution: fix.dilution.position,
            horizontal_dilution: fix.dilution.horizontal,
        }
    }
}

/// Every number of a [`Solution`], with enough digits to read back the same number, and derived values for plots.
#[derive(Debug, Serialize, Deserialize)]
pub struct SolutionMessage {
    pub time_ns: i64,
    pub latitude_rad: f64,
    pub longitude_rad: f64,
    pub height_m: f64,
    pub velocity_ned_mps: [f64; 3],
    pub body_to_ned_xyzw: [f64; 4],
    pub angular_rate_body_radps: [f64; 3],
    #[serde(default)]
    pub heading_revision_rad: f64,
    pub position_sigma_ned_m: [f64; 3],
    pub velocity_sigma_ned_mps: [f64; 3],
    pub attitude_sigma_rad: [f64; 3],
    pub gyro_bias_body_radps: [f64; 3],
    pub accel_bias_body_mps2: [f64; 3],
    pub gyro_bias_sigma_body_radps: [f64; 3],
    pub accel_bias_sigma_body_mps2: [f64; 3],
    pub roll_pitch_yaw_deg: [f64; 3],
    pub velocity_body_mps: [f64; 3],
}

impl From<&Solution> for SolutionMessage {
    fn from(solution: &Solution) -> Self {
        Self {
            time_ns: solution.time.nanoseconds(),
            latitude_rad: solution.position.latitude_rad,
            longitude_rad: solution.position.longitude_rad,
            height_m: solution.position.height_m,
            velocity_ned_mps: solution.velocity_mps.to_array(),
            body_to_ned_xyzw: solution.body_to_ned.quaternion().to_array(),
            angular_rate_body_radps: solution.angular_rate_radps.to_array(),
            heading_revision_rad: solution.heading_revision_rad,
            position_sigma_ned_m: solution.position_sigma_m.to_array(),
            velocity_sigma_ned_mps: solution.velocity_sigma_mps.to_array(),
            attitude_sigma_rad: solution.attitude_sigma_rad,
            gyro_bias_body_radps: solution.gyro_bias_radps.to_array(),
            accel_bias_body_mps2: solution.accel_bias_mps2.to_array(),
            gyro_bias_sigma_body_radps: solution.gyro_bias_sigma_radps.to_array(),
            accel_bias_sigma_body_mps2: solution.accel_bias_sigma_mps2.to_array(),
            roll_pitch_yaw_deg: solution.body_to_ned.euler().to_degrees(),
            velocity_body_mps: solution.velocity_body_mps().to_array(),
        }
    }
}

impl From<SolutionMessage> for Solution {
    fn from(message: SolutionMessage) -> Self {
        Self {
            time: Time::from_nanoseconds(message.time_ns),
            position: Geodetic {
                latitude_rad: message.latitude_rad,
                longitude_rad: message.longitude_rad,
                height_m: message.height_m,
            },
            velocity_mps: message.velocity_ned_mps.into(),
            body_to_ned: Rotation::claim(DQuat::from_array(message.body_to_ned_xyzw)),
            angular_rate_radps: message.angular_rate_body_radps.into(),
            heading_revision_rad: message.heading_revision_rad,
            position_sigma_m: message.position_sigma_ned_m.into(),
            velocity_sigma_mps: message.velocity_sigma_ned_mps.into(),
            attitude_sigma_rad: message.attitude_sigma_rad,
            gyro_bias_radps: message.gyro_bias_body_radps.into(),
            accel_bias_mps2: message.accel_bias_body_mps2.into(),
            gyro_bias_sigma_radps: message.gyro_bias_sigma_body_radps.into(),
            accel_bias_sigma_mps2: message.accel_bias_sigma_body_mps2.into(),
        }
    }
}

/// Foxglove's time: UTC since the start of 1970.
#[derive(Debug, Serialize)]
pub struct Timestamp {
    pub sec: u32,
    pub nsec: u32,
}

impl Timestamp {
    pub fn new(unix_ns: u64) -> Self {
        let sec = u32::try_from(unix_ns / 1_000_000_000).unwrap_or(u32::MAX);
        Self { sec, nsec: (unix_ns % 1_000_000_000) as u32 }
    }
}

/// Foxglove's `LocationFix`; its covariance is east, north, up, row by row, m².
#[derive(Debug, Serialize)]
pub struct LocationMessage {
    pub timestamp: Timestamp,
    pub frame_id: &'static str,
    pub latitude: f64,
    pub longitude: f64,
    pub altitude: f64,
    pub position_covariance: [f64; 9],
    /// Type of the covariance: 0 if unknown, 2 if only the diagonal is known.
    pub position_covariance_type: u8,
}

impl LocationMessage {
    pub fn new(
        unix_ns: u64,
        frame_id: &'static str,
        position: &Geodetic,
        sigma_ned_m: Option<[f64; 3]>,
    ) -> Self {
        let [north, east, down] = sigma_ned_m.unwrap_or_default().map(|sigma| sigma * sigma);
        Self {
            timestamp: Timestamp::new(unix_ns),
            frame_id,
            latitude: position.latitude_deg(),
            longitude: position.longitude_deg(),
            altitude: position.height_m,
            position_covariance: [east, 0.0, 0.0, 0.0, north, 0.0, 0.0, 0.0, down],
            position_covariance_type: if sigma_ned_m.is_some() { 2 } else { 0 },
        }
    }
}

/// Innovations of one measurement, by channel name.
#[derive(Debug, Serialize)]
pub struct InnovationsMessage {
    pub time_ns: i64,
    #[serde(flatten)]
    pub axes: BTreeMap<&'static str, AxisMessage>,
}

#[derive(Debug, Serialize)]
pub struct AxisMessage {
    pub innovation: f64,
    pub sigma: f64,
    pub verdict: &'static str,
}

impl InnovationsMessage {
    pub fn new<'a>(innovations: impl Iterator<Item = &'a Innovation>) -> Self {
        let mut message = Self { time_ns: 0, axes: BTreeMap::new() };
        for axis in innovations {
            message.time_ns = axis.time.nanoseconds();
            let verdict = match axis.verdict {
                Verdict::Accepted => "accepted",
                Verdict::Rejected => "rejected",
                Verdict::Reset => "reopened",
            };
            let entry = AxisMessage { innovation: axis.innovation, sigma: axis.sigma, verdict };
            message.axes.insert(axis.channel.name(), entry);
        }
        message
    }
}

#[derive(Debug, Serialize)]
pub struct ServoMessage {
    pub captured_ms: [f32; 5],
    pub commanded_ms: [f32; 5],
}

#[derive(Debug, Serialize, Deserialize)]
pub struct ControlsMessage {
    pub lateral: f64,
    pub longitudinal: f64,
    pub collective: f64,
    pub pedal: f64,
}

#[derive(Debug, Serialize, Deserialize)]
pub struct CycleMessage {
    pub time_ns: i64,
    pub has_sample: bool,
    pub servos_good: bool,
    pub late_cycles: u8,
    pub work_s: Option<f64>,
    #[serde(default)]
    pub turnaround_s: Option<f64>,
    pub mode: String,
    pub switch_on: bool,
    pub failed_checks: u16,
    pub pilot: Option<[f64; 4]>,
    pub sticks: Option<[f64; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub injected: Option<[f64; 4]>,
    pub asked_velocity_ned_mps: [f64; 3],
    pub asked_heading_rad: f64,
}

impl CycleMessage {
    pub fn new(time: Time, cycle: &Cycle) -> Self {
        Self {
            time_ns: time.nanoseconds(),
            has_sample: cycle.has_sample,
            servos_good: cycle.servos_good,
            late_cycles: cycle.late_cycles,
            work_s: cycle.work_s,
            turnaround_s: cycle.turnaround_s,
            mode: cycle.mode.name().into(),
            switch_on: cycle.switch_on,
            failed_checks: cycle.failed_checks,
            pilot: cycle.pilot.map(Sticks::to_array),
            sticks: cycle.sticks.map(Sticks::to_array),
            injected: (cycle.injected != Sticks::NEUTRAL).then(|| cycle.injected.to_array()),
            asked_velocity_ned_mps: cycle.asked_velocity_mps.to_array(),
            asked_heading_rad: cycle.asked_heading_rad,
        }
    }

    /// The cycle and its time; `None` if its mode is unknown.
    pub fn cycle(self) -> Option<(Time, Cycle)> {
        let [north, east, down] = self.asked_velocity_ned_mps;
        let cycle = Cycle {
            has_sample: self.has_sample,
            servos_good: self.servos_good,
            late_cycles: self.late_cycles,
            work_s: self.work_s,
            turnaround_s: self.turnaround_s,
            mode: Mode::ALL.into_iter().find(|mode| mode.name() == self.mode)?,
            switch_on: self.switch_on,
            failed_checks: self.failed_checks,
            pilot: self.pilot.map(Sticks::from_array),
            sticks: self.sticks.map(Sticks::from_array),
            injected: self.injected.map_or(Sticks::NEUTRAL, Sticks::from_array),
            asked_velocity_mps: Vector::new(north, east, down),
            asked_heading_rad: self.asked_heading_rad,
        };
        Some((Time::from_nanoseconds(self.time_ns), cycle))
    }
}

#[derive(Debug, Serialize, Deserialize)]
pub struct LostMessage {
    pub raw: u32,
    pub decoded: u32,
}

/// Foxglove's `Log`.
#[derive(Debug, Serialize)]
pub struct LogMessage<'a> {
    pub timestamp: Timestamp,
    pub level: u8,
    pub message: &'a str,
    pub name: &'a str,
    pub file: &'static str,
    pub line: u32,
    /// Sensor or part of the vehicle, in addition to the fields of `foxglove.Log`.
    pub part: &'static str,
}

/// The fields of a [`LogMessage`] that are read.
#[derive(Debug, Deserialize)]
pub struct ReadLogMessage {
    pub level: u8,
    pub message: String,
    pub name: String,
    /// Sensor or function at fault; empty in older records, which do not contain it.
    #[serde(default)]
    pub part: String,
}
