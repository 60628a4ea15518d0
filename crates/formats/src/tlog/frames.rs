//! The frames of a telemetry log, each behind the time at which it came.

use std::io;

use super::message::Message;
use crate::window::Window;

/// A frame with a message that is read.
pub(super) struct Frame {
    pub message: Message,
    /// Who sent it: system and component.
    pub sender: (u8, u8),
    /// Byte at which its time begins.
    pub place: u64,
    /// When it came, s since 1970 by the computer that logged it.
    pub stamp_s: f64,
    pub row: [f64; Message::WIDTH],
}

/// What is wrong with a log.
#[derive(Debug, Default)]
pub(super) struct Damages {
    /// Frames with a wrong checksum, and the first one's byte.
    pub wrong_checksums: usize,
    pub first_wrong: Option<u64>,
    /// Bytes that belong to no frame, and the first one.
    pub passed_over: u64,
    pub first_passed: Option<u64>,
    /// Where the file ends within a frame.
    pub cut_off: Option<u64>,
}

/// Bytes of a time.
const STAMP: usize = 8;
const MAVLINK_1: u8 = 0xFE;
const MAVLINK_2: u8 = 0xFD;
/// The longest time and frame: a payload of 255 bytes, signed.
const LONGEST: usize = STAMP + 10 + 255 + 2 + 13;

const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MCRF4XX);

/// Gives each frame of the log in `window` that is read to `take`.
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
            damages.passed_over += 1;
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

/// Where the parts of a time and a frame stand.
struct Layout {
    number: u32,
    sender: (u8, u8),
    /// Where the payload begins and ends.
    payload: (usize, usize),
    /// Bytes of time and frame.
    length: usize,
}

impl Layout {
    /// Of the frame that `bytes` begin with; it may end after them.
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
