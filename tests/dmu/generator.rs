//! Streams of a simulated flight, and the decoder applied to them.

use hovernav::dmu::{AnglePacket, Decoder, Mode, Packet};

/// Reproducible random numbers: SplitMix64.
#[derive(Clone)]
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn byte(&mut self) -> u8 {
        self.next() as u8
    }

    /// A whole number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// A number from −1 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// `count` packets of an unsteady hover: every word changes with the motion and with noise. Many are small and
/// negative, so that the header byte is frequent.
pub fn flight(count: usize, seed: u64) -> Vec<AnglePacket> {
    let mut random = Random(seed);
    (0..count)
        .map(|index| {
            let time_s = index as f64 / 33.0;
            let mut word = |mean: f64, swing: f64, rate: f64, noise: f64| {
                (mean + swing * (rate * time_s).sin() + noise * random.unit()) as i16
            };
            AnglePacket {
                attitude: [
                    word(0.0, 300.0, 1.7, 8.0),
                    word(-100.0, 500.0, 1.1, 8.0),
                    word(-9000.0, 4000.0, 0.3, 8.0),
                ],
                angular_rate: [
                    word(0.0, 250.0, 1.7, 60.0),
                    word(0.0, 250.0, 1.1, 60.0),
                    word(-20.0, 150.0, 0.3, 60.0),
                ],
                acceleration: [
                    word(-40.0, 60.0, 1.1, 200.0),
                    word(20.0, 60.0, 1.7, 200.0),
                    word(5461.0, 100.0, 2.0, 300.0),
                ],
                magnetic_field: [
                    word(3000.0, 500.0, 0.3, 4.0),
                    word(-30.0, 900.0, 0.3, 4.0),
                    word(7864.0, 60.0, 1.1, 4.0),
                ],
                temperature: word(1590.0, 5.0, 0.01, 5.0).cast_unsigned(),
                timer: 0u16.wrapping_sub((index as f64 * 38_358.4) as u64 as u16),
            }
        })
        .collect()
}

pub fn encode(packets: &[AnglePacket]) -> Vec<u8> {
    packets.iter().flat_map(AnglePacket::encode).collect()
}

/// All packets that `decoder` finds in `bytes`.
pub fn decode(decoder: &mut Decoder, mut bytes: &[u8]) -> Vec<Packet> {
    std::iter::from_fn(|| decoder.next_packet(&mut bytes)).map(|found| found.packet).collect()
}

/// All angle packets that a new decoder finds in `bytes`.
pub fn decode_angle(bytes: &[u8]) -> Vec<AnglePacket> {
    decode(&mut Decoder::new(Mode::Angle), bytes)
        .into_iter()
        .map(|packet| match packet {
            Packet::Angle(packet) => packet,
            other => panic!("{other:?}"),
        })
        .collect()
}
