//! Frames of telemetry: a snapshot of 145 bytes, a supplement of 56 bytes and a text of 82 bytes. `docs/telemetry.md`
//! documents them.
//!
//! A frame ends with a zero byte and contains no other zero (COBS: Cheshire and Baker, *Consistent overhead byte
//! stuffing*, IEEE/ACM Transactions on Networking 7 (2), 1999). A receiver that joins late or loses bytes is
//! therefore synchronised again at the next frame. A frame is accepted only with a valid CRC-32 over all of it.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc};

use super::sequence::Sequence;
use super::snapshot::{
    FixKind, GpsSummary, Innovations, Sigmas, Snapshot, StatusFlags, SystemMode,
};
use super::supplement::Supplement;
use super::text::{TEXT, Text};
use super::wire::{Codec, stuff, unstuff};
use crate::earth::Geodetic;
use crate::frames::EulerAngles;
use crate::time::Time;

/// Version of a snapshot's layout, in its frame's first byte.
pub const VERSION: u8 = 1;
/// Version of a supplement's layout.
const SUPPLEMENT_VERSION: u8 = 2;
/// Version of a text's layout.
const TEXT_VERSION: u8 = 3;
/// Length of a snapshot's frame, bytes, including the zero at its end.
pub const LENGTH: usize = BODY + OVERHEAD;
/// Length of a supplement's frame, bytes.
pub const SUPPLEMENT_LENGTH: usize = SUPPLEMENT_BODY + OVERHEAD;
/// Length of a text's frame, bytes.
pub const TEXT_LENGTH: usize = TEXT_BODY + OVERHEAD;

/// Length of a snapshot's body without the checksum, bytes.
const BODY: usize = 139;
/// Length of a supplement's body without the checksum, bytes.
const SUPPLEMENT_BODY: usize = 50;
/// Length of a text's body without the checksum, bytes.
const TEXT_BODY: usize = 12 + TEXT;
/// Length of the checksum, bytes.
const CHECKSUM: usize = 4;
/// Overhead of a frame, bytes: checksum, one byte of the stuffing, and the zero.
const OVERHEAD: usize = CHECKSUM + 2;
/// Length of the longest frame without the zero, bytes. The stuffing adds one byte for at most 253 bytes of content.
const STUFFED: usize = LENGTH - 1;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

// Number of steps per unit; each name ends with the unit. Division by a whole number is correctly rounded, so that 31.5
// is unpacked as 31.5.
const RATE_RADPS: f64 = 2e3;
const SPECIFIC_FORCE_MPS2: f64 = 200.0;
const FIELD_GAUSS: f64 = 1e4;
const TEMPERATURE_DEGC: f64 = 100.0;
const ANGLE_RAD: f64 = 1e4;
const PLACE_DEG: f64 = 1e7;
const HEIGHT_M: f64 = 1e3;
const VELOCITY_MPS: f64 = 100.0;
const SIGMA_M: f64 = 100.0;
const SIGMA_MPS: f64 = 1e3;
const WIDTH_MS: f64 = 2e3;
const AGE_S: f64 = 10.0;
const DILUTION: f64 = 10.0;
const NORMALISED: f64 = 20.0;
const DURATION_S: f64 = 1e5;

/// A received frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Number of the frame: one more than that of the previous frame; 0 follows 255.
    pub sequence: u8,
    /// The snapshot in the frame.
    pub snapshot: Snapshot,
}

/// Content of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
// Only one value is on the stack at a time.
#[allow(clippy::large_enum_variant)]
#[non_exhaustive]
pub enum Message {
    /// The state of the flight.
    Snapshot(Frame),
    /// Flight control in detail, and biases.
    Supplement(Supplement),
    /// A text message.
    Text(Text),
}

/// Reason why the bytes between two zeros are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The stuffing is invalid.
    Stuffing,
    /// The length is not that of a frame.
    Length {
        /// Number of bytes without the stuffing and the zero at the end.
        found: usize,
    },
    /// The checksum is invalid.
    Checksum {
        /// Checksum computed from the bytes.
        expected: u32,
        /// Checksum in the frame.
        found: u32,
    },
    /// The frame is complete, but has an unknown version.
    Version {
        /// The version of the frame.
        found: u8,
    },
    /// The frame is complete, but contains an unknown code of a mode, kind of fix or severity.
    Code {
        /// The code.
        found: u8,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stuffing => f.write_str("a zero byte inside the stuffed data"),
            Self::Length { found } => {
                write!(f, "{found} bytes, expected {}", BODY + CHECKSUM)
            }
            Self::Checksum { expected, found } => {
                write!(f, "checksum {found:08x}, expected {expected:08x}")
            }
            Self::Version { found } => write!(f, "version {found}, expected {VERSION}"),
            Self::Code { found } => {
                write!(f, "code {found}: unknown mode, kind of fix or severity")
            }
        }
    }
}

impl core::error::Error for FrameError {}

/// Packs `snapshot` into the frame with the number `sequence`. Each field is rounded to its nearest step; values out of
/// range saturate. A position that is not valid on Earth becomes unknown.
#[must_use]
pub fn pack(snapshot: &Snapshot, sequence: u8) -> [u8; LENGTH] {
    let mut header = [VERSION, sequence, snapshot.mode.code(), snapshot.gps.fix.code()];
    let mut snapshot = *snapshot;
    sealed(|codec| walk(codec, &mut header, &mut snapshot))
}

/// Packs `supplement` into the frame with the number `sequence`, as [`pack`] does.
#[must_use]
pub fn pack_supplement(supplement: &Supplement, sequence: u8) -> [u8; SUPPLEMENT_LENGTH] {
    let mut supplement = *supplement;
    sealed(|codec| {
        supplement.walk(codec, &mut [SUPPLEMENT_VERSION, sequence]);
    })
}

/// Packs `text` into the frame with the number `sequence`.
#[must_use]
pub fn pack_text(text: &Text, sequence: u8) -> [u8; TEXT_LENGTH] {
    let mut text = *text;
    sealed(|codec| {
        text.walk(codec, &mut [TEXT_VERSION, sequence]);
    })
}

/// The frame with the content that `fill` packs.
fn sealed<const N: usize>(fill: impl FnOnce(&mut Codec<'_>)) -> [u8; N] {
    let mut bytes = [0; N];
    if let [_, body @ .., c0, c1, c2, c3, _] = &mut bytes[..] {
        fill(&mut Codec::Pack(&mut *body));
        [*c0, *c1, *c2, *c3] = CRC.checksum(body).to_le_bytes();
    }
    if let [stuffed @ .., _] = &mut bytes[..] {
        stuff(stuffed);
    }
    bytes
}

/// Number and content of the frame `stuffed`, the bytes between two zeros; the bytes are overwritten.
fn unpack(stuffed: &mut [u8]) -> Result<(u8, Message), FrameError> {
    if !unstuff(stuffed) {
        return Err(FrameError::Stuffing);
    }
    let length = FrameError::Length { found: stuffed.len().saturating_sub(1) };
    let [_, body @ .., c0, c1, c2, c3] = stuffed else { return Err(length) };
    let known = match body.len() {
        BODY => VERSION,
        SUPPLEMENT_BODY => SUPPLEMENT_VERSION,
        TEXT_BODY => TEXT_VERSION,
        _ => return Err(length),
    };
    let (expected, found) = (CRC.checksum(body), u32::from_le_bytes([*c0, *c1, *c2, *c3]));
    if expected != found {
        return Err(FrameError::Checksum { expected, found });
    }
    let [version, sequence, code, ..] = *body else { return Err(length) };
    if version != known {
        return Err(FrameError::Version { found: version });
    }
    let codec = &mut Codec::Unpack(body);
    let message = match version {
        SUPPLEMENT_VERSION => {
            let mut supplement = Supplement::at(Time::ZERO);
            supplement.walk(codec, &mut [0; 2]).ok_or(FrameError::Code { found: code })?;
            Message::Supplement(supplement)
        }
        TEXT_VERSION => {
            let mut text = Text::empty();
            text.walk(codec, &mut [0; 2]).ok_or(FrameError::Code { found: code })?;
            Message::Text(text)
        }
        _ => Message::Snapshot(unpack_snapshot(codec)?),
    };
    Ok((sequence, message))
}

fn unpack_snapshot(codec: &mut Codec<'_>) -> Result<Frame, FrameError> {
    let mut header = [0; 4];
    let mut snapshot = Snapshot::at(Time::ZERO);
    walk(codec, &mut header, &mut snapshot);
    let [_, sequence, mode, fix] = header;
    snapshot.mode = SystemMode::from_code(mode).ok_or(FrameError::Code { found: mode })?;
    snapshot.gps.fix = FixKind::from_code(fix).ok_or(FrameError::Code { found: fix })?;
    Ok(Frame { sequence, snapshot })
}

/// Layout of a snapshot: packs or unpacks all fields in their order.
fn walk(codec: &mut Codec<'_>, header: &mut [u8; 4], snapshot: &mut Snapshot) {
    codec.bytes(header);
    codec.time(&mut snapshot.time);
    let mut status = snapshot.status.bits().to_le_bytes();
    codec.bytes(&mut status);
    snapshot.status = StatusFlags::from_bits(u16::from_le_bytes(status));

    codec.vector::<i16, _>(&mut snapshot.angular_rate_radps, RATE_RADPS);
    codec.vector::<i16, _>(&mut snapshot.specific_force_mps2, SPECIFIC_FORCE_MPS2);
    codec.vector::<i16, _>(&mut snapshot.magnetic_field_gauss, FIELD_GAUSS);
    codec.scaled::<i16>(&mut snapshot.temperature_degc, TEMPERATURE_DEGC);

    let mut angles = snapshot.attitude.map(|a| [a.roll_rad, a.pitch_rad, a.yaw_rad]);
    codec.scaled_all::<i16, 3>(&mut angles, ANGLE_RAD);
    snapshot.attitude =
        angles.map(|[roll_rad, pitch_rad, yaw_rad]| EulerAngles { roll_rad, pitch_rad, yaw_rad });
    // An invalid position must become unknown; saturation would give a wrong position.
    let position = snapshot.position.and_then(|position| {
        Geodetic::from_degrees(position.latitude_deg(), position.longitude_deg(), position.height_m)
    });
    let mut place = position.map(|p| [p.latitude_deg(), p.longitude_deg()]);
    let mut height_m = position.map(|p| p.height_m);
    codec.scaled_all::<i32, 2>(&mut place, PLACE_DEG);
    codec.scaled::<i32>(&mut height_m, HEIGHT_M);
    snapshot.position =
        place.zip(height_m).and_then(|([latitude_deg, longitude_deg], height_m)| {
            Geodetic::from_degrees(latitude_deg, longitude_deg, height_m)
        });
    codec.vector::<i16, _>(&mut snapshot.velocity_mps, VELOCITY_MPS);
    sigmas(codec, &mut snapshot.sigmas);

    for widths_ms in [&mut snapshot.commanded_ms, &mut snapshot.pilot_ms] {
        *widths_ms = widths_ms.map(|mut width_ms| {
            codec.scaled::<u16>(&mut width_ms, WIDTH_MS);
            width_ms
        });
    }
    gps(codec, &mut snapshot.gps);
    innovations(codec, &mut snapshot.innovations);

    let timing = &mut snapshot.timing;
    codec.scaled::<u16>(&mut timing.period_s, DURATION_S);
    codec.scaled::<u16>(&mut timing.work_s, DURATION_S);
    codec.scaled::<u16>(&mut timing.longest_work_s, DURATION_S);
    codec.count(&mut timing.overruns);
    let drops = &mut snapshot.drops;
    codec.count(&mut drops.imu_packets);
    codec.count(&mut drops.gps_messages);
    codec.count(&mut drops.pilot_pulses);
    codec.count(&mut drops.telemetry_frames);
}

fn sigmas(codec: &mut Codec<'_>, sigmas: &mut Sigmas) {
    codec.scaled::<u16>(&mut sigmas.horizontal_m, SIGMA_M);
    codec.scaled::<u16>(&mut sigmas.vertical_m, SIGMA_M);
    codec.scaled::<u16>(&mut sigmas.horizontal_velocity_mps, SIGMA_MPS);
    codec.scaled::<u16>(&mut sigmas.vertical_velocity_mps, SIGMA_MPS);
    codec.scaled::<u16>(&mut sigmas.tilt_rad, ANGLE_RAD);
    codec.scaled::<u16>(&mut sigmas.heading_rad, ANGLE_RAD);
}

fn gps(codec: &mut Codec<'_>, gps: &mut GpsSummary) {
    let mut satellites = gps.satellites.map(f64::from);
    codec.scaled::<u8>(&mut satellites, 1.0);
    gps.satellites = satellites.map(|count| count as u8);
    codec.scaled::<u8>(&mut gps.age_s, AGE_S);
    gps.latitude_longitude_deg =
        gps.latitude_longitude_deg.filter(|[latitude_deg, longitude_deg]| {
            libm::fabs(*latitude_deg) <= 90.0 && libm::fabs(*longitude_deg) <= 180.0
        });
    codec.scaled_all::<i32, 2>(&mut gps.latitude_longitude_deg, PLACE_DEG);
    codec.scaled::<i32>(&mut gps.height_m, HEIGHT_M);
    codec.scaled::<i32>(&mut gps.altitude_msl_m, HEIGHT_M);
    codec.scaled_all::<i16, 2>(&mut gps.horizontal_velocity_mps, VELOCITY_MPS);
    codec.scaled::<i16>(&mut gps.down_velocity_mps, VELOCITY_MPS);
    codec.scaled::<u8>(&mut gps.hdop, DILUTION);
    codec.scaled::<u8>(&mut gps.vdop, DILUTION);
}

fn innovations(codec: &mut Codec<'_>, innovations: &mut Innovations) {
    codec.scaled::<u8>(&mut innovations.position, NORMALISED);
    codec.scaled::<u8>(&mut innovations.velocity, NORMALISED);
    codec.scaled::<u8>(&mut innovations.attitude, NORMALISED);
    codec.scaled::<u8>(&mut innovations.heading, NORMALISED);
    codec.scaled::<u8>(&mut innovations.baro, NORMALISED);
    codec.count(&mut innovations.rejected);
}

/// Counts of the stream since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameCounts {
    /// Bytes received.
    pub bytes: u64,
    /// Frames delivered.
    pub frames: u64,
    /// Sequences of bytes between two zeros that were not a frame.
    pub damaged: u64,
    /// Missing frames according to the frame numbers, damaged frames included: [`Sequence`].
    pub missing: u64,
}

/// Finds the frames in a stream of bytes, which may be damaged.
///
/// A frame is delivered with its zero; after any damage the next complete frame is found. Memory is fixed. The work per
/// byte is constant, except at a zero, which needs the work of one frame.
#[derive(Clone, Debug)]
pub struct Decoder {
    stuffed: [u8; STUFFED],
    /// Number of bytes since the last zero, including those beyond the capacity of `stuffed`.
    length: usize,
    sequence: Sequence,
    counts: FrameCounts,
}

impl Default for Decoder {
    fn default() -> Self {
        let (sequence, counts) = (Sequence::default(), FrameCounts::default());
        Self { stuffed: [0; STUFFED], length: 0, sequence, counts }
    }
}

impl Decoder {
    /// Processes one byte. Returns the snapshot that it completes, or the reason why the bytes are not a frame. Frames
    /// with other content are skipped.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame, FrameError>> {
        match self.push_message(byte)? {
            Ok(Message::Snapshot(frame)) => Some(Ok(frame)),
            Ok(_) => None,
            Err(error) => Some(Err(error)),
        }
    }

    /// Processes one byte. Returns the content of the frame that it completes, or the reason why the bytes are not a
    /// frame.
    pub fn push_message(&mut self, byte: u8) -> Option<Result<Message, FrameError>> {
        self.counts.bytes += 1;
        if byte != 0 {
            if let Some(slot) = self.stuffed.get_mut(self.length) {
                *slot = byte;
            }
            self.length = self.length.saturating_add(1);
            return None;
        }
        let length = core::mem::take(&mut self.length);
        if length == 0 {
            return None;
        }
        let result = self
            .stuffed
            .get_mut(..length)
            .ok_or(FrameError::Length { found: length })
            .and_then(unpack);
        match &result {
            Ok((sequence, _)) => {
                self.sequence.observe(*sequence);
                self.counts.missing = self.sequence.missing();
                self.counts.frames += 1;
            }
            Err(_) => self.counts.damaged += 1,
        }
        Some(result.map(|(_, message)| message))
    }

    /// Counts of the stream since the start.
    #[must_use]
    pub const fn counts(&self) -> &FrameCounts {
        &self.counts
    }
}

#[cfg(test)]
mod tests;
