//! From a stream of bytes to packets: framing, lock and resynchronisation.

use super::packet::{HEADER, Mode, Packet, PacketError};
use crate::buffer::move_to_front;

/// Bytes held at most. Two packets must fit; more only saves moving them to the front.
const CAPACITY: usize = 512;

/// The largest step of the temperature word between packets of one stream, counts; 1.7 °C. When the
/// line loses or gains a byte before that word, another byte takes its high half.
const TEMPERATURE_STEP: u16 = 32;

/// A packet found in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// The packet.
    pub packet: Packet,
    /// Bytes of the stream before its header.
    pub offset: u64,
    /// The packet's number. Where packets may be missing from the stream, numbers are left out, so
    /// consecutive numbers mean that nothing is known to be missing between two packets.
    pub sequence: u64,
}

/// What became of every byte that the decoder has seen.
///
/// Their sum is the length of the stream, less the bytes that still wait for the rest of a packet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketCounts {
    /// Packets delivered.
    pub packets: u64,
    /// Bytes passed over because no packet begins with them.
    pub bytes_without_header: u64,
    /// Header bytes passed over because the frame that they would begin has a wrong checksum.
    pub bytes_of_wrong_checksum: u64,
    /// Header bytes passed over because no second frame followed a first that had yet to be
    /// confirmed.
    pub bytes_unconfirmed: u64,
    /// Bytes thrown away by [`Decoder::expect_packet`] or [`Decoder::restart`].
    pub bytes_abandoned: u64,
    /// Packets announced by [`Decoder::expect_packet`] that had not come at the next announcement.
    pub packets_missing: u64,
    /// Times that a packet should have begun, and none did.
    pub locks_lost: u64,
    /// Packets held back until a second one followed, because their temperature had jumped.
    pub packets_held_back: u64,
}

impl PacketCounts {
    /// Bytes passed over or thrown away, for whatever reason.
    #[must_use]
    pub const fn bytes_lost(&self) -> u64 {
        self.bytes_without_header
            + self.bytes_of_wrong_checksum
            + self.bytes_unconfirmed
            + self.bytes_abandoned
    }
}

/// How much proof a frame needs before it counts as a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lock {
    /// Header and checksum of this frame and of the one behind it.
    Searching,
    /// Header and checksum; and a temperature near that of the packet before, if there was one.
    Locked { temperature: Option<u16> },
}

/// Finds the packets of one mode in a stream of bytes, whatever happened to the stream on its way.
///
/// The header byte is not unique and the checksum is short, so one good frame in a damaged stream
/// proves little. Without lock, a frame counts only if a second one follows it. With lock, header and
/// checksum are enough, so that a packet is delivered with its last byte. A line that loses or gains
/// one byte still passes that checksum once in 256 times; such a frame nearly always shows in the
/// temperature word, and a packet whose temperature jumps is held back until a second one follows.
/// After a failed check the search goes on one byte further, never a whole frame.
///
/// Two things still pass. A byte lost or gained behind the temperature word leaves a packet of true
/// measurements whose timer is wrong, once in 256 times; [`SampleClock`](super::SampleClock) limits
/// what that does. And a header byte gained inside a packet that begins with two header bytes moves
/// the words before it by one byte, and neither sum nor length shows it.
///
/// Memory is fixed, the work is bounded for each byte, and each byte is accounted for in the
/// [`PacketCounts`].
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
    /// Bytes of the stream before `start`.
    offset: u64,
    /// Number of the next packet.
    sequence: u64,
    /// Whether a packet was announced that has not come yet.
    expecting: bool,
    counts: PacketCounts,
}

impl Decoder {
    /// A decoder of packets of `mode`, for a stream that may begin anywhere.
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

    /// The next packet. Takes what it needs from the front of `bytes`; `None` means that all of them
    /// were taken and that no packet is complete.
    pub fn next_packet(&mut self, bytes: &mut &[u8]) -> Option<Received> {
        // Turns: at most two for each byte held or handed in: each takes in, skips or delivers one or more, as the
        // buffer is longer than the two packets that it may wait for.
        loop {
            match self.advance() {
                Advance::Found(packet) => return Some(self.deliver(packet)),
                Advance::Skipped => {}
                Advance::NeedMore if bytes.is_empty() => return None,
                Advance::NeedMore => self.fill(bytes),
            }
        }
    }

    /// Declares that the next byte begins a packet: the line was silent and one packet was asked for.
    /// Bytes still waiting for the rest of a packet are thrown away, and a packet announced earlier
    /// that did not come counts as missing.
    pub fn expect_packet(&mut self) {
        if self.expecting {
            self.sequence += 1;
            self.counts.packets_missing += 1;
        }
        self.expecting = true;
        self.abandon();
        self.lock = Lock::Locked { temperature: None };
    }

    /// Declares that the stream was interrupted: bytes still waiting for the rest of a packet are
    /// thrown away, and the next packet is searched for.
    pub fn restart(&mut self) {
        self.abandon();
        self.sequence += 1;
        self.expecting = false;
        self.lock = Lock::Searching;
    }

    /// Whether the decoder knows where packets begin.
    #[must_use]
    pub fn is_locked(&self) -> bool {
        self.lock != Lock::Searching
    }

    /// What became of the bytes so far.
    #[must_use]
    pub const fn counts(&self) -> &PacketCounts {
        &self.counts
    }

    fn waiting(&self) -> &[u8] {
        self.buffer.get(self.start..self.end).unwrap_or_default()
    }

    /// Decides about the first waiting byte: it begins a packet, does not, or more bytes are needed.
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

    /// Decides about a frame whose header and checksum hold: with lock by its temperature, without by
    /// the frame behind it.
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

    /// Moves what waits to the front of the buffer and as much of `bytes` behind it as fits.
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
    /// The first waiting byte begins this packet.
    Found(Packet),
    /// Bytes were skipped; look again.
    Skipped,
    /// The waiting bytes do not decide yet.
    NeedMore,
}
