//! Iteration over the pieces of a record's file, intact or damaged.

use std::borrow::Cow;

use mcap::records::{Metadata, Record as McapRecord, op};

use crate::channel::Channel;
use crate::unpack::unpacked;

/// Largest size of a record, bytes, packed and unpacked; larger ones are rejected.
pub(crate) const LARGEST_BYTES: u64 = 4 << 30;

/// Length of an opcode and a length field, bytes.
const FRAME: usize = 9;
/// Number of the first topic.
const FIRST_CHANNEL: usize = 1;

/// A piece of the file.
pub enum Piece<'a> {
    /// Records: the content of a chunk with a correct checksum, or a single topic or message outside chunks.
    Chunk(Cow<'a, [u8]>),
    /// An unreadable part, with the reason; the last piece if the file is cut off.
    Damage {
        /// Reason.
        reason: String,
        /// Number of bytes lost.
        bytes: usize,
    },
    /// Metadata that a tool has written.
    Metadata(Metadata),
    /// Number of messages according to the writer.
    Statistics(u64),
    /// The regular end of the file.
    End,
}

/// Limit of the bytes checked in the search for intact chunks, unpacked, as a multiple of the file's size. It bounds the
/// time for a forged file.
const SEARCHED: usize = 4;

/// Iterates over `bytes`, a whole file with its magic bytes; yields each piece with its byte offset. If a record does
/// not end where its length says, the iteration continues at the next intact chunk.
pub fn pieces(bytes: &[u8]) -> impl Iterator<Item = (usize, Piece<'_>)> {
    let mut offset = mcap::MAGIC.len();
    let mut is_over = false;
    let mut room = LARGEST_BYTES;
    let mut budget = bytes.len().saturating_mul(SEARCHED);
    std::iter::from_fn(move || {
        while !is_over && offset < bytes.len() {
            let at = offset;
            let found = frame(&bytes[at..]);
            let reason = match found {
                None => "the file ends within a record: it was cut off".to_owned(),
                Some((0, _)) => "found a zero, expected the kind of a record".to_owned(),
                Some((op::CHUNK, body)) => match chunk(body) {
                    Ok(Cow::Owned(data)) if data.len() as u64 > room => {
                        is_over = true;
                        let reason =
                            format!("the chunks have more than {LARGEST_BYTES} bytes uncompressed");
                        return Some((at, Piece::Damage { reason, bytes: bytes.len() - at }));
                    }
                    // A corrupted length that is too long includes the records that follow.
                    Ok(data) if has_chunk_lengths(body) => {
                        offset += FRAME + body.len();
                        if let Cow::Owned(data) = &data {
                            room -= data.len() as u64;
                        }
                        return Some((at, Piece::Chunk(data)));
                    }
                    // If a record follows, the length is right and the content is damaged.
                    Err(reason) if is_followed(bytes, at + FRAME + body.len()) => {
                        let bytes = FRAME + body.len();
                        offset += bytes;
                        return Some((at, Piece::Damage { reason, bytes }));
                    }
                    Err(reason) => reason,
                    Ok(_) => "the length of a chunk is damaged".to_owned(),
                },
                Some((opcode, _)) if !is_known(opcode) => {
                    format!("found a record of unknown kind {opcode}")
                }
                Some((op::FOOTER, body)) if ends(bytes, at + FRAME + body.len()) => {
                    is_over = true;
                    return Some((at, Piece::End));
                }
                Some((opcode, body))
                    if opcode == op::FOOTER || !may_be_followed(bytes, at + FRAME + body.len()) =>
                {
                    format!("the kind or the length of a record is damaged (kind {opcode})")
                }
                Some((op::CHANNEL | op::MESSAGE, body)) => {
                    offset += FRAME + body.len();
                    return Some((at, Piece::Chunk(Cow::Borrowed(&bytes[at..offset]))));
                }
                Some((opcode, body)) => {
                    offset += FRAME + body.len();
                    let bytes = FRAME + body.len();
                    // Others stay unread: the crate panics on an attachment that is truncated within its header.
                    let reason = match opcode {
                        op::STATISTICS => match mcap::parse_record(opcode, body) {
                            Ok(McapRecord::Statistics(found)) => {
                                return Some((at, Piece::Statistics(found.message_count)));
                            }
                            _ => "the statistics are damaged".to_owned(),
                        },
                        op::METADATA => match mcap::parse_record(opcode, body) {
                            Ok(McapRecord::Metadata(found)) => {
                                return Some((at, Piece::Metadata(found)));
                            }
                            _ => "the metadata are damaged".to_owned(),
                        },
                        _ => continue,
                    };
                    return Some((at, Piece::Damage { reason, bytes }));
                }
            };
            let Some(next) = next_whole(bytes, at + 1, &mut budget) else {
                is_over = true;
                return Some((at, Piece::Damage { reason, bytes: bytes.len() - at }));
            };
            offset = next;
            let skipped = next - at;
            let reason = format!(
                "{reason}; {skipped} bytes skipped, reading continues at the chunk at byte {next}"
            );
            return Some((at, Piece::Damage { reason, bytes: skipped }));
        }
        // A file can also be cut off between two records.
        (!std::mem::replace(&mut is_over, true)).then(|| {
            let reason = "the file ends without its last record: it was cut off".into();
            (offset, Piece::Damage { reason, bytes: 0 })
        })
    })
}

/// Whether `opcode` is one of MCAP's.
const fn is_known(opcode: u8) -> bool {
    matches!(opcode, op::HEADER..=op::DATA_END)
}

/// Whether the bytes from `at` on are the end of a file, possibly incomplete.
fn ends(bytes: &[u8], at: usize) -> bool {
    bytes.get(at..).is_some_and(|rest| mcap::MAGIC.starts_with(rest))
}

/// Whether the file ends at `at`, or a possible record begins there.
fn is_followed(bytes: &[u8], at: usize) -> bool {
    let Some(rest) = bytes.get(at..) else { return false };
    rest.is_empty() || frame(rest).is_some_and(|(opcode, _)| is_known(opcode))
}

/// The same for a record that may be cut off or have a damaged length.
fn may_be_followed(bytes: &[u8], at: usize) -> bool {
    bytes.get(at..).is_some_and(|rest| rest.first().is_none_or(|&opcode| is_known(opcode)))
}

/// Start of the next intact chunk from byte `from` on; `budget` is the number of bytes that may still be checked for
/// it.
fn next_whole(bytes: &[u8], from: usize, budget: &mut usize) -> Option<usize> {
    (from..bytes.len()).find(|&at| {
        let Some((op::CHUNK, body)) = frame(&bytes[at..]) else { return false };
        let length = number(body, 16).unwrap_or(usize::MAX).max(body.len());
        if !has_chunk_lengths(body) || length > *budget {
            return false;
        }
        *budget -= length;
        chunk(body).is_ok()
    })
}

/// Whether the lengths in the head of a chunk match that of `body`.
fn has_chunk_lengths(body: &[u8]) -> bool {
    /// Length of the head of a chunk, bytes: two times, length and checksum of the content, the length of the name of
    /// its compression, and its length in the file.
    const HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;
    let name = body.get(28..).and_then(<[u8]>::first_chunk).map(|bytes| u32::from_le_bytes(*bytes));
    // No name, `lz4` or `zstd`.
    let Some(name @ 0..=4) = name else { return false };
    let name = name as usize;
    let text = body.len().checked_sub(HEAD + name);
    text.is_some() && number(body, 32 + name) == text && (name > 0 || number(body, 16) == text)
}

/// The number of eight bytes at the offset `from`.
fn number(bytes: &[u8], from: usize) -> Option<usize> {
    let bytes = bytes.get(from..)?.first_chunk::<8>()?;
    usize::try_from(u64::from_le_bytes(*bytes)).ok()
}

/// Content of the chunk `body` if it is intact; otherwise its defect.
fn chunk(body: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let Ok(McapRecord::Chunk { header, data }) = mcap::parse_record(op::CHUNK, body) else {
        return Err("the head of a chunk is damaged".into());
    };
    unpacked(&header, data)
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

/// The first record of `bytes`; `None` if it is incomplete.
fn frame(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (head, rest) = bytes.split_first_chunk::<FRAME>()?;
    let [opcode, length @ ..] = *head;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    Some((opcode, rest.get(..length)?))
}

/// Topics by their number in the file.
#[derive(Default)]
pub struct Topics(Vec<(u16, Channel)>);

impl Topics {
    /// Adds a topic from the file.
    pub fn learn(&mut self, channel: &mcap::records::Channel) {
        self.0.extend(Channel::with_topic(&channel.topic).map(|known| (channel.id, known)));
    }

    /// The topic with the number `id`. If the chunk with the names of the topics is damaged, the writer's own numbers
    /// apply.
    pub fn of(&self, id: u16) -> Option<Channel> {
        if self.0.is_empty() {
            let place = usize::from(id).checked_sub(FIRST_CHANNEL)?;
            return Channel::ALL.get(place).copied();
        }
        self.0.iter().find(|(known, _)| *known == id).map(|(_, channel)| *channel)
    }
}
