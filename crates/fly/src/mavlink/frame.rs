//! The frames of both versions of MAVLink.
//!
//! Source: MAVLink, *packet serialization*: the checksum covers the header, the payload and one byte (CRC_EXTRA)
//! derived from the layout of the message.

use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message as _, calculate_crc};

const MAGIC_1: u8 = 0xFE;
const MAGIC_2: u8 = 0xFD;
const CHECKSUM: usize = 2;
const SIGNATURE: usize = 13;
/// The only supported incompatibility flag: the frame is signed.
const SIGNED: u8 = 1;

/// A complete frame.
pub struct Frame<'a> {
    /// Version of MAVLink.
    pub version: MavlinkVersion,
    /// Number of the message.
    pub id: u32,
    /// Number of the frame, modulo 256.
    pub sequence: u8,
    /// System and component.
    pub sender: (u8, u8),
    /// Payload; trailing zeros may be missing.
    pub payload: &'a [u8],
    /// Length in bytes.
    pub length: usize,
}

/// The result of decoding at a possible start of a frame.
pub enum Begun<'a> {
    /// A frame with a valid checksum.
    Frame(Frame<'a>),
    /// A frame of an unknown message, and the CRC_EXTRA byte that would make its checksum valid. One in 256 damaged
    /// frames looks like this.
    Stranger(Frame<'a>, u8),
    /// No frame, or an unsupported frame.
    Nothing,
    /// A frame of a known message with a wrong checksum.
    Damaged,
    /// Too few bytes to decide.
    Short,
}

/// Whether a frame can start with `byte`; version 1 counts only with `first_too`.
#[must_use]
pub const fn is_magic(byte: u8, first_too: bool) -> bool {
    byte == MAGIC_2 || byte == MAGIC_1 && first_too
}

/// Decodes the frame at the front of `bytes`, which start with a magic byte. `also` is the number and the CRC_EXTRA
/// byte of a message that is not in the common set.
#[must_use]
pub fn begun(bytes: &[u8], also: Option<(u32, u8)>) -> Begun<'_> {
    let version = match bytes.first() {
        Some(&MAGIC_1) => MavlinkVersion::V1,
        _ => MavlinkVersion::V2,
    };
    let (header, signature) = match (version, bytes.get(2)) {
        (_, None) => return Begun::Short,
        (MavlinkVersion::V1, _) => (6, 0),
        (MavlinkVersion::V2, Some(0)) => (10, 0),
        (MavlinkVersion::V2, Some(&SIGNED)) => (10, SIGNATURE),
        (MavlinkVersion::V2, _) => return Begun::Nothing,
    };
    let end = header + usize::from(bytes[1]);
    let length = end + CHECKSUM + signature;
    if bytes.len() < length {
        return Begun::Short;
    }
    let (id, sequence, sender) = match version {
        MavlinkVersion::V1 => (u32::from(bytes[5]), bytes[2], (bytes[3], bytes[4])),
        MavlinkVersion::V2 => {
            let id = u32::from_le_bytes([bytes[7], bytes[8], bytes[9], 0]);
            (id, bytes[4], (bytes[5], bytes[6]))
        }
    };
    let found = u16::from_le_bytes([bytes[end], bytes[end + 1]]);
    let (covered, payload) = (&bytes[1..end], &bytes[header..end]);
    let frame = Frame { version, id, sequence, sender, payload, length };
    match layout(id, also) {
        Some(layout) if calculate_crc(covered, layout) == found => Begun::Frame(frame),
        Some(_) => Begun::Damaged,
        None => match layout_of(covered, found) {
            Some(layout) => Begun::Stranger(frame, layout),
            None => Begun::Nothing,
        },
    }
}

/// The CRC_EXTRA byte of a known message.
fn layout(id: u32, also: Option<(u32, u8)>) -> Option<u8> {
    also.filter(|(own, _)| *own == id)
        .map(|(_, layout)| layout)
        .or_else(|| MavMessage::default_message_from_id(id).map(|_| MavMessage::extra_crc(id)))
}

/// The CRC_EXTRA byte for which the checksum of `covered` would be `found`.
fn layout_of(covered: &[u8], found: u16) -> Option<u8> {
    let before = covered.iter().fold(u16::MAX, |checksum, byte| accumulated(checksum, *byte));
    (0..=u8::MAX).find(|layout| accumulated(before, *layout) == found)
}

/// The checksum, CRC-16/MCRF4XX, extended by one byte.
const fn accumulated(checksum: u16, byte: u8) -> u16 {
    let mixed = byte ^ (checksum & 0xFF) as u8;
    let mixed = (mixed ^ (mixed << 4)) as u16;
    (checksum >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_layout_of_a_message_is_found_from_its_checksum() {
        let covered = b"123456789";
        assert_eq!(covered.iter().fold(u16::MAX, |sum, byte| accumulated(sum, *byte)), 0x6F91);
        for layout in [0, 1, 71, 255] {
            assert_eq!(layout_of(covered, calculate_crc(covered, layout)), Some(layout));
        }
    }
}
