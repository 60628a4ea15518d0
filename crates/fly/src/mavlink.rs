//! Telemetry snapshots as MAVLink 2 messages, for other ground stations.
//!
//! Source: MAVLink, *common message set*, which defines the units and the values for unknown data.

mod answers;
pub mod frame;
mod mode;
mod pacing;
mod rates;
mod requests;
mod states;

use mavlink::dialects::common;
use mavlink::{MavlinkVersion, MessageData, calculate_crc};

use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav::telemetry::Snapshot;
use hovernav::time::Time;
use hovernav_record::{Level, MavlinkConfig};
pub use mode::FIRST_CUSTOM_MODE;
use mode::{current_mode, extended_state, heartbeat};
use pacing::{Recent, Schedule};
use requests::Requests;

/// Length of the text in one STATUSTEXT, bytes.
const TEXT: usize = 50;
/// Rate, Hz, of the messages with states and values for displays, which have no setting.
const STATES_HZ: f64 = 1.0;
/// Rate, Hz, of the home position, which has no setting.
const HOME_HZ: f64 = 0.2;

/// Encodes snapshots as numbered messages, each type at its own rate, and answers the requests of ground stations.
///
/// Times since boot are relative to `boot`. Messages with a field for UTC contain it once [`Mavlink::set_utc`] has
/// set it. Local positions are relative to the first known position.
///
/// ```
/// use hovernav_fly::Mavlink;
/// use hovernav_record::MavlinkConfig;
/// use hovernav::telemetry::Snapshot;
/// use hovernav::time::Time;
///
/// let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
/// let mut bytes = Vec::new();
/// mavlink.encode(&Snapshot::at(Time::ZERO), &mut bytes);
/// assert_eq!(bytes[0], 0xFD);                 // MAVLink 2
/// ```
#[derive(Clone, Debug)]
pub struct Mavlink {
    config: MavlinkConfig,
    boot: Time,
    /// UTC since 1970 minus the flight clock, µs.
    utc_offset_us: Option<i64>,
    origin: Option<Geodetic>,
    /// Height of the geoid above the ellipsoid by the receiver's last report, m; 0 before.
    geoid_m: f64,
    sequence: u8,
    heartbeat: Schedule,
    attitude: Schedule,
    highres_imu: Schedule,
    local_position: Schedule,
    global_position: Schedule,
    gps_raw: Schedule,
    servo_output: Schedule,
    estimator_status: Schedule,
    states: Schedule,
    home: Schedule,
    recent: Recent,
    /// The last snapshot, for messages on request.
    last: Option<Snapshot>,
    requests: Requests,
    /// Number of the last text in several pieces.
    text_id: u16,
}

impl Mavlink {
    /// An encoder for a vehicle that was switched on at `boot`.
    #[must_use]
    pub fn new(config: MavlinkConfig, boot: Time) -> Self {
        let rates = config.rates;
        let schedule = |rate_hz| Schedule::new(rate_hz, boot);
        Self {
            config,
            boot,
            utc_offset_us: None,
            origin: None,
            geoid_m: 0.0,
            sequence: 0,
            heartbeat: schedule(rates.heartbeat_hz),
            attitude: schedule(rates.attitude_hz),
            highres_imu: schedule(rates.highres_imu_hz),
            local_position: schedule(rates.local_position_hz),
            global_position: schedule(rates.global_position_hz),
            gps_raw: schedule(rates.gps_raw_hz),
            servo_output: schedule(rates.servo_output_hz),
            estimator_status: schedule(rates.estimator_status_hz),
            states: schedule(STATES_HZ),
            home: schedule(HOME_HZ),
            recent: Recent::default(),
            last: None,
            requests: Requests::default(),
            text_id: 0,
        }
    }

    /// Sets UTC: `unix_ns`, ns since 1970, at the time `at`.
    pub fn set_utc(&mut self, unix_ns: i64, at: Time) {
        self.utc_offset_us = Some(unix_ns.saturating_sub(at.nanoseconds()) / 1_000);
    }

    /// Appends the messages that are due, at most 650 bytes; call once per snapshot.
    ///
    /// A message without any known value is not sent. In other messages, unknown values are marked as the message
    /// set defines; see `docs/telemetry.md`.
    pub fn encode(&mut self, snapshot: &Snapshot, out: &mut Vec<u8>) {
        let now = snapshot.time;
        let place = snapshot.position.filter(Geodetic::is_navigable);
        self.origin = self.origin.or(place);
        let gps = &snapshot.gps;
        if let Some((height_m, altitude_m)) = gps.height_m.zip(gps.altitude_msl_m) {
            self.geoid_m = height_m - altitude_m;
        }
        self.recent.push(&snapshot.innovations, now);
        self.last = Some(*snapshot);
        if self.heartbeat.is_due(now) {
            self.send(&heartbeat(snapshot), out);
        }
        if self.attitude.is_due(now)
            && let Some(message) = self.attitude_message(snapshot)
        {
            self.send(&message, out);
        }
        if self.highres_imu.is_due(now) {
            self.send(&self.highres_imu_message(snapshot), out);
        }
        if self.local_position.is_due(now)
            && let Some(message) = self.local_position_message(snapshot)
        {
            self.send(&message, out);
        }
        if self.global_position.is_due(now)
            && let Some(message) = self.global_position_message(snapshot)
        {
            self.send(&message, out);
        }
        if self.gps_raw.is_due(now) {
            self.send_gps_raw(snapshot, out);
        }
        if self.servo_output.is_due(now) {
            self.send(&self.servo_output_message(snapshot), out);
        }
        if self.estimator_status.is_due(now) {
            self.send(&self.estimator_status_message(snapshot), out);
        }
        if self.states.is_due(now) {
            self.send(&self.system_status(snapshot), out);
            self.send(&extended_state(), out);
            self.send(&current_mode(snapshot), out);
            self.send(&self.system_time(now), out);
            self.send(&self.hud(snapshot), out);
            self.send(&self.pilot_channels(snapshot), out);
        }
        if self.home.is_due(now)
            && let Some(home) = self.home()
        {
            self.send(&home, out);
        }
    }

    /// Appends `text` as one or more STATUSTEXT messages.
    pub fn encode_text(&mut self, level: Level, text: &str, out: &mut Vec<u8>) {
        let severity = match level {
            Level::Info => common::MavSeverity::MAV_SEVERITY_INFO,
            Level::Warning => common::MavSeverity::MAV_SEVERITY_WARNING,
            Level::Error => common::MavSeverity::MAV_SEVERITY_ERROR,
            Level::Critical => common::MavSeverity::MAV_SEVERITY_CRITICAL,
        };
        let bytes = text.trim().as_bytes();
        let mut id = 0;
        if bytes.len() > TEXT {
            self.text_id = self.text_id.wrapping_add(1).max(1);
            id = self.text_id;
        }
        // A piece that is not full ends a text of several pieces.
        let ends_full = bytes.len() > TEXT && bytes.len().is_multiple_of(TEXT);
        let pieces = bytes.chunks(TEXT).chain(ends_full.then_some(&[][..]));
        for (number, piece) in (0..=u8::MAX).zip(pieces) {
            let mut text = [0; TEXT];
            text[..piece.len()].copy_from_slice(piece);
            let message = common::STATUSTEXT_DATA { severity, text: text.into() };
            let [low, high] = id.to_le_bytes();
            self.send_extended(&message, &[low, high, number], out);
        }
    }

    fn send(&mut self, message: &impl MessageData, out: &mut Vec<u8>) {
        self.send_extended(message, &[], out);
    }

    /// Appends a message with `extension`, the bytes of its extension fields.
    fn send_extended<M: MessageData>(&mut self, message: &M, extension: &[u8], out: &mut Vec<u8>) {
        let mut payload = [0; 255];
        // Version 1 keeps the trailing zeros, which only the last fields may omit.
        let base = message.ser(MavlinkVersion::V1, &mut payload);
        let whole = base + extension.len();
        payload[base..whole].copy_from_slice(extension);
        let is_zero = |byte: &u8| *byte == 0;
        let length = whole - payload[..whole].iter().rev().take_while(|byte| is_zero(byte)).count();
        // The first byte is always sent.
        let payload = &payload[..length.max(1)];
        let MavlinkConfig { system_id, component_id, .. } = self.config;
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        let [low, middle, high, _] = M::ID.to_le_bytes();
        let start = out.len();
        out.push(0xFD);
        out.extend([
            payload.len() as u8,
            0,
            0,
            sequence,
            system_id,
            component_id,
            low,
            middle,
            high,
        ]);
        out.extend_from_slice(payload);
        let checksum = calculate_crc(&out[start + 1..], M::EXTRA_CRC);
        out.extend(checksum.to_le_bytes());
    }

    fn since_boot_us(&self, time: Time) -> i64 {
        time.nanoseconds().saturating_sub(self.boot.nanoseconds()).max(0) / 1_000
    }

    /// Milliseconds since boot; they wrap around after 49.7 days.
    fn boot_ms(&self, time: Time) -> u32 {
        (self.since_boot_us(time) / 1_000) as u32
    }

    /// UTC in microseconds since 1970 where known, else microseconds since boot.
    fn stamp_us(&self, time: Time) -> u64 {
        let us = self.utc_offset_us.map_or_else(
            || self.since_boot_us(time),
            |offset_us| (time.nanoseconds() / 1_000).saturating_add(offset_us).max(0),
        );
        us.cast_unsigned()
    }

    fn attitude_message(&self, snapshot: &Snapshot) -> Option<common::ATTITUDE_DATA> {
        let angles = snapshot.attitude?;
        let [rollspeed, pitchspeed, yawspeed] = singles(snapshot.angular_rate_radps, f32::NAN);
        Some(common::ATTITUDE_DATA {
            time_boot_ms: self.boot_ms(snapshot.time),
            roll: angles.roll_rad as f32,
            pitch: angles.pitch_rad as f32,
            yaw: angles.yaw_rad as f32,
            rollspeed,
            pitchspeed,
            yawspeed,
        })
    }

    fn highres_imu_message(&self, snapshot: &Snapshot) -> common::HIGHRES_IMU_DATA {
        use common::HighresImuUpdatedFlags as Updated;
        let mut fields_updated = Updated::empty();
        let mut mark = |known: bool, flags: Updated| fields_updated.set(flags, known);
        mark(
            snapshot.specific_force_mps2.is_some(),
            Updated::HIGHRES_IMU_UPDATED_XACC
                | Updated::HIGHRES_IMU_UPDATED_YACC
                | Updated::HIGHRES_IMU_UPDATED_ZACC,
        );
        mark(
            snapshot.angular_rate_radps.is_some(),
            Updated::HIGHRES_IMU_UPDATED_XGYRO
                | Updated::HIGHRES_IMU_UPDATED_YGYRO
                | Updated::HIGHRES_IMU_UPDATED_ZGYRO,
        );
        mark(
            snapshot.magnetic_field_gauss.is_some(),
            Updated::HIGHRES_IMU_UPDATED_XMAG
                | Updated::HIGHRES_IMU_UPDATED_YMAG
                | Updated::HIGHRES_IMU_UPDATED_ZMAG,
        );
        mark(snapshot.temperature_degc.is_some(), Updated::HIGHRES_IMU_UPDATED_TEMPERATURE);
        let [xacc, yacc, zacc] = singles(snapshot.specific_force_mps2, 0.0);
        let [xgyro, ygyro, zgyro] = singles(snapshot.angular_rate_radps, 0.0);
        let [xmag, ymag, zmag] = singles(snapshot.magnetic_field_gauss, 0.0);
        common::HIGHRES_IMU_DATA {
            time_usec: self.stamp_us(snapshot.time),
            xacc,
            yacc,
            zacc,
            xgyro,
            ygyro,
            zgyro,
            xmag,
            ymag,
            zmag,
            abs_pressure: 0.0,
            diff_pressure: 0.0,
            pressure_alt: 0.0,
            temperature: snapshot.temperature_degc.unwrap_or(0.0) as f32,
            fields_updated,
        }
    }

    fn local_position_message(
        &self,
        snapshot: &Snapshot,
    ) -> Option<common::LOCAL_POSITION_NED_DATA> {
        let place = snapshot.position.filter(Geodetic::is_navigable)?;
        let offset_m = place.local_ned_m(&self.origin?);
        let [x, y, z] = singles(Some(offset_m), 0.0);
        let [vx, vy, vz] = singles(snapshot.velocity_mps, f32::NAN);
        let time_boot_ms = self.boot_ms(snapshot.time);
        Some(common::LOCAL_POSITION_NED_DATA { time_boot_ms, x, y, z, vx, vy, vz })
    }

    fn global_position_message(
        &self,
        snapshot: &Snapshot,
    ) -> Option<common::GLOBAL_POSITION_INT_DATA> {
        let place = snapshot.position.filter(Geodetic::is_navigable)?;
        let up_m = -place.local_ned_m(&self.origin?).z();
        // The velocity is known whenever the position is.
        let [vx, vy, vz] = snapshot
            .velocity_mps?
            .to_array()
            .map(|component| libm::round(component * 100.0) as i16);
        let heading_deg = snapshot.attitude.map(|angles| angles.yaw_rad.to_degrees());
        let heading_deg =
            heading_deg.map(|heading| if heading < 0.0 { heading + 360.0 } else { heading });
        Some(common::GLOBAL_POSITION_INT_DATA {
            time_boot_ms: self.boot_ms(snapshot.time),
            lat: libm::round(place.latitude_deg() * 1e7) as i32,
            lon: libm::round(place.longitude_deg() * 1e7) as i32,
            alt: libm::round((place.height_m - self.geoid_m) * 1e3) as i32,
            relative_alt: libm::round(up_m * 1e3) as i32,
            vx,
            vy,
            vz,
            hdg: hundredths(heading_deg.map(|heading| heading.min(359.99))),
        })
    }

    /// Appends GPS_RAW_INT with its extension: the ellipsoid's altitude and the accuracies, 0 where unknown.
    fn send_gps_raw(&mut self, snapshot: &Snapshot, out: &mut Vec<u8>) {
        let gps = &snapshot.gps;
        let millimetres = |metres: Option<f64>| libm::round(metres.unwrap_or_default() * 1e3);
        let mut extension = [0; 16];
        let altitude = (millimetres(gps.height_m) as i32).to_le_bytes();
        let accuracies = [gps.horizontal_sigma_m, gps.vertical_sigma_m, gps.velocity_sigma_mps]
            .map(|sigma| (millimetres(sigma) as u32).to_le_bytes());
        let fields = [altitude].into_iter().chain(accuracies);
        extension
            .chunks_exact_mut(4)
            .zip(fields)
            .for_each(|(to, field)| to.copy_from_slice(&field));
        self.send_extended(&self.gps_raw_message(snapshot), &extension, out);
    }

    fn gps_raw_message(&self, snapshot: &Snapshot) -> common::GPS_RAW_INT_DATA {
        use common::GpsFixType as Kind;
        use hovernav::telemetry::FixKind;
        let gps = &snapshot.gps;
        let fix_type = match gps.fix {
            FixKind::NoReceiver => Kind::GPS_FIX_TYPE_NO_GPS,
            FixKind::NoFix => Kind::GPS_FIX_TYPE_NO_FIX,
            FixKind::TwoD => Kind::GPS_FIX_TYPE_2D_FIX,
            FixKind::ThreeD => Kind::GPS_FIX_TYPE_3D_FIX,
            FixKind::Differential => Kind::GPS_FIX_TYPE_DGPS,
            FixKind::RtkFloat => Kind::GPS_FIX_TYPE_RTK_FLOAT,
            FixKind::RtkFixed => Kind::GPS_FIX_TYPE_RTK_FIXED,
        };
        let [latitude_deg, longitude_deg] = gps.latitude_longitude_deg.unwrap_or_default();
        let altitude_m = gps.altitude_msl_m.or(gps.height_m).unwrap_or_default();
        let speed_mps = gps.horizontal_velocity_mps.map(|[north, east]| libm::hypot(north, east));
        // The course of a vehicle at rest is noise.
        let course_deg = gps
            .horizontal_velocity_mps
            .filter(|[north, east]| libm::hypot(*north, *east) > 0.1)
            .map(|[north, east]| libm::atan2(east, north).to_degrees())
            .map(|course| if course < 0.0 { course + 360.0 } else { course });
        common::GPS_RAW_INT_DATA {
            time_usec: self.stamp_us(snapshot.time + -gps.age_s.unwrap_or_default()),
            lat: libm::round(latitude_deg * 1e7) as i32,
            lon: libm::round(longitude_deg * 1e7) as i32,
            alt: libm::round(altitude_m * 1e3) as i32,
            eph: hundredths(gps.hdop),
            epv: hundredths(gps.vdop),
            vel: hundredths(speed_mps),
            // 36 000 would be a full turn.
            cog: hundredths(course_deg.map(|course| course.min(359.99))),
            fix_type,
            satellites_visible: gps.satellites.unwrap_or(u8::MAX),
        }
    }

    fn servo_output_message(&self, snapshot: &Snapshot) -> common::SERVO_OUTPUT_RAW_DATA {
        let [servo1_raw, servo2_raw, servo3_raw, servo4_raw, servo5_raw] = snapshot
            .commanded_ms
            .map(|width_ms| width_ms.map_or(0, |width_ms| libm::round(width_ms * 1e3) as u16))
            .to_array();
        common::SERVO_OUTPUT_RAW_DATA {
            // Wraps around after 71 minutes: the field has 32 bits.
            time_usec: self.since_boot_us(snapshot.time) as u32,
            servo1_raw,
            servo2_raw,
            servo3_raw,
            servo4_raw,
            servo5_raw,
            servo6_raw: 0,
            servo7_raw: 0,
            servo8_raw: 0,
            port: 0,
        }
    }

    fn estimator_status_message(&self, snapshot: &Snapshot) -> common::ESTIMATOR_STATUS_DATA {
        use common::EstimatorStatusFlags as Flags;
        let status = snapshot.status;
        let mut flags = Flags::empty();
        flags.set(Flags::ESTIMATOR_ATTITUDE, status.attitude);
        flags
            .set(Flags::ESTIMATOR_VELOCITY_HORIZ | Flags::ESTIMATOR_VELOCITY_VERT, status.velocity);
        flags.set(
            Flags::ESTIMATOR_POS_HORIZ_REL
                | Flags::ESTIMATOR_POS_HORIZ_ABS
                | Flags::ESTIMATOR_POS_VERT_ABS,
            status.position,
        );
        let innovations = self.recent.largest();
        let gate = self.config.gate_sigmas;
        let ratio = |normalised: Option<f64>| single(normalised.map(|size| size / gate));
        // Position has a gate per axis but is reported as one ratio, used for both fields.
        let position = ratio(innovations.position);
        common::ESTIMATOR_STATUS_DATA {
            time_usec: self.stamp_us(snapshot.time),
            vel_ratio: ratio(innovations.velocity),
            pos_horiz_ratio: position,
            pos_vert_ratio: position,
            mag_ratio: ratio(innovations.heading),
            hagl_ratio: f32::NAN,
            tas_ratio: f32::NAN,
            pos_horiz_accuracy: single(snapshot.sigmas.horizontal_m),
            pos_vert_accuracy: single(snapshot.sigmas.vertical_m),
            flags,
        }
    }
}

fn singles<F>(vector: Option<Vector<F>>, unknown: f32) -> [f32; 3] {
    vector.map_or([unknown; 3], |vector| vector.to_array().map(|component| component as f32))
}

fn single(value: Option<f64>) -> f32 {
    value.map_or(f32::NAN, |value| value as f32)
}

/// A value in hundredths; `u16::MAX` if unknown, `u16::MAX - 1` if too large.
fn hundredths(value: Option<f64>) -> u16 {
    value
        .filter(|value| !value.is_nan())
        .map_or(u16::MAX, |value| (libm::round(value * 100.0) as u16).min(u16::MAX - 1))
}

#[cfg(test)]
mod tests;
