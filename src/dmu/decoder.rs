//! Packets from a stream of bytes: framing, lock and resynchronisation.

use super::packet::{HEADER, Mode, Packet, PacketError};
use crate::buffer::move_to_front;

/// Size of the buffer, bytes. Two packets must fit; a larger buffer only reduces the moves of bytes to its front.
const CAPACITY: usize = 512;

/// Largest change of the temperature word between packets of one stream, counts; 1.7 °C. After a byte lost or gained
/// before this word, its high half is another byte. The word then changes by more than this limit.
const TEMPERATURE_STEP: u16 = 32;

/// A packet found in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// The packet.
    pub packet: Packet,
    /// Number of bytes in the stream before the packet's header.
    pub offset: u64,
    /// Number of the packet. Numbers are skipped where packets may be missing from the stream. Consecutive numbers
    /// mean that no packet is known to be missing between the two.
    pub sequence: u64,
}

/// Counts of packets, of skipped bytes and of events.
///
/// The bytes of the packets, the skipped bytes and the discarded bytes add up to the length of the stream. The bytes of
/// an incomplete packet are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketCounts {
    /// Packets delivered.
    pub packets: u64,
    /// Bytes skipped because no packet begins with them.
    pub bytes_without_header: u64,
    /// Header bytes skipped because the frame that begins with them has a wrong checksum.
    pub bytes_of_wrong_checksum: u64,
    /// Header bytes skipped because no second frame confirmed the frame that begins with them.
    pub bytes_unconfirmed: u64,
    /// Bytes discarded by [`Decoder::expect_packet`] or [`Decoder::restart`].
    pub bytes_abandoned: u64,
    /// Packets announced by [`Decoder::expect_packet`] that were missing at the next announcement.
    pub packets_missing: u64,
    /// Number of times that an expected packet start was missing.
    pub locks_lost: u64,
    /// Packets that were held back until a second packet followed, because of a temperature jump.
    pub packets_held_back: u64,
}

impl PacketCounts {
    /// Bytes skipped or discarded for any reason.
    #[must_use]
    pub const fn bytes_lost(&self) -> u64 {
        self.bytes_without_header
            + self.bytes_of_wrong_checksum
            + self.bytes_unconfirmed
            + self.bytes_abandoned
    }
}

/// Evidence that a frame needs to count as a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lock {
    /// Header and checksum of this frame and of the next one.
    Searching,
    /// Header and checksum of this frame, and a temperature near `temperature`, that of the previous packet. With
    /// `None`, the temperature is not checked.
    Locked { temperature: Option<u16> },
}

/// Finds the packets of one mode in a stream of bytes, which may be damaged.
///
/// The header byte is not unique and the checksum is short, so one valid frame in a damaged stream is weak evidence.
/// Without lock, a frame counts only if a second one follows it. With lock, header and checksum are enough, so that a
/// packet is delivered with its last byte.
///
/// A frame that lost or gained one byte still passes the checksum once in 256 times. In such a frame the temperature
/// word nearly always jumps. A packet whose temperature jumps is therefore held back until a second packet follows.
/// After a failed check the search continues one byte later, never a whole frame.
///
/// Two errors pass undetected. A byte lost or gained after the temperature word leaves a packet of true measurements
/// with a wrong timer, once in 256 times. [`SampleClock`](super::SampleClock) limits the effect. The second error needs
/// a packet whose first data byte equals the header byte. If the line adds another such byte later in the packet, the
/// words before the added byte are shifted by one byte. Checksum and length stay valid.
///
/// Memory is fixed, the work per byte is bounded, and [`PacketCounts`] accounts for each byte.
///
/// ```
/// use hovernav::dmu::{AnglePacket, Decoder, Mode, Packet};
/// let packet = AnglePacket { angular_rate: [0, -1, 2], ..Default::default() };
/// let stream = [packet.encode(), packet.encode()].concat();
///
/// let mut decoder = Decoder::new(Mode::Angle);
/// let mut bytes = &stream[..];
/// while let Some(received) = decoder.next_packet(&mut bytes) {
///     assert_eq!(received.packet, Packet::Angle(packet));
/// }
/// assert_eq!(decoder.counts().packets, 2);
/// ```
#[derive(Clone, Debug)]
pub struct Decoder {
    mode: Mode,
    lock: Lock,
    buffer: [u8; CAPACITY],
    start: usize,
    end: usize,
    /// Number of bytes in the stream before `start`.
    offset: u64,
    /// Number of the next packet.
    sequence: u64,
    /// Whether an announced packet has not arrived yet.
    expecting: bool,
    counts: PacketCounts,
}

impl Decoder {
    /// A decoder for packets of `mode`. The stream may begin anywhere, also inside a packet.
    #[must_use]
    pub const fn new(mode: Mode) -> Self {
        Self {
            mode,
            lock: Lock::Searching,
            buffer: [0; CAPACITY],
            start: 0,
            end: 0,
            offset: 0,
            sequence: 0,
            expecting: false,
            counts: PacketCounts {
                packets: 0,
                bytes_without_header: 0,
                bytes_of_wrong_checksum: 0,
                bytes_unconfirmed: 0,
                bytes_abandoned: 0,
                packets_missing: 0,
                locks_lost: 0,
                packets_held_back: 0,
            },
        }
    }

    /// The next packet. Takes the required bytes from the front of `bytes`. `None` means that all bytes were taken
    /// and no packet is complete.
    pub fn next_packet(&mut self, bytes: &mut &[u8]) -> Option<Received> {
        // Iterations: at most two for each buffered or new byte. Each iteration buffers, skips or delivers at
        // least one byte, because the buffer is longer than two packets.
        loop {
            match self.advance() {
                Advance::Found(packet) => return Some(self.deliver(packet)),
                Advance::Skipped => {}
                Advance::NeedMore if bytes.is_empty() => return None,
                Advance::NeedMore => self.fill(bytes),
            }
        }
    }

    /// Declares that the next byte begins a packet: the line was silent and one packet was requested. Bytes of an
    /// incomplete packet are discarded. An earlier announced packet that did not arrive counts as missing.
    pub fn expect_packet(&mut self) {
        if self.expecting {
            self.sequence += 1;
            self.counts.packets_missing += 1;
        }
        self.expecting = true;
        self.abandon();
        self.lock = Lock::Locked { temperature: None };
    }

    /// Declares that the stream was interrupted: bytes of an incomplete packet are discarded, and the search for the
    /// next packet starts again.
    pub fn restart(&mut self) {
        self.abandon();
        self.sequence += 1;
        self.expecting = false;
        self.lock = Lock::Searching;
    }

    /// Whether the decoder knows the position of packets in the stream.
    #[must_use]
    pub fn is_locked(&self) -> bool {
        self.lock != Lock::Searching
    }

    /// Counts of the bytes since the start.
    #[must_use]
    pub const fn counts(&self) -> &PacketCounts {
        &self.counts
    }

    fn waiting(&self) -> &[u8] {
        self.buffer.get(self.start..self.end).unwrap_or_default()
    }

    /// Classifies the first buffered byte: it begins a packet, it does not, or more bytes are needed.
    fn advance(&mut self) -> Advance {
        match Packet::decode(self.mode, self.waiting()) {
            Ok(packet) => self.confirm(packet),
            Err(PacketError::Length { .. }) => Advance::NeedMore,
            Err(PacketError::Header { .. }) => {
                let waiting = self.waiting();
                let run = waiting.iter().position(|&byte| byte == HEADER).unwrap_or(waiting.len());
                self.counts.bytes_without_header += run as u64;
                self.skip(run)
            }
            Err(PacketError::Checksum { .. }) => {
                self.counts.bytes_of_wrong_checksum += 1;
                self.skip(1)
            }
        }
    }

    /// Classifies a frame with a valid header and checksum: with lock by its temperature, without lock by the next
    /// frame.
    fn confirm(&mut self, packet: Packet) -> Advance {
        if let Lock::Locked { temperature } = self.lock {
            if temperature.is_none_or(|t| t.abs_diff(packet.temperature()) <= TEMPERATURE_STEP) {
                return Advance::Found(packet);
            }
            self.counts.packets_held_back += 1;
            self.lock = Lock::Searching;
        }
        let behind = self.waiting().get(self.mode.packet_length()..).unwrap_or_default();
        match Packet::decode(self.mode, behind) {
            Ok(_) => Advance::Found(packet),
            Err(PacketError::Length { .. }) => Advance::NeedMore,
            Err(_) => {
                self.counts.bytes_unconfirmed += 1;
                self.skip(1)
            }
        }
    }

    fn deliver(&mut self, packet: Packet) -> Received {
        let received = Received { packet, offset: self.offset, sequence: self.sequence };
        self.consume(self.mode.packet_length());
        self.lock = Lock::Locked { temperature: Some(packet.temperature()) };
        self.sequence += 1;
        self.expecting = false;
        self.counts.packets += 1;
        received
    }

    fn skip(&mut self, count: usize) -> Advance {
        if self.is_locked() {
            self.counts.locks_lost += 1;
            self.lock = Lock::Searching;
        }
        self.discard(count);
        Advance::Skipped
    }

    fn abandon(&mut self) {
        let waiting = self.waiting().len();
        self.counts.bytes_abandoned += waiting as u64;
        self.discard(waiting);
    }

    fn discard(&mut self, count: usize) {
        self.sequence += u64::from(count > 0);
        self.consume(count);
    }

    fn consume(&mut self, count: usize) {
        self.start = self.end.min(self.start + count);
        self.offset += count as u64;
    }

    /// Moves the buffered bytes to the front, and appends as many of `bytes` as fit.
    fn fill(&mut self, bytes: &mut &[u8]) {
        let end = self.end.min(CAPACITY);
        let start = self.start.min(end);
        if let Some(waiting) = self.buffer.get_mut(..end) {
            move_to_front(waiting, start);
        }
        let waiting = end - start;
        if let Some(room) = self.buffer.get_mut(waiting..) {
            let (taken, rest) = bytes.split_at(room.len().min(bytes.len()));
            room.iter_mut().zip(taken).for_each(|(slot, byte)| *slot = *byte);
            (self.start, self.end) = (0, waiting + taken.len());
            *bytes = rest;
        }
    }
}

enum Advance {
    /// The first buffered byte begins this packet.
    Found(Packet),
    /// Bytes were skipped: classify again.
    Skipped,
    /// The buffered bytes are not sufficient.
    NeedMore,
}
