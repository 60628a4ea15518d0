//! Packets from bytes: `10 id data… 10 03`, 0x10 doubled in the data.

use crate::time::Time;

/// Starts and, before [`ETX`], ends a packet.
pub(super) const DLE: u8 = 0x10;
/// Ends a packet after an odd number of [`DLE`].
pub(super) const ETX: u8 = 0x03;

/// Length of the longest accepted payload, bytes; the longest report that the decoder reads has 64.
pub const MAX_PAYLOAD: usize = 255;

/// A packet without its stuffing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packet<'a> {
    /// Kind of the report.
    pub id: u8,
    /// The data between id and end.
    pub payload: &'a [u8],
    /// Arrival of the packet's first byte.
    pub arrival: Time,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// Between packets, or without synchronisation.
    Outside,
    /// After a 0x10 outside a packet: an id is next.
    OutsideEscaped,
    /// In a packet's data.
    Inside,
    /// After a 0x10 in a packet's data.
    InsideEscaped,
}

/// Finds packets in a stream that arrives in any pieces.
///
/// A stream may begin inside a packet, with the second byte of a doubled 0x10. Data can then look like the start of a
/// packet. The first packet of a stream is therefore the least reliable.
#[derive(Clone, Debug)]
pub struct Framer {
    state: State,
    id: u8,
    payload: [u8; MAX_PAYLOAD],
    /// Length of the payload, bytes; bytes beyond the buffer's end are only counted.
    length: usize,
    arrival: Time,
    /// Arrival of the 0x10 outside a packet.
    escape_arrival: Time,
    broken: u32,
}

impl Default for Framer {
    fn default() -> Self {
        Self {
            state: State::Outside,
            id: 0,
            payload: [0; MAX_PAYLOAD],
            length: 0,
            arrival: Time::ZERO,
            escape_arrival: Time::ZERO,
            broken: 0,
        }
    }
}

impl Framer {
    /// Consumes `bytes`, which arrived at `arrival`, up to the end of the next packet; `None` when all bytes are
    /// consumed.
    pub fn next<'a>(&'a mut self, bytes: &mut &[u8], arrival: Time) -> Option<Packet<'a>> {
        // Iterations: at most one per byte, because each iteration takes one byte or more.
        while !self.advance(bytes, arrival)? {}
        let payload = self.payload.get(..self.length)?;
        Some(Packet { id: self.id, payload, arrival: self.arrival })
    }

    /// Number of packets that were cut off by the start of another packet, or were longer than any known packet.
    #[must_use]
    pub fn broken(&self) -> u32 {
        self.broken
    }

    /// Consumes a run of data or one byte of framing. Returns whether a packet is complete.
    fn advance(&mut self, bytes: &mut &[u8], arrival: Time) -> Option<bool> {
        let is_data = matches!(self.state, State::Outside | State::Inside);
        let run = if is_data { bytes.iter().position(|byte| *byte == DLE) } else { Some(0) };
        let (data, rest) = bytes.split_at_checked(run.unwrap_or(bytes.len()))?;
        if self.state == State::Inside {
            self.append(data);
        }
        let Some((byte, rest)) = rest.split_first() else {
            *bytes = &[];
            return None;
        };
        *bytes = rest;
        match (self.state, *byte) {
            (State::Outside, _) => {
                self.state = State::OutsideEscaped;
                self.escape_arrival = arrival;
            }
            (State::OutsideEscaped, DLE | ETX) => self.state = State::Outside,
            (State::OutsideEscaped, id) => self.start(id, self.escape_arrival),
            (State::Inside, _) => {
                self.state = State::InsideEscaped;
                self.escape_arrival = arrival;
            }
            (State::InsideEscaped, DLE) => {
                self.state = State::Inside;
                self.append(&[DLE]);
            }
            (State::InsideEscaped, ETX) => {
                self.state = State::Outside;
                let whole = self.length <= MAX_PAYLOAD;
                self.broken = self.broken.saturating_add(u32::from(!whole));
                return Some(whole);
            }
            (State::InsideEscaped, id) => {
                self.broken = self.broken.saturating_add(1);
                self.start(id, self.escape_arrival);
            }
        }
        Some(false)
    }

    fn start(&mut self, id: u8, arrival: Time) {
        self.state = State::Inside;
        self.id = id;
        self.length = 0;
        self.arrival = arrival;
    }

    fn append(&mut self, data: &[u8]) {
        let end = self.length.saturating_add(data.len());
        if let Some(room) = self.payload.get_mut(self.length..end) {
            room.iter_mut().zip(data).for_each(|(slot, byte)| *slot = *byte);
        }
        self.length = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn packets(pieces: &[&[u8]]) -> Vec<(u8, Vec<u8>)> {
        let mut framer = Framer::default();
        let mut found = Vec::new();
        for piece in pieces {
            let mut bytes = *piece;
            while let Some(packet) = framer.next(&mut bytes, Time::ZERO) {
                found.push((packet.id, packet.payload.to_vec()));
            }
            assert!(bytes.is_empty());
        }
        found
    }

    #[test]
    fn a_doubled_escape_is_data_even_before_the_end() {
        let wire = [0x10, 0x41, 1, 0x10, 0x10, 0x03, 2, 0x10, 0x10, 0x10, 0x03];
        assert_eq!(packets(&[&wire]), [(0x41, vec![1, 0x10, 0x03, 2, 0x10])]);
        for cut in 0..wire.len() {
            let (a, b) = wire.split_at(cut);
            assert_eq!(packets(&[a, b]), [(0x41, vec![1, 0x10, 0x03, 2, 0x10])], "cut at {cut}");
        }
    }

    #[test]
    fn a_packet_that_breaks_off_does_not_hide_the_next() {
        let wire = [0x10, 0x41, 1, 2, 0x10, 0x46, 0, 0, 0x10, 0x03];
        assert_eq!(packets(&[&wire]), [(0x46, vec![0, 0])]);
    }

    #[test]
    fn a_packet_longer_than_any_is_dropped_and_the_next_found() {
        let mut wire = vec![0x10, 0x41];
        wire.extend([7; MAX_PAYLOAD + 1]);
        wire.extend([0x10, 0x03, 0x10, 0x46, 0, 0, 0x10, 0x03]);
        assert_eq!(packets(&[&wire]), [(0x46, vec![0, 0])]);
        wire.remove(2);
        assert_eq!(packets(&[&wire]), [(0x41, vec![7; MAX_PAYLOAD]), (0x46, vec![0, 0])]);
    }

    #[test]
    fn a_packets_arrival_is_that_of_its_first_byte() {
        let mut framer = Framer::default();
        let wire = [0x10, 0x03, 0x10, 0x46, 0, 0, 0x10, 0x03];
        for (second, byte) in wire.iter().enumerate() {
            let mut bytes = core::slice::from_ref(byte);
            let now = Time::from_nanoseconds(second as i64);
            if let Some(packet) = framer.next(&mut bytes, now) {
                assert_eq!(packet.arrival, Time::from_nanoseconds(2));
                return;
            }
        }
        panic!("no packet");
    }
}
