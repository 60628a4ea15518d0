//! Packet stream of a microcontroller that times the pilot's pulses: 18 bytes a packet, documented in
//! `docs/servo-packet.md`.

use crc::{CRC_16_IBM_3740, Crc};

use super::capture::{Captured, PilotPulses};
use crate::controls::Channels;
use crate::time::Time;

/// Length of a packet, bytes.
pub const LENGTH: usize = 18;

const SYNC: [u8; 2] = [0xA5, 0x5A];
const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
/// Number of ticks of 0.5 µs in a millisecond.
const TICKS_PER_MS: f64 = 2_000.0;

const FAILSAFE: u8 = 1 << 5;
const STARTED: u8 = 1 << 6;
const AUX: u8 = 1 << 7;

/// One packet: the pulses since the previous packet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServoPacket {
    /// Number of the packet: one more than that of the previous packet; 0 follows 255.
    pub sequence: u8,
    /// Width of each channel's last pulse in units of 0.5 µs, if a pulse ended since the previous packet.
    pub width_ticks: Channels<Option<u16>>,
    /// Width of the last pulse on the sixth channel, aux, in units of 0.5 µs. `None` without a pulse since the previous
    /// packet. Aux is a switch and has no servo.
    pub aux_ticks: Option<u16>,
    /// Whether the receiver reports the loss of the transmitter.
    pub receiver_failsafe: bool,
    /// Whether this is the first packet since the microcontroller started.
    pub started: bool,
}

impl ServoPacket {
    /// A width in the packet's unit, rounded to within 0.25 µs. Widths out of range saturate. NaN becomes 0, which is
    /// not a valid pulse.
    #[must_use]
    pub fn ticks(width_ms: f64) -> u16 {
        // A floating-point cast saturates, and turns NaN into zero.
        libm::round(width_ms * TICKS_PER_MS) as u16
    }

    /// Width of each channel, ms; `None` if the packet has no pulse of the channel.
    #[must_use]
    pub fn widths_ms(&self) -> Channels<Option<f64>> {
        self.width_ticks.map(|ticks| ticks.map(milliseconds))
    }

    /// Width of the aux channel, ms; `None` if the packet has no pulse of it.
    #[must_use]
    pub fn aux_ms(&self) -> Option<f64> {
        self.aux_ticks.map(milliseconds)
    }

    /// The packet's bytes.
    #[must_use]
    pub fn encode(&self) -> [u8; LENGTH] {
        let mut bytes = [0; LENGTH];
        let [s0, s1, sequence, status, widths @ .., aux_low, aux_high, _, _] = &mut bytes;
        [*s0, *s1] = SYNC;
        *sequence = self.sequence;
        *status |= if self.receiver_failsafe { FAILSAFE } else { 0 };
        *status |= if self.started { STARTED } else { 0 };
        let pairs = widths.as_chunks_mut().0.iter_mut();
        for (bit, (pair, ticks)) in pairs.zip(self.width_ticks.to_array()).enumerate() {
            *pair = ticks.unwrap_or(0).to_le_bytes();
            *status |= u8::from(ticks.is_some()) << bit;
        }
        [*aux_low, *aux_high] = self.aux_ticks.unwrap_or(0).to_le_bytes();
        *status |= if self.aux_ticks.is_some() { AUX } else { 0 };
        let [_, _, body @ .., high, low] = &mut bytes;
        [*high, *low] = CRC.checksum(body).to_be_bytes();
        bytes
    }

    /// The packet in 18 bytes; `None` unless the sync bytes and the checksum are valid.
    #[must_use]
    pub fn decode(bytes: &[u8; LENGTH]) -> Option<Self> {
        let [s0, s1, body @ .., high, low] = bytes;
        if [*s0, *s1] != SYNC || CRC.checksum(body) != u16::from_be_bytes([*high, *low]) {
            return None;
        }
        let [sequence, status, a0, a1, b0, b1, c0, c1, d0, d1, e0, e1, aux @ ..] = *body;
        let words = [[a0, a1], [b0, b1], [c0, c1], [d0, d1], [e0, e1]].map(u16::from_le_bytes);
        let fresh = [0, 1, 2, 3, 4].map(|bit| status & (1 << bit) != 0);
        Some(Self {
            sequence,
            width_ticks: Channels::from(fresh)
                .zip(Channels::from(words))
                .map(|(fresh, word)| fresh.then_some(word)),
            aux_ticks: (status & AUX != 0).then_some(u16::from_le_bytes(aux)),
            receiver_failsafe: status & FAILSAFE != 0,
            started: status & STARTED != 0,
        })
    }
}

fn milliseconds(ticks: u16) -> f64 {
    f64::from(ticks) / TICKS_PER_MS
}

/// Counts of the stream since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PacketCounts {
    /// Bytes received.
    pub bytes: u64,
    /// Packets delivered.
    pub packets: u64,
    /// Missing packets, from the gaps in the packet numbers.
    pub missing: u64,
}

impl PacketCounts {
    /// Number of bytes that belong to no packet, or to an incomplete packet.
    #[must_use]
    pub const fn bytes_outside_packets(&self) -> u64 {
        self.bytes - self.packets * LENGTH as u64
    }
}

/// A packet found in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received {
    /// The packet.
    pub packet: ServoPacket,
    /// Number of packets missing before this packet, according to the packet numbers.
    pub missing: u8,
}

/// Finds the packets in a stream of bytes, which may be damaged.
///
/// At every byte it checks the last eighteen bytes. A complete packet is found with its last byte, regardless of
/// earlier bytes, and the work per byte is constant. Sync bytes and checksum have 32 bits. Noise therefore passes the
/// check once in 4 × 10⁹ bytes. A packet that lost or gained a byte passes once in 65 536 packets. A packet with up to
/// two wrong neighbouring bytes never passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Decoder {
    /// The bytes since the last packet, the latest at the end.
    window: [u8; LENGTH],
    /// Number of the previous packet.
    before: Option<u8>,
    counts: PacketCounts,
}

impl Decoder {
    /// Processes one byte; returns the packet that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Received> {
        self.counts.bytes += 1;
        let [_, kept @ ..] = self.window;
        let [before @ .., latest] = &mut self.window;
        (*before, *latest) = (kept, byte);
        let packet = ServoPacket::decode(&self.window)?;
        self.window = [0; LENGTH];
        let missing = self.before.map_or(0, |before| {
            if packet.started { 0 } else { packet.sequence.wrapping_sub(before).wrapping_sub(1) }
        });
        self.before = Some(packet.sequence);
        self.counts.packets += 1;
        self.counts.missing += u64::from(missing);
        Some(Received { packet, missing })
    }

    /// Counts of the stream since the start.
    #[must_use]
    pub const fn counts(&self) -> &PacketCounts {
        &self.counts
    }
}

/// The pilot's pulses from a packet stream. It reads no input itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PacketCapture {
    decoder: Decoder,
    pulses: PilotPulses,
}

impl PacketCapture {
    /// Processes bytes that arrived at `arrival`, which becomes the time of the pulses in them.
    ///
    /// A missing packet counts as an error on every channel, an impossible width on its own channel.
    pub fn receive(&mut self, bytes: &[u8], arrival: Time) -> &PilotPulses {
        for byte in bytes {
            if let Some(received) = self.decoder.push(*byte) {
                self.take(&received, arrival);
            }
        }
        &self.pulses
    }

    /// State of the pulses.
    #[must_use]
    pub const fn pulses(&self) -> &PilotPulses {
        &self.pulses
    }

    /// Counts of the stream since the start.
    #[must_use]
    pub const fn counts(&self) -> &PacketCounts {
        self.decoder.counts()
    }

    fn take(&mut self, received: &Received, arrival: Time) {
        let packet = &received.packet;
        self.pulses.receiver_failsafe = packet.receiver_failsafe;
        let take = |mut captured: Captured, width_ms: Option<f64>| {
            captured.errors = captured.errors.saturating_add(u32::from(received.missing));
            if let Some(width_ms) = width_ms {
                // The fault is counted on its channel; the packet's other channels are still valid.
                let _ = captured.push(width_ms, arrival);
            }
            captured
        };
        self.pulses.aux = take(self.pulses.aux, packet.aux_ms());
        self.pulses.channels = self
            .pulses
            .channels
            .zip(packet.widths_ms())
            .map(|(captured, width_ms)| take(captured, width_ms));
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    use super::*;

    fn any_packet() -> impl Strategy<Value = ServoPacket> {
        let channel = prop::option::of(any::<u16>());
        (any::<u8>(), prop::array::uniform6(channel), any::<bool>(), any::<bool>()).prop_map(
            |(sequence, [widths @ .., aux_ticks], receiver_failsafe, started)| ServoPacket {
                sequence,
                width_ticks: Channels::from(widths),
                aux_ticks,
                receiver_failsafe,
                started,
            },
        )
    }

    fn decode(stream: &[u8]) -> Vec<ServoPacket> {
        let mut decoder = Decoder::default();
        let packets: Vec<_> =
            stream.iter().filter_map(|byte| decoder.push(*byte)).map(|r| r.packet).collect();
        let outside = (stream.len() - LENGTH * packets.len()) as u64;
        assert_eq!(decoder.counts().bytes_outside_packets(), outside);
        packets
    }

    fn stream(packets: &[ServoPacket]) -> Vec<u8> {
        packets.iter().flat_map(ServoPacket::encode).collect()
    }

    /// Whether `found` is `sent` with some packets missing.
    fn is_part_of(found: &[ServoPacket], sent: &[ServoPacket]) -> bool {
        let mut sent = sent.iter();
        found.iter().all(|packet| sent.any(|candidate| candidate == packet))
    }

    #[test]
    fn the_layout_is_that_of_the_documentation() {
        let packet = ServoPacket {
            sequence: 7,
            width_ticks: Channels {
                throttle: Some(2_400),
                collective: Some(3_000),
                longitudinal: None,
                lateral: Some(3_110),
                pedal: Some(2_955),
            },
            aux_ticks: Some(3_800),
            receiver_failsafe: true,
            started: false,
        };
        let bytes = packet.encode();
        let shown: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
        assert_eq!(shown.join(" "), "A5 5A 07 BB 60 09 B8 0B 00 00 26 0C 8B 0B D8 0E 20 C3");
        let page = include_str!("../../docs/servo-packet.md");
        assert!(page.contains(&shown.join(" ")));
    }

    proptest! {
        #[test]
        fn packets_survive_the_stream(
            packets in prop::collection::vec(any_packet(), 0..6),
            noise in prop::collection::vec(any::<u8>(), 0..40),
        ) {
            prop_assert_eq!(decode(&stream(&packets)), packets.clone());
            // Noise can only cost the first packet, and only if the last byte of the noise equals a sync byte.
            let found = decode(&[noise, stream(&packets)].concat());
            prop_assert!(is_part_of(&found, &packets) && found.len() + 1 >= packets.len());
        }

        #[test]
        fn wrong_bytes_cost_the_packets_that_they_are_in_and_no_other(
            packets in prop::collection::vec(any_packet(), 3),
            flips in any::<[u8; 2]>(),
            place in any::<prop::sample::Index>(),
        ) {
            let mut bytes = stream(&packets);
            let place = place.index(bytes.len() - 1);
            bytes[place] ^= flips[0];
            bytes[place + 1] ^= flips[1];
            let found = decode(&bytes);
            let harmed = (place..=place + 1)
                .filter(|at| flips[at - place] != 0)
                .map(|at| at / LENGTH)
                .collect::<std::collections::BTreeSet<_>>();
            let unharmed: Vec<_> = (0..3).filter(|n| !harmed.contains(n)).map(|n| packets[n]).collect();
            prop_assert_eq!(found, unharmed);
        }

        #[test]
        fn widths_keep_their_half_microsecond(width_ms in 0.0f64..32.7) {
            let ticks = ServoPacket::ticks(width_ms);
            prop_assert!((f64::from(ticks) / 2_000.0 - width_ms).abs() <= 0.000_25 + 1e-12);
        }
    }

    /// The checksum is linear, so the result for this packet holds for all.
    #[test]
    fn no_one_byte_and_no_two_neighbouring_bytes_can_be_wrong_unnoticed() {
        let bytes = ServoPacket::default().encode();
        for place in 0..LENGTH - 1 {
            for flips in 1..=u16::MAX {
                let mut damaged = bytes;
                damaged[place] ^= flips as u8;
                damaged[place + 1] ^= (flips >> 8) as u8;
                assert_eq!(ServoPacket::decode(&damaged), None, "{flips:04x} at {place}");
            }
        }
    }

    /// The test damages packets in 65 536 deterministic ways. The checksum passes one in 65 536, so more than a few
    /// passes indicate another error.
    #[test]
    fn a_byte_lost_or_gained_passes_no_more_often_than_the_checksum_allows() {
        let mut state = 1u64;
        let mut random = || {
            // Steele, Lea, Flood (2014), Fast splittable pseudorandom number generators: SplitMix64.
            state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            z ^ (z >> 31)
        };
        let (mut false_packets, mut lost) = (0, 0);
        for damage in 0..65_536 {
            let packets: [_; 3] = std::array::from_fn(|n| ServoPacket {
                sequence: n as u8,
                width_ticks: Channels::from_fn(|_| Some(2_000 + (random() % 2_000) as u16)),
                ..ServoPacket::default()
            });
            let mut bytes = stream(&packets);
            let place = LENGTH + (random() % LENGTH as u64) as usize;
            if damage % 2 == 0 {
                bytes.remove(place);
            } else {
                bytes.insert(place, random() as u8);
            }
            let found = decode(&bytes);
            false_packets += found.iter().filter(|packet| !packets.contains(packet)).count();
            lost += 3 - packets.iter().filter(|packet| found.contains(packet)).count();
        }
        assert!(false_packets <= 6, "{false_packets} false packets");
        assert!(lost <= 65_536 + 6, "{lost} packets lost to 65 536 damages");
    }

    #[test]
    fn missing_packets_show_by_their_numbers_and_a_restart_is_not_a_loss() {
        let packet = |sequence, started| ServoPacket { sequence, started, ..Default::default() };
        let mut decoder = Decoder::default();
        let mut missing = Vec::new();
        for packet in [packet(254, false), packet(255, false), packet(2, false), packet(0, true)] {
            let bytes = packet.encode();
            missing.extend(bytes.iter().filter_map(|byte| decoder.push(*byte)).map(|r| r.missing));
        }
        assert_eq!(missing, [0, 0, 2, 0]);
        assert_eq!(decoder.counts().missing, 2);
    }

    #[test]
    fn pulses_age_while_packets_stay_away_or_tell_of_none() {
        let at = |seconds| Time::from_seconds(seconds);
        let width = |ticks| ServoPacket {
            width_ticks: Channels { lateral: ticks, ..Default::default() },
            started: true,
            ..Default::default()
        };
        let mut capture = PacketCapture::default();
        capture.receive(&width(Some(3_100)).encode(), at(1.0));
        capture.receive(&width(None).encode(), at(1.02));
        let pulses = *capture.receive(&width(Some(20)).encode(), at(1.04));
        assert_eq!(pulses.channels.lateral.fresh_ms(at(1.04), 0.1), Some(1.55));
        assert_abs_diff_eq!(pulses.channels.lateral.age_s(at(1.04)).unwrap(), 0.04, epsilon = 1e-9);
        assert_eq!((pulses.channels.lateral.errors, pulses.channels.pedal.errors), (1, 0));
    }
}
