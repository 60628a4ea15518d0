//! A record's file piece by piece, whole or not.

use std::borrow::Cow;

use mcap::records::{Record as McapRecord, op};

use super::channel::Channel;

/// An opcode and the length of what follows.
const FRAME: usize = 9;
/// The number that the writer gives to the first topic.
const FIRST_CHANNEL: usize = 1;
/// Checks the text of chunks as MCAP has it: the CRC-32 of zip files.
const CRC: crc::Crc<u32, crc::Table<16>> =
    crc::Crc::<u32, crc::Table<16>>::new(&crc::CRC_32_ISO_HDLC);

/// What a walk over the file meets.
pub enum Piece<'a> {
    /// What a chunk holds, its checksum right.
    Chunk(Cow<'a, [u8]>),
    /// What cannot be read, and why; where the file is cut off it is the last.
    Damage(String),
    /// How many messages the writer says there are.
    Statistics(u64),
    /// The file was ended, and not cut off.
    End,
}

/// Walks over `bytes`, a whole file with its magic bytes: each piece with the byte it begins at.
pub fn pieces(bytes: &[u8]) -> impl Iterator<Item = (usize, Piece<'_>)> {
    let mut offset = mcap::MAGIC.len();
    let mut is_over = false;
    std::iter::from_fn(move || {
        while !is_over && offset < bytes.len() {
            let at = offset;
            let Some((opcode, body)) = frame(&bytes[at..]) else {
                is_over = true;
                let reason = "the file ends within a record: it was cut off";
                return Some((at, Piece::Damage(reason.into())));
            };
            offset += FRAME + body.len();
            match opcode {
                op::CHUNK => {
                    return Some((at, chunk(body).map_or_else(Piece::Damage, Piece::Chunk)));
                }
                op::FOOTER => {
                    is_over = true;
                    return Some((at, Piece::End));
                }
                0 => {
                    is_over = true;
                    let reason = "found a zero, expected the kind of a record";
                    return Some((at, Piece::Damage(reason.into())));
                }
                op::STATISTICS => {
                    let piece = match mcap::parse_record(opcode, body) {
                        Ok(McapRecord::Statistics(found)) => Piece::Statistics(found.message_count),
                        _ => Piece::Damage("the statistics are damaged".into()),
                    };
                    return Some((at, piece));
                }
                _ => {}
            }
        }
        None
    })
}

/// What the chunk `body` holds if all of it is whole; else what is wrong with it.
fn chunk(body: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let Ok(McapRecord::Chunk { header, data }) = mcap::parse_record(op::CHUNK, body) else {
        return Err("the head of a chunk is damaged".into());
    };
    if !header.compression.is_empty() {
        let compression = &header.compression;
        return Err(format!("found a chunk in \"{compression}\", expected none compressed"));
    }
    let found = CRC.checksum(&data);
    if found != header.uncompressed_crc {
        let expected = header.uncompressed_crc;
        return Err(format!(
            "found a chunk with checksum {found:08x}, expected {expected:08x}: left out"
        ));
    }
    Ok(data)
}

/// The topics and messages in a chunk.
pub fn records(chunk: &[u8]) -> impl Iterator<Item = McapRecord<'_>> {
    let mut rest = chunk;
    std::iter::from_fn(move || {
        while let Some((opcode, body)) = frame(rest) {
            rest = &rest[FRAME + body.len()..];
            if matches!(opcode, op::CHANNEL | op::MESSAGE)
                && let Ok(record) = mcap::parse_record(opcode, body)
            {
                return Some(record);
            }
        }
        None
    })
}

/// The first record of `bytes`; `None` if it does not end within them.
fn frame(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (head, rest) = bytes.split_first_chunk::<FRAME>()?;
    let [opcode, length @ ..] = *head;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    Some((opcode, rest.get(..length)?))
}

/// Which topic a number of the file means.
#[derive(Default)]
pub struct Topics(Vec<(u16, Channel)>);

impl Topics {
    /// Learns what the file says of a topic.
    pub fn learn(&mut self, channel: &mcap::records::Channel) {
        self.0.extend(Channel::with_topic(&channel.topic).map(|known| (channel.id, known)));
    }

    /// The topic with the number `id`. Where the chunk that names the topics is damaged, their numbers
    /// are those of the writer.
    pub fn of(&self, id: u16) -> Option<Channel> {
        if self.0.is_empty() {
            let place = usize::from(id).checked_sub(FIRST_CHANNEL)?;
            return Channel::ALL.get(place).copied();
        }
        self.0.iter().find(|(known, _)| *known == id).map(|(_, channel)| *channel)
    }
}
