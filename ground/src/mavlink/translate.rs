//! MAVLink messages as channel values.

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::telemetry::StatusFlags;
use hovernav_fly::FIRST_CUSTOM_MODE;
use mavlink::dialects::common::{
    ESTIMATOR_STATUS_DATA, EstimatorStatusFlags, GLOBAL_POSITION_INT_DATA, GPS_RAW_INT_DATA,
    HEARTBEAT_DATA, HIGHRES_IMU_DATA, HighresImuUpdatedFlags, MavAutopilot, MavMessage,
    MavSeverity, MavSysStatusSensor, SERVO_OUTPUT_RAW_DATA, STATUSTEXT_DATA, SYS_STATUS_DATA,
};

use super::clocks::Clocks;
use super::ekf_status::EkfStatus;
use crate::channel::Id::{self, *};
use crate::frames::Values;
use crate::store::TextLevel;

/// Characters of one STATUSTEXT; a longer text is split.
const TEXT: usize = 50;
/// Length, bytes, after which further pieces of a text are dropped.
const LONGEST_TEXT: usize = 512;
/// Gate in one-sigmas; test ratios are relative to the gate. Vehicles with another setting are not recognised.
const GATE: f64 = 5.0;

/// A decoded item.
pub enum Said {
    /// Values, with the time since boot, s, if the message contains it.
    Values(Option<f64>, Values),
    /// A text.
    Text(TextLevel, String),
}

/// Decodes the messages of one vehicle. Some messages depend on earlier ones.
#[derive(Default)]
pub struct Translator {
    autopilot: Option<MavAutopilot>,
    clocks: Clocks,
    attitude: Option<EulerAngles>,
    /// Whether LOCAL_POSITION_NED arrives, whose velocity is finer than in GLOBAL_POSITION_INT.
    receives_velocity: bool,
    /// An incomplete text: its number, level and first pieces.
    text: Option<(u16, TextLevel, Vec<u8>)>,
}

fn boot(milliseconds: u32) -> Option<f64> {
    Some(1e-3 * f64::from(milliseconds))
}

fn finite(value: f32) -> Option<f64> {
    Some(f64::from(value)).filter(|value| value.is_finite())
}

/// A number; its largest value means unknown.
fn known(value: u16) -> Option<f64> {
    (value != u16::MAX).then(|| f64::from(value))
}

fn hundredths(value: u16) -> Option<f64> {
    known(value).map(|value| 0.01 * value)
}

fn width_ms(us: u16) -> Option<f64> {
    Some(1e-3 * f64::from(us)).filter(|_| us != 0 && us != u16::MAX)
}

/// Specific force in mg and field in mgauss, as in SCALED_IMU.
fn milli(ids: [Id; 3], values: [i16; 3]) -> impl Iterator<Item = (Id, Option<f64>)> {
    ids.into_iter().zip(values.map(|value| Some(1e-3 * f64::from(value))))
}

impl Translator {
    /// Decodes a message of the vehicle; `payload` contains fields that the types of the common set omit.
    pub fn said(&mut self, message: &MavMessage, payload: &[u8], said: &mut impl FnMut(Said)) {
        if let MavMessage::STATUSTEXT(m) = message {
            return self.text(m, payload, said);
        }
        if matches!(message, MavMessage::HEARTBEAT(_)) {
            self.end_text(said);
        }
        if let MavMessage::SYSTEM_TIME(m) = message {
            self.clocks.observe(1000 * u64::from(m.time_boot_ms));
            self.clocks.observe(m.time_unix_usec);
        }
        if let Some((boot_s, values)) = self.values(message) {
            self.clocks.observe(boot_s.map_or(0, |boot_s| (1e6 * boot_s) as u64));
            said(Said::Values(boot_s, values));
        }
    }

    fn values(&mut self, message: &MavMessage) -> Option<(Option<f64>, Values)> {
        Some(match message {
            MavMessage::HEARTBEAT(m) => (None, self.heartbeat(m)),
            MavMessage::ATTITUDE(m) => {
                let [roll_rad, pitch_rad, yaw_rad] = [m.roll, m.pitch, m.yaw].map(f64::from);
                self.attitude = Some(EulerAngles { roll_rad, pitch_rad, yaw_rad });
                let degrees = |value: f32| finite(value).map(f64::to_degrees);
                let values = vec![
                    (Roll, degrees(m.roll)),
                    (Pitch, degrees(m.pitch)),
                    (Yaw, degrees(m.yaw)),
                    (RateP, degrees(m.rollspeed)),
                    (RateQ, degrees(m.pitchspeed)),
                    (RateR, degrees(m.yawspeed)),
                ];
                (boot(m.time_boot_ms), values)
            }
            MavMessage::HIGHRES_IMU(m) => {
                self.clocks.observe(m.time_usec);
                (None, highres(m))
            }
            MavMessage::SCALED_IMU(m) => {
                let mut values: Values =
                    milli([AccelX, AccelY, AccelZ], [m.xacc, m.yacc, m.zacc]).collect();
                values.extend(milli([MagX, MagY, MagZ], [m.xmag, m.ymag, m.zmag]));
                (boot(m.time_boot_ms), values)
            }
            // The units of RAW_IMU depend on the vehicle. ArduPilot uses those of SCALED_IMU.
            MavMessage::RAW_IMU(m)
                if self.autopilot == Some(MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA) =>
            {
                let mut values: Values =
                    milli([AccelX, AccelY, AccelZ], [m.xacc, m.yacc, m.zacc]).collect();
                values.extend(milli([MagX, MagY, MagZ], [m.xmag, m.ymag, m.zmag]));
                (None, values)
            }
            MavMessage::LOCAL_POSITION_NED(m) => {
                self.receives_velocity = true;
                (boot(m.time_boot_ms), self.velocity([m.vx, m.vy, m.vz].map(f64::from)))
            }
            MavMessage::GLOBAL_POSITION_INT(m) => (boot(m.time_boot_ms), self.position(m)),
            MavMessage::GPS_RAW_INT(m) => (None, gps(m, self.clocks.since_s(m.time_usec))),
            MavMessage::SERVO_OUTPUT_RAW(m) => (None, self.servos(m)?),
            MavMessage::RC_CHANNELS(m) => {
                let pulses = [
                    m.chan1_raw,
                    m.chan2_raw,
                    m.chan3_raw,
                    m.chan4_raw,
                    m.chan5_raw,
                    m.chan6_raw,
                    m.chan7_raw,
                    m.chan8_raw,
                ];
                let ids = [Radio1, Radio2, Radio3, Radio4, Radio5, Radio6, Radio7, Radio8];
                (boot(m.time_boot_ms), ids.into_iter().zip(pulses.map(width_ms)).collect())
            }
            MavMessage::SYS_STATUS(m) => (None, Self::system(m)),
            MavMessage::ESTIMATOR_STATUS(m) => (None, Self::estimator(m)),
            _ => return None,
        })
    }

    fn heartbeat(&mut self, m: &HEARTBEAT_DATA) -> Values {
        self.autopilot = Some(m.autopilot);
        let mut values = vec![
            (BaseMode, Some(f64::from(m.base_mode.bits()))),
            (Autopilot, Some(f64::from(m.autopilot as u8))),
            (VehicleKind, Some(f64::from(m.mavtype as u8))),
            (CustomMode, Some(f64::from(m.custom_mode))),
        ];
        if m.autopilot == MavAutopilot::MAV_AUTOPILOT_GENERIC {
            // The vehicle runs hovernav: the mode is that of `docs/telemetry.md`.
            let mode = m.custom_mode.checked_sub(FIRST_CUSTOM_MODE).map(f64::from);
            values.push((SystemMode, mode));
        }
        values
    }

    fn velocity(&self, ned_mps: [f64; 3]) -> Values {
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let [north, east, down] = ned_mps;
        let body = self.attitude.map(|angles| {
            (Rotation::from_euler(angles).inverse() * Vector::from(ned_mps)).to_array()
        });
        vec![
            (VelE, finite(east)),
            (VelN, finite(north)),
            (VelU, finite(-down)),
            (BodyU, body.map(|body| body[0])),
            (BodyV, body.map(|body| body[1])),
            (BodyW, body.map(|body| body[2])),
        ]
    }

    fn position(&self, m: &GLOBAL_POSITION_INT_DATA) -> Values {
        // ArduPilot sends zeros until it has a position.
        let is_known = (m.lat, m.lon) != (0, 0);
        let place = |value: i32, scale: f64| is_known.then(|| scale * f64::from(value));
        let mut values = vec![
            (Latitude, place(m.lat, 1e-7)),
            (Longitude, place(m.lon, 1e-7)),
            (Altitude, place(m.alt, 1e-3)),
            (AboveHome, place(m.relative_alt, 1e-3)),
        ];
        if !self.receives_velocity && is_known {
            values.extend(self.velocity([m.vx, m.vy, m.vz].map(|value| 0.01 * f64::from(value))));
        }
        values
    }

    /// Channel values of the outputs; `None` before the first heartbeat, because the outputs depend on the type of
    /// autopilot.
    fn servos(&self, m: &SERVO_OUTPUT_RAW_DATA) -> Option<Values> {
        let pulses = [
            m.servo1_raw,
            m.servo2_raw,
            m.servo3_raw,
            m.servo4_raw,
            m.servo5_raw,
            m.servo6_raw,
            m.servo7_raw,
            m.servo8_raw,
        ];
        let ids = match (self.autopilot?, m.port) {
            (MavAutopilot::MAV_AUTOPILOT_GENERIC, _) => {
                &[ServoThrottle, ServoCollective, ServoLongitudinal, ServoLateral, ServoPedal][..]
            }
            (_, 0) => &[Output1, Output2, Output3, Output4, Output5, Output6, Output7, Output8],
            _ => return None,
        };
        Some(ids.iter().copied().zip(pulses.map(width_ms)).collect())
    }

    fn system(m: &SYS_STATUS_DATA) -> Values {
        use MavSysStatusSensor as S;
        let watched = m.onboard_control_sensors_present & m.onboard_control_sensors_enabled;
        let has = |sensor: S| watched.contains(sensor);
        let works = |sensor: S| m.onboard_control_sensors_health.contains(sensor);
        let unit = S::MAV_SYS_STATUS_SENSOR_3D_GYRO | S::MAV_SYS_STATUS_SENSOR_3D_ACCEL;
        let (gps, radio) = (S::MAV_SYS_STATUS_SENSOR_GPS, S::MAV_SYS_STATUS_SENSOR_RC_RECEIVER);
        let (motors, log) = (S::MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS, S::MAV_SYS_STATUS_LOGGING);
        let flags = |is: &dyn Fn(S) -> bool| {
            let [imu, gps, pilot_signal, servos, recorder] =
                [unit, gps, radio, motors, log].map(is);
            let flags =
                StatusFlags { imu, gps, pilot_signal, servos, recorder, ..Default::default() };
            Some(f64::from(flags.bits()))
        };
        // A disabled check reads as failed or passed, depending on the vehicle.
        let checks = S::MAV_SYS_STATUS_PREARM_CHECK;
        let passes = has(checks).then(|| f64::from(u8::from(works(checks))));
        let mut values = vec![(Status, flags(&works)), (StatusKnown, flags(&has))];
        let percent = Some(f64::from(m.battery_remaining)).filter(|percent| *percent >= 0.0);
        values.push((Battery, known(m.voltage_battery).map(|millivolts| 1e-3 * millivolts)));
        values.push((BatteryLeft, percent));
        values.push((ArmingChecks, passes));
        values
    }

    fn estimator(m: &ESTIMATOR_STATUS_DATA) -> Values {
        let mut values = Self::estimate(m.flags);
        let sigmas = |ratio| finite(ratio).map(|ratio| GATE * ratio);
        values.extend([
            (SigmaHorizontal, finite(m.pos_horiz_accuracy)),
            (SigmaVertical, finite(m.pos_vert_accuracy)),
            (InnovationPosition, sigmas(m.pos_horiz_ratio)),
            (InnovationVelocity, sigmas(m.vel_ratio)),
            (InnovationHeading, sigmas(m.mag_ratio)),
        ]);
        values
    }

    /// Decodes EKF_STATUS_REPORT of ArduPilot.
    pub fn ekf_status(payload: &[u8]) -> Said {
        let told = EkfStatus::of(payload);
        let mut values = Self::estimate(EstimatorStatusFlags::from_bits_truncate(told.flags));
        let sigmas = |ratio| finite(ratio).map(|ratio| GATE * ratio);
        values.extend([
            (InnovationPosition, sigmas(told.position)),
            (InnovationVelocity, sigmas(told.velocity)),
            (InnovationHeading, sigmas(told.compass)),
        ]);
        Said::Values(None, values)
    }

    fn estimate(flags: EstimatorStatusFlags) -> Values {
        use EstimatorStatusFlags as F;
        let attitude = flags.contains(F::ESTIMATOR_ATTITUDE);
        let velocity = flags.contains(F::ESTIMATOR_VELOCITY_HORIZ);
        let position = flags.contains(F::ESTIMATOR_POS_HORIZ_ABS);
        let bits = |attitude, velocity, position| {
            let flags = StatusFlags { attitude, velocity, position, ..Default::default() };
            Some(f64::from(flags.bits()))
        };
        vec![
            (EstimateStatus, bits(attitude, velocity, position)),
            (EstimateStatusKnown, bits(true, true, true)),
        ]
    }

    fn text(&mut self, m: &STATUSTEXT_DATA, payload: &[u8], said: &mut impl FnMut(Said)) {
        let level = match m.severity {
            MavSeverity::MAV_SEVERITY_EMERGENCY
            | MavSeverity::MAV_SEVERITY_ALERT
            | MavSeverity::MAV_SEVERITY_CRITICAL
            | MavSeverity::MAV_SEVERITY_ERROR => TextLevel::Error,
            MavSeverity::MAV_SEVERITY_WARNING => TextLevel::Warning,
            _ => TextLevel::Info,
        };
        let bytes: Vec<u8> = m.text.iter().copied().take_while(|byte| *byte != 0).collect();
        // In version 2, the number of a split text follows severity and characters.
        let byte = |place: usize| payload.get(place).copied().unwrap_or(0);
        let number = u16::from_le_bytes([byte(1 + TEXT), byte(2 + TEXT)]);
        if self.text.as_ref().is_some_and(|(before, ..)| *before != number) {
            self.end_text(said);
        }
        if number == 0 {
            return said(Said::Text(level, String::from_utf8_lossy(&bytes).into_owned()));
        }
        let (.., text) = self.text.get_or_insert_with(|| (number, level, Vec::new()));
        if text.len() < LONGEST_TEXT {
            // A character may be cut between two pieces.
            text.extend_from_slice(&bytes);
        }
        if bytes.len() < TEXT {
            self.end_text(said);
        }
    }

    fn end_text(&mut self, said: &mut impl FnMut(Said)) {
        if let Some((_, level, text)) = self.text.take() {
            said(Said::Text(level, String::from_utf8_lossy(&text).into_owned()));
        }
    }
}

fn highres(m: &HIGHRES_IMU_DATA) -> Values {
    use HighresImuUpdatedFlags as F;
    let has = |flag, value: f32| finite(value).filter(|_| m.fields_updated.contains(flag));
    let g = |flag, value| has(flag, value).map(|value| value / STANDARD_GRAVITY_MPS2);
    vec![
        (AccelX, g(F::HIGHRES_IMU_UPDATED_XACC, m.xacc)),
        (AccelY, g(F::HIGHRES_IMU_UPDATED_YACC, m.yacc)),
        (AccelZ, g(F::HIGHRES_IMU_UPDATED_ZACC, m.zacc)),
        (MagX, has(F::HIGHRES_IMU_UPDATED_XMAG, m.xmag)),
        (MagY, has(F::HIGHRES_IMU_UPDATED_YMAG, m.ymag)),
        (MagZ, has(F::HIGHRES_IMU_UPDATED_ZMAG, m.zmag)),
        (Temperature, has(F::HIGHRES_IMU_UPDATED_TEMPERATURE, m.temperature)),
    ]
}

/// The values of a GPS fix with this age, s.
fn gps(m: &GPS_RAW_INT_DATA, age_s: Option<f64>) -> Values {
    let has_fix = m.fix_type as u8 >= 2;
    let place = |value: i32, scale: f64| has_fix.then(|| scale * f64::from(value));
    let course = hundredths(m.cog).map(f64::to_radians).zip(hundredths(m.vel));
    let course = course.filter(|_| has_fix);
    let satellites = Some(m.satellites_visible).filter(|count| *count != u8::MAX);
    vec![
        (GpsFix, Some(f64::from(m.fix_type as u8))),
        (GpsAge, age_s.filter(|_| has_fix)),
        (GpsLatitude, place(m.lat, 1e-7)),
        (GpsLongitude, place(m.lon, 1e-7)),
        (GpsAltitude, place(m.alt, 1e-3)),
        (GpsVelE, course.map(|(course, speed)| speed * course.sin())),
        (GpsVelN, course.map(|(course, speed)| speed * course.cos())),
        (Hdop, hundredths(m.eph)),
        (Vdop, hundredths(m.epv)),
        (Satellites, satellites.map(f64::from)),
    ]
}
