//! Finds UBX messages in a stream of bytes.

use crate::buffer::move_to_front;
use crate::time::Time;

/// The two bytes that start every message.
pub(super) const SYNC: [u8; 2] = [0xB5, 0x62];
const HEADER: usize = 6;
/// Length of the longest accepted message, bytes: NAV-PVT with a payload of 92.
const MAX_MESSAGE: usize = HEADER + 92 + 2;

/// The messages that the decoder reads: class, id and possible payload lengths.
const KNOWN: [(u8, u8, &[u16]); 10] = [
    (0x01, 0x02, &[28]),
    (0x01, 0x03, &[16]),
    (0x01, 0x04, &[18]),
    (0x01, 0x06, &[52]),
    (0x01, 0x07, &[84, 92]),
    (0x01, 0x12, &[36]),
    (0x01, 0x20, &[16]),
    (0x01, 0x3C, &[64]),
    (0x05, 0x00, &[2]),
    (0x05, 0x01, &[2]),
];

/// A message with a valid checksum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Message<'a> {
    pub class: u8,
    pub id: u8,
    pub payload: &'a [u8],
    /// Arrival of the message's first byte.
    pub arrival: Time,
}

/// Finds the known messages in a stream that arrives in any pieces, with any bytes between the messages.
///
/// It recognises the start of a message by the complete header, and ignores the length of unknown messages: the bytes
/// between known messages are skipped one by one. After an invalid checksum the search continues one byte later, so
/// that a message that starts inside a damaged one is found.
#[derive(Clone, Debug)]
pub(super) struct Framer {
    /// The buffered bytes of the message.
    bytes: [u8; MAX_MESSAGE],
    /// Arrival of each buffered byte.
    arrivals: [Time; MAX_MESSAGE],
    length: usize,
    /// Length of the message once its header is recognised; 0 before.
    end: usize,
    /// Bytes at the front that have been delivered and are removed before the next search.
    spent: usize,
    broken: u32,
}

impl Default for Framer {
    fn default() -> Self {
        Self {
            bytes: [0; MAX_MESSAGE],
            arrivals: [Time::ZERO; MAX_MESSAGE],
            length: 0,
            end: 0,
            spent: 0,
            broken: 0,
        }
    }
}

impl Framer {
    /// Consumes `bytes` up to the end of the next message; `None` when all bytes are consumed.
    pub fn next<'a>(&'a mut self, bytes: &mut &[u8], arrival: Time) -> Option<Message<'a>> {
        let spent = core::mem::take(&mut self.spent);
        self.discard(spent);
        // Iterations: at most two for each buffered or new byte, because each iteration buffers or discards a
        // byte.
        loop {
            if !self.may_start_a_message() {
                self.discard(1);
            } else if self.end == 0 || self.length < self.end {
                self.fill(bytes, arrival)?;
            } else if self.checksum_holds() {
                break;
            } else {
                self.broken = self.broken.saturating_add(1);
                self.discard(1);
            }
        }
        self.spent = self.end;
        let [_, _, class, id, ..] = self.bytes;
        let payload = self.bytes.get(HEADER..self.end.checked_sub(2)?)?;
        Some(Message { class, id, payload, arrival: self.arrivals[0] })
    }

    /// Number of messages with an invalid checksum.
    pub fn broken(&self) -> u32 {
        self.broken
    }

    /// Takes the missing bytes of the message, or one byte of a header; `None` when there are no more.
    fn fill(&mut self, bytes: &mut &[u8], arrival: Time) -> Option<()> {
        if self.length == 0 {
            let start = bytes.iter().position(|byte| *byte == SYNC[0]);
            *bytes = bytes.get(start.unwrap_or(bytes.len())..)?;
        }
        let wanted = self.end.saturating_sub(self.length).max(1).min(bytes.len());
        let (taken, rest) =
            bytes.split_at_checked(wanted).filter(|(taken, _)| !taken.is_empty())?;
        let filled = self.length..self.length.saturating_add(wanted);
        let slots = self.bytes.get_mut(filled.clone())?;
        slots.iter_mut().zip(taken).for_each(|(slot, byte)| *slot = *byte);
        self.arrivals.get_mut(filled)?.fill(arrival);
        self.length += wanted;
        *bytes = rest;
        Some(())
    }

    /// Whether the buffered bytes begin like a known message; sets its end once the header is complete.
    fn may_start_a_message(&mut self) -> bool {
        if self.end != 0 {
            return true;
        }
        let seen = self.length.min(HEADER);
        let known = KNOWN.iter().find_map(|(class, id, lengths)| {
            lengths.iter().find(|length| {
                let [low, high] = length.to_le_bytes();
                let header = [SYNC[0], SYNC[1], *class, *id, low, high];
                header.get(..seen) == self.bytes.get(..seen)
            })
        });
        if let Some(length) = known.filter(|_| seen == HEADER) {
            self.end = HEADER + usize::from(*length) + 2;
        }
        known.is_some()
    }

    fn checksum_holds(&self) -> bool {
        let Some((message, sum)) = self.bytes.get(2..self.end).and_then(<[u8]>::split_last_chunk)
        else {
            return false;
        };
        checksum(message) == *sum
    }

    /// Drops bytes from the front and searches for a message again.
    fn discard(&mut self, count: usize) {
        let count = count.min(self.length);
        if let Some(bytes) = self.bytes.get_mut(..self.length) {
            move_to_front(bytes, count);
        }
        if let Some(arrivals) = self.arrivals.get_mut(..self.length) {
            move_to_front(arrivals, count);
        }
        self.length -= count;
        self.end = 0;
    }
}

/// The 8-bit Fletcher checksum, over class to payload.
pub(super) fn checksum(bytes: &[u8]) -> [u8; 2] {
    bytes.iter().fold([0, 0], |[a, b], byte| {
        let a = a.wrapping_add(*byte);
        [a, b.wrapping_add(a)]
    })
}
