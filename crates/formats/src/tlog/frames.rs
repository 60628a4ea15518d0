//! The frames of a telemetry log, each after its arrival time.

use std::io;

use super::message::Message;
use crate::choice::{is_alive, is_fix};
use crate::window::Window;
use hovernav_dataset::Dimensions;

/// A frame whose message is read.
pub(super) struct Frame {
    pub message: Message,
    /// System and component of the sender.
    pub sender: (u8, u8),
    /// Byte offset of the time before the frame.
    pub place: u64,
    /// Arrival time on the clock of the logging computer, s since 1970.
    pub stamp_s: f64,
    pub row: [f64; Message::WIDTH],
}

impl Frame {
    /// Whether the message has a measurement that may be used.
    pub fn is_good(&self) -> bool {
        let row = &self.row;
        match self.message {
            Message::GpsRaw | Message::Gps2Raw => {
                is_fix(Dimensions::of_type(row[6]), [row[1], row[2]])
            }
            Message::HighresImu
            | Message::RawImu
            | Message::ScaledImu
            | Message::ScaledImu2
            | Message::ScaledImu3 => is_alive([row[4], row[5], row[6]]),
            _ => true,
        }
    }
}

/// Damage in a log.
#[derive(Debug, Default)]
pub(super) struct Damages {
    /// Number of frames with a wrong checksum, and the byte offset of the first.
    pub wrong_checksums: usize,
    pub first_wrong: Option<u64>,
    /// Number of bytes outside frames, and the offset of the first.
    pub skipped: u64,
    pub first_passed: Option<u64>,
    /// Byte offset of a frame that the end of the file cuts off.
    pub cut_off: Option<u64>,
}

/// Length of the time before a frame, bytes.
const STAMP: usize = 8;
/// First byte of a MAVLink 1 frame.
const MAVLINK_1: u8 = 0xFE;
/// First byte of a MAVLink 2 frame.
const MAVLINK_2: u8 = 0xFD;
/// Largest length of a time and its frame, bytes: a signed frame with a payload of 255 bytes.
const LONGEST: usize = STAMP + 10 + 255 + 2 + 13;

const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MCRF4XX);

/// Passes each frame whose message is read to `take`, and returns the damage.
pub(super) fn each(mut window: Window<'_>, take: &mut dyn FnMut(&Frame)) -> io::Result<Damages> {
    let mut damages = Damages::default();
    loop {
        let place = window.offset();
        let bytes = window.peek(2 * LONGEST)?;
        if bytes.is_empty() {
            return Ok(damages);
        }
        let found = Layout::of(bytes);
        let is_cut_off = match &found {
            Some(layout) => bytes.len() < layout.length,
            None => bytes.len() <= STAMP,
        };
        if is_cut_off {
            damages.cut_off = Some(place);
            return Ok(damages);
        }
        let layout = found.filter(|layout| layout.is_followed(bytes));
        let Some(layout) = layout else {
            damages.skipped += 1;
            damages.first_passed.get_or_insert(place);
            window.consume(1);
            continue;
        };
        if let Some(message) = Message::numbered(layout.number) {
            if layout.checksum_is_right(bytes, message.seed()) {
                let stamp = bytes.first_chunk().map_or(0, |stamp| u64::from_be_bytes(*stamp));
                take(&Frame {
                    message,
                    sender: layout.sender,
                    place,
                    stamp_s: stamp as f64 / 1e6,
                    row: message.row(&bytes[layout.payload.0..layout.payload.1]),
                });
            } else {
                damages.wrong_checksums += 1;
                damages.first_wrong.get_or_insert(place);
            }
        }
        window.consume(layout.length);
    }
}

/// Offsets within a time and its frame.
struct Layout {
    number: u32,
    sender: (u8, u8),
    /// Start and end of the payload.
    payload: (usize, usize),
    /// Length of the time and the frame, bytes.
    length: usize,
}

impl Layout {
    /// The layout of the frame at the start of `bytes`, which may be shorter than the frame.
    fn of(bytes: &[u8]) -> Option<Self> {
        let frame = bytes.get(STAMP..)?;
        match *frame {
            [MAVLINK_1, payload, _, system, component, number, ..] => {
                let start = STAMP + 6;
                let end = start + usize::from(payload);
                let (number, sender) = (number.into(), (system, component));
                Some(Self { number, sender, payload: (start, end), length: end + 2 })
            }
            [MAVLINK_2, payload, flags, _, _, system, component, low, middle, high, ..] => {
                let start = STAMP + 10;
                let end = start + usize::from(payload);
                let signature = if flags & 1 == 1 { 13 } else { 0 };
                Some(Self {
                    number: u32::from_le_bytes([low, middle, high, 0]),
                    sender: (system, component),
                    payload: (start, end),
                    length: end + 2 + signature,
                })
            }
            _ => None,
        }
    }

    /// Whether another frame follows, or the end of the file.
    fn is_followed(&self, bytes: &[u8]) -> bool {
        match bytes.get(self.length..) {
            None => false,
            Some(rest) => match rest.get(STAMP) {
                None => true,
                Some(&mark) => matches!(mark, MAVLINK_1 | MAVLINK_2),
            },
        }
    }

    fn checksum_is_right(&self, bytes: &[u8], seed: u8) -> bool {
        let end = self.payload.1;
        let Some(&[low, high]) = bytes.get(end..end + 2).and_then(|sum| sum.first_chunk()) else {
            return false;
        };
        let mut digest = CRC.digest();
        digest.update(&bytes[STAMP + 1..end]);
        digest.update(&[seed]);
        digest.finalize() == u16::from_le_bytes([low, high])
    }
}
