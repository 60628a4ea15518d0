//! Reads the messages of a ULog file and records its damage.
//!
//! # Source
//! PX4 developer guide, *ULog file format*: header, flag bits, message header.

use std::io;

use crate::damages::Damages;
use crate::window::Window;

/// A message: its type, offset and body.
pub(super) struct Message<'a> {
    pub kind: u8,
    pub offset: u64,
    pub body: &'a [u8],
}

/// Reader of the messages of a file, also of a damaged one.
pub(super) struct Messages<'w> {
    window: Window<'w>,
    /// Offsets of appended data, ascending.
    appended: Vec<u64>,
    /// Length of the last returned message, which is consumed next.
    handed_out: usize,
    /// Clock at the start of the file, µs.
    pub start_us: u64,
    /// Damage of the file.
    pub damages: Damages,
}

/// Length of the file header, bytes: magic, version and clock.
const HEADER: usize = 16;
/// Length of a message header, bytes: size and type.
const HEAD: usize = 3;
/// Valid types of messages.
const KINDS: &[u8] = b"BFIMPQARDLCSO";
/// Number of consecutive valid messages that end a search after damage.
const CHAIN: usize = 4;
/// Bytes searched at a time after damage, enough for [`CHAIN`] ordinary messages.
const LOOKAHEAD: usize = 1 << 16;

impl<'w> Messages<'w> {
    /// The messages of `window`, which is at the start of the file. `None` if the file header is incomplete.
    pub fn new(mut window: Window<'w>) -> io::Result<Option<Self>> {
        let header = window.peek(HEADER)?;
        let Some(clock) = header.get(8..HEADER).and_then(|clock| clock.first_chunk()) else {
            return Ok(None);
        };
        let start_us = u64::from_le_bytes(*clock);
        window.consume(HEADER);
        Ok(Some(Self {
            window,
            appended: Vec::new(),
            handed_out: 0,
            start_us,
            damages: Damages::default(),
        }))
    }

    /// The next message; `None` at the end of the file.
    pub fn next(&mut self) -> io::Result<Option<Message<'_>>> {
        self.window.consume(std::mem::take(&mut self.handed_out));
        loop {
            let offset = self.window.offset();
            let next_part = self.appended.iter().copied().find(|&part| part > offset);
            let bytes = self.window.peek(HEAD)?;
            let Some(&[low, high, kind]) = bytes.first_chunk::<HEAD>() else {
                if !bytes.is_empty() {
                    self.damages.add(
                        offset,
                        "the file ends within the header of a message, which \
                                              is ignored",
                    );
                }
                return Ok(None);
            };
            let length = HEAD + usize::from(u16::from_le_bytes([low, high]));
            if let Some(part) = next_part.filter(|&part| offset + length as u64 > part) {
                self.damages.add(offset, "appended data cut off a message, which is ignored");
                self.window.seek(part)?;
                continue;
            }
            if length == HEAD || !KINDS.contains(&kind) {
                let reason = format!("found no message, but type {kind:#04x}; ignored");
                self.damages.add(offset, reason);
                if !self.resynchronise()? {
                    return Ok(None);
                }
                continue;
            }
            if self.window.peek(length)?.len() < length {
                self.damages.add(offset, "the file ends within a message, which is ignored");
                return Ok(None);
            }
            self.handed_out = length;
            if kind == b'B' {
                self.flags(length)?;
            }
            let body = &self.window.peek(length)?[HEAD..length];
            return Ok(Some(Message { kind, offset, body }));
        }
    }

    /// Reads the offsets of appended data from a flag message.
    fn flags(&mut self, length: usize) -> io::Result<()> {
        // The body has eight bytes of compatible flags, eight of incompatible ones, and three offsets.
        let offset = self.window.offset();
        let body = &self.window.peek(length)?[HEAD..length];
        let is_appended = body.get(8).is_some_and(|flags| flags & 1 == 1);
        let places: Vec<u64> = body
            .get(16..40)
            .unwrap_or_default()
            .chunks_exact(8)
            .filter_map(|place| Some(u64::from_le_bytes(*place.first_chunk()?)))
            .filter(|&place| is_appended && place > offset)
            .collect();
        self.appended = places;
        self.appended.sort_unstable();
        Ok(())
    }

    /// Moves to the next sequence of valid messages; false if there is no such sequence.
    fn resynchronise(&mut self) -> io::Result<bool> {
        loop {
            self.window.consume(1);
            let bytes = self.window.peek(LOOKAHEAD)?;
            if bytes.len() <= HEAD {
                return Ok(false);
            }
            let is_whole = bytes.len() < LOOKAHEAD;
            let searched = if is_whole { bytes.len() } else { bytes.len() - LOOKAHEAD / 2 };
            let found = (0..searched).find(|&place| is_chain(&bytes[place..], is_whole));
            self.window.consume(found.unwrap_or(searched));
            if found.is_some() {
                return Ok(true);
            }
        }
    }
}

/// Whether `bytes` begin with a sequence of valid messages. `is_whole` means that `bytes` reach the end of the file.
fn is_chain(mut bytes: &[u8], is_whole: bool) -> bool {
    for _ in 0..CHAIN {
        let Some(&[low, high, kind]) = bytes.first_chunk::<HEAD>() else {
            return is_whole && bytes.is_empty();
        };
        let length = usize::from(u16::from_le_bytes([low, high]));
        if length == 0 || !KINDS.contains(&kind) || (kind == b'S' && length != 8) {
            return false;
        }
        let Some(rest) = bytes.get(HEAD + length..) else { return false };
        bytes = rest;
    }
    true
}
