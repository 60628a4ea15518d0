//! MAVLink, of both versions, as channels: from this project's vehicles, and from any other that speaks the common set.
//!
//! Source: MAVLink, *common message set* and *packet serialization*.

mod frame;

use hovernav::frames::{EulerAngles, Rotation, Vector};
use mavlink::dialects::common::{
    EstimatorStatusFlags, HighresImuUpdatedFlags, MavAutopilot, MavMessage, MavModeFlag,
    MavSeverity,
};
use mavlink::{MavlinkVersion, Message as _};

use crate::channel::Id;
use crate::frames::Values;
use crate::store::TextLevel;
use frame::{Begun, Frame};

/// Standard gravity, m/s²; accelerations of SCALED_IMU are in mG of it.
const G_MPS2: f64 = 9.806_65;

/// What a message says.
pub enum Said {
    /// Values, and the time since boot, s, where the message has it.
    Values(Option<f64>, Values),
    /// A text.
    Text(TextLevel, String),
}

/// What became of the stream.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Whole messages.
    pub messages: u64,
    /// Messages whose checksum does not hold.
    pub damaged: u64,
    /// Messages that the numbers show to be missing.
    pub missing: u64,
}

/// Finds the messages in a stream of bytes. It listens to the first vehicle that it hears.
#[derive(Default)]
pub struct Decoder {
    bytes: Vec<u8>,
    vehicle: Option<(u8, u8)>,
    before: Option<u8>,
    /// The second version was heard: bytes that look like the first are none.
    speaks_second: bool,
    attitude: Option<EulerAngles>,
    /// What became of the stream.
    pub counts: Counts,
}

impl Decoder {
    /// Takes bytes; `said` hears what they say.
    pub fn receive(&mut self, bytes: &[u8], mut said: impl FnMut(Said)) {
        self.bytes.extend_from_slice(bytes);
        // Taken out so that a frame in it can be looked at while the rest of this changes.
        let bytes = std::mem::take(&mut self.bytes);
        let mut from = 0;
        while let Some(start) = self.next_magic(&bytes[from..]) {
            from += start;
            match frame::begun(&bytes[from..]) {
                Begun::Short => break,
                Begun::Frame(frame) => {
                    from += frame.length;
                    self.frame(&frame, &mut said);
                }
                Begun::Damaged => {
                    self.counts.damaged += 1;
                    from += 1;
                }
                Begun::Nothing => from += 1,
            }
        }
        // What cannot begin a message any more is gone; what is left is shorter than one.
        let gone = self.next_magic(&bytes[from..]).map_or(bytes.len(), |keep| from + keep);
        self.bytes = bytes;
        self.bytes.drain(..gone);
    }

    fn next_magic(&self, bytes: &[u8]) -> Option<usize> {
        bytes.iter().position(|byte| frame::is_magic(*byte, !self.speaks_second))
    }

    fn frame(&mut self, frame: &Frame<'_>, said: &mut impl FnMut(Said)) {
        self.speaks_second |= frame.version == MavlinkVersion::V2;
        if *self.vehicle.get_or_insert(frame.sender) != frame.sender {
            return;
        }
        let gap = |before: u8| frame.sequence.wrapping_sub(before).wrapping_sub(1);
        self.counts.missing += u64::from(self.before.map_or(0, gap));
        self.before = Some(frame.sequence);
        self.counts.messages += 1;
        if let Ok(message) = MavMessage::parse(frame.version, frame.id, frame.payload)
            && let Some(what) = self.said(&message)
        {
            said(what);
        }
    }

    fn said(&mut self, message: &MavMessage) -> Option<Said> {
        use Id::*;
        let boot = |milliseconds: u32| Some(1e-3 * f64::from(milliseconds));
        let known = |value: u16| (value != u16::MAX).then(|| f64::from(value));
        let hundredths = |value: u16| known(value).map(|value| 0.01 * value);
        let finite = |value: f32| Some(f64::from(value)).filter(|value| value.is_finite());
        let width = |us: u16| Some(1e-3 * f64::from(us)).filter(|_| us != 0 && us != u16::MAX);
        Some(match message {
            MavMessage::ATTITUDE(m) => {
                let [roll_rad, pitch_rad, yaw_rad] = [m.roll, m.pitch, m.yaw].map(f64::from);
                self.attitude = Some(EulerAngles { roll_rad, pitch_rad, yaw_rad });
                let degrees = |value: f32| finite(value).map(f64::to_degrees);
                Said::Values(
                    boot(m.time_boot_ms),
                    vec![
                        (Roll, degrees(m.roll)),
                        (Pitch, degrees(m.pitch)),
                        (Yaw, degrees(m.yaw)),
                        (RateP, degrees(m.rollspeed)),
                        (RateQ, degrees(m.pitchspeed)),
                        (RateR, degrees(m.yawspeed)),
                    ],
                )
            }
            MavMessage::HIGHRES_IMU(m) => {
                use HighresImuUpdatedFlags as F;
                let has =
                    |flag, value: f32| finite(value).filter(|_| m.fields_updated.contains(flag));
                let g = |flag, value| has(flag, value).map(|value| value / G_MPS2);
                Said::Values(
                    None,
                    vec![
                        (AccelX, g(F::HIGHRES_IMU_UPDATED_XACC, m.xacc)),
                        (AccelY, g(F::HIGHRES_IMU_UPDATED_YACC, m.yacc)),
                        (AccelZ, g(F::HIGHRES_IMU_UPDATED_ZACC, m.zacc)),
                        (MagX, has(F::HIGHRES_IMU_UPDATED_XMAG, m.xmag)),
                        (MagY, has(F::HIGHRES_IMU_UPDATED_YMAG, m.ymag)),
                        (MagZ, has(F::HIGHRES_IMU_UPDATED_ZMAG, m.zmag)),
                        (Temperature, has(F::HIGHRES_IMU_UPDATED_TEMPERATURE, m.temperature)),
                    ],
                )
            }
            MavMessage::SCALED_IMU(m) => Said::Values(
                boot(m.time_boot_ms),
                vec![
                    (AccelX, Some(1e-3 * f64::from(m.xacc))),
                    (AccelY, Some(1e-3 * f64::from(m.yacc))),
                    (AccelZ, Some(1e-3 * f64::from(m.zacc))),
                    (MagX, Some(1e-3 * f64::from(m.xmag))),
                    (MagY, Some(1e-3 * f64::from(m.ymag))),
                    (MagZ, Some(1e-3 * f64::from(m.zmag))),
                ],
            ),
            MavMessage::LOCAL_POSITION_NED(m) => {
                let ned = Vector::new(m.vx.into(), m.vy.into(), m.vz.into());
                let body = self
                    .attitude
                    .map(|angles| (Rotation::from_euler(angles).inverse() * ned).to_array());
                Said::Values(
                    boot(m.time_boot_ms),
                    vec![
                        (VelE, finite(m.vy)),
                        (VelN, finite(m.vx)),
                        (VelU, finite(-m.vz)),
                        (BodyU, body.map(|body| body[0])),
                        (BodyV, body.map(|body| body[1])),
                        (BodyW, body.map(|body| body[2])),
                    ],
                )
            }
            MavMessage::GLOBAL_POSITION_INT(m) => Said::Values(
                boot(m.time_boot_ms),
                vec![
                    (Latitude, Some(1e-7 * f64::from(m.lat))),
                    (Longitude, Some(1e-7 * f64::from(m.lon))),
                    (Height, Some(1e-3 * f64::from(m.alt))),
                ],
            ),
            MavMessage::GPS_RAW_INT(m) => {
                let has_fix = m.fix_type as u8 >= 2;
                let place = |value: i32, scale: f64| has_fix.then(|| scale * f64::from(value));
                let course = hundredths(m.cog).map(f64::to_radians).zip(hundredths(m.vel));
                Said::Values(
                    None,
                    vec![
                        (GpsFix, Some(f64::from(m.fix_type as u8))),
                        (GpsLatitude, place(m.lat, 1e-7)),
                        (GpsLongitude, place(m.lon, 1e-7)),
                        (GpsAltitude, place(m.alt, 1e-3)),
                        (GpsVelE, course.map(|(course, speed)| speed * course.sin())),
                        (GpsVelN, course.map(|(course, speed)| speed * course.cos())),
                        (Hdop, hundredths(m.eph)),
                        (Vdop, hundredths(m.epv)),
                        (
                            Satellites,
                            Some(m.satellites_visible).filter(|n| *n != u8::MAX).map(f64::from),
                        ),
                    ],
                )
            }
            MavMessage::SERVO_OUTPUT_RAW(m) => Said::Values(
                None,
                vec![
                    (ServoThrottle, width(m.servo1_raw)),
                    (ServoCollective, width(m.servo2_raw)),
                    (ServoLongitudinal, width(m.servo3_raw)),
                    (ServoLateral, width(m.servo4_raw)),
                    (ServoPedal, width(m.servo5_raw)),
                ],
            ),
            MavMessage::ESTIMATOR_STATUS(m) => {
                use EstimatorStatusFlags as F;
                // Ratios are to the gate; five one-sigmas unless the vehicle is set otherwise.
                let sigmas = |ratio| finite(ratio).map(|ratio| 5.0 * ratio);
                let works = |flag, bit: u16| u16::from(m.flags.contains(flag)) << bit;
                let status = works(F::ESTIMATOR_ATTITUDE, 2)
                    | works(F::ESTIMATOR_VELOCITY_HORIZ, 4)
                    | works(F::ESTIMATOR_POS_HORIZ_ABS, 5);
                Said::Values(
                    None,
                    vec![
                        (SigmaHorizontal, finite(m.pos_horiz_accuracy)),
                        (SigmaVertical, finite(m.pos_vert_accuracy)),
                        (InnovationPosition, sigmas(m.pos_horiz_ratio)),
                        (InnovationVelocity, sigmas(m.vel_ratio)),
                        (InnovationHeading, sigmas(m.mag_ratio)),
                        (Status, Some(f64::from(status))),
                    ],
                )
            }
            MavMessage::HEARTBEAT(m) => {
                let flies = m.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_AUTO_ENABLED);
                let mode = match m.autopilot {
                    // This project's own: the mode of `docs/telemetry.md`.
                    MavAutopilot::MAV_AUTOPILOT_GENERIC => f64::from(m.custom_mode),
                    _ if flies => 4.0,
                    _ => 3.0,
                };
                Said::Values(None, vec![(SystemMode, Some(mode))])
            }
            MavMessage::STATUSTEXT(m) => {
                let level = match m.severity {
                    MavSeverity::MAV_SEVERITY_EMERGENCY
                    | MavSeverity::MAV_SEVERITY_ALERT
                    | MavSeverity::MAV_SEVERITY_CRITICAL
                    | MavSeverity::MAV_SEVERITY_ERROR => TextLevel::Error,
                    MavSeverity::MAV_SEVERITY_WARNING => TextLevel::Warning,
                    _ => TextLevel::Info,
                };
                let bytes: Vec<u8> = m.text.iter().copied().take_while(|byte| *byte != 0).collect();
                Said::Text(level, String::from_utf8_lossy(&bytes).into_owned())
            }
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mavlink::dialects::common::{ATTITUDE_DATA, STATUSTEXT_DATA};
    use mavlink::{MavHeader, write_v1_msg, write_v2_msg};

    fn attitude(sequence: u8, roll: f32) -> (MavHeader, MavMessage) {
        let header = MavHeader { sequence, system_id: 1, component_id: 1 };
        (header, MavMessage::ATTITUDE(ATTITUDE_DATA { roll, ..ATTITUDE_DATA::default() }))
    }

    /// What a stream says, handed over in pieces of three bytes, and what became of it.
    fn heard(stream: &[u8]) -> (Vec<f64>, Counts) {
        let mut decoder = Decoder::default();
        let mut rolls = Vec::new();
        for piece in stream.chunks(3) {
            decoder.receive(piece, |said| {
                if let Said::Values(_, values) = said {
                    let roll = values.iter().find(|(id, _)| *id == Id::Roll);
                    rolls.extend(roll.and_then(|(_, value)| *value));
                }
            });
        }
        (rolls, decoder.counts)
    }

    #[test]
    fn an_old_autopilot_that_speaks_the_first_version_is_heard() {
        let mut stream = vec![0xFE, 0x00, 0xFD, 0x41];
        for sequence in 0..20 {
            let (header, message) = attitude(sequence, 0.5);
            write_v1_msg(&mut stream, header, &message).unwrap();
        }
        let text = MavMessage::STATUSTEXT(STATUSTEXT_DATA::default());
        write_v1_msg(&mut stream, attitude(20, 0.0).0, &text).unwrap();
        let (rolls, counts) = heard(&stream);
        assert_eq!((rolls.len(), counts.messages, counts.missing), (20, 21, 0));
        assert!(rolls.iter().all(|roll| (roll - 0.5f64.to_degrees()).abs() < 1e-4));
    }

    #[test]
    fn one_that_goes_over_to_the_second_version_is_heard_on() {
        let mut stream = Vec::new();
        for sequence in 0..20 {
            let (header, message) = attitude(sequence, 0.1);
            match sequence {
                0..10 => write_v1_msg(&mut stream, header, &message).unwrap(),
                _ => write_v2_msg(&mut stream, header, &message).unwrap(),
            };
        }
        let (rolls, counts) = heard(&stream);
        assert_eq!((rolls.len(), counts.missing, counts.damaged), (20, 0, 0));
    }
}
