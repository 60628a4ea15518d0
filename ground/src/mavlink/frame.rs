//! The frames of both versions of MAVLink.

use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message as _, calculate_crc};

const MAGIC_1: u8 = 0xFE;
const MAGIC_2: u8 = 0xFD;
const CHECKSUM: usize = 2;
const SIGNATURE: usize = 13;
/// The only feature of a frame that must be understood, and is: it is signed.
const SIGNED: u8 = 1;

/// A whole frame with a right checksum.
pub struct Frame<'a> {
    pub version: MavlinkVersion,
    pub id: u32,
    pub sequence: u8,
    /// System and component.
    pub sender: (u8, u8),
    pub payload: &'a [u8],
    /// Bytes that it takes.
    pub length: usize,
}

/// What stands where a frame could begin.
pub enum Begun<'a> {
    /// A frame.
    Frame(Frame<'a>),
    /// None, or one that is not understood.
    Nothing,
    /// One of a known message, with a wrong checksum.
    Damaged,
    /// Too few bytes to tell.
    Short,
}

/// Whether a frame can begin with `byte`; one of the first version only while `first_too`.
pub const fn is_magic(byte: u8, first_too: bool) -> bool {
    byte == MAGIC_2 || byte == MAGIC_1 && first_too
}

/// What begins with the magic byte at the front of `bytes`.
pub fn begun(bytes: &[u8]) -> Begun<'_> {
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
    if calculate_crc(&bytes[1..end], MavMessage::extra_crc(id)) == found {
        let payload = &bytes[header..end];
        return Begun::Frame(Frame { version, id, sequence, sender, payload, length });
    }
    // Of a message that nobody here knows, the checksum cannot be known either.
    if MavMessage::default_message_from_id(id).is_some() { Begun::Damaged } else { Begun::Nothing }
}
