//! Guarantees of the decoder for damaged streams.

use hovernav::dmu::{
    AnglePacket, Decoder, Mode, Packet, PacketCounts, PacketError, ScaledPacket, VoltagePacket,
};
use proptest::prelude::*;

use crate::generator::{Random, decode, decode_angle, encode, flight};

/// The packet without its timer: the bytes after the last measurement have the weakest protection.
fn measured(packet: &AnglePacket) -> AnglePacket {
    AnglePacket { timer: 0, temperature: 0, ..*packet }
}

fn false_packets<'a>(truth: &[AnglePacket], found: &'a [AnglePacket]) -> Vec<&'a AnglePacket> {
    found.iter().filter(|packet| !truth.contains(packet)).collect()
}

/// A copy of `bytes` without the byte at `at`.
fn without(bytes: &[u8], at: usize) -> Vec<u8> {
    [&bytes[..at], &bytes[at + 1..]].concat()
}

/// A copy of `bytes` with one byte inserted before `at`.
fn with(bytes: &[u8], at: usize, byte: u8) -> Vec<u8> {
    [&bytes[..at], &[byte], &bytes[at..]].concat()
}

#[test]
fn a_stream_met_in_mid_packet_is_whole_from_the_next_packet_on() {
    let truth = flight(40, 1);
    let stream = encode(&truth);
    for start in 0..stream.len() - 90 {
        let first = start.div_ceil(30);
        assert_eq!(decode_angle(&stream[start..]), truth[first..], "from byte {start}");
    }
}

#[test]
fn a_stream_cut_at_any_length_gives_every_packet_that_is_complete() {
    let truth = flight(8, 2);
    let stream = encode(&truth);
    for end in 0..=stream.len() {
        let complete = end / 30;
        // The first packet is accepted once a second one follows.
        let expected = if complete < 2 { 0 } else { complete };
        assert_eq!(decode_angle(&stream[..end]), truth[..expected], "up to byte {end}");
    }
}

#[test]
fn with_lock_a_packet_is_delivered_with_its_last_byte() {
    let truth = flight(20, 3);
    let stream = encode(&truth);
    let mut decoder = Decoder::new(Mode::Angle);
    let mut found = decode(&mut decoder, &stream[..60]).len();
    for (at, byte) in stream.iter().enumerate().skip(60) {
        found += decode(&mut decoder, &[*byte]).len();
        assert_eq!(found, (at + 1) / 30);
    }
}

#[test]
fn pieces_of_any_size_give_the_same_packets_and_the_same_counts() {
    let mut stream = encode(&flight(60, 4));
    let mut random = Random(4);
    for _ in 0..12 {
        stream.remove(random.below(stream.len()));
        stream.insert(random.below(stream.len()), random.byte());
    }
    let mut whole = Decoder::new(Mode::Angle);
    let expected = decode(&mut whole, &stream);
    for size in (1..130).chain([511, 512, 513, 1000]) {
        let mut decoder = Decoder::new(Mode::Angle);
        let found: Vec<Packet> =
            stream.chunks(size).flat_map(|piece| decode(&mut decoder, piece)).collect();
        assert_eq!(found, expected, "pieces of {size}");
        assert_eq!(decoder.counts(), whole.counts(), "pieces of {size}");
    }
}

#[test]
fn a_changed_byte_costs_its_own_packet_and_makes_no_false_one() {
    let truth = flight(60, 5);
    let stream = encode(&truth);
    for at in 90..stream.len() - 90 {
        for mask in [0x01, 0x80, 0xFF, 0x55, (at % 251) as u8 + 1] {
            let mut damaged = stream.clone();
            damaged[at] ^= mask;
            let mut expected = truth.clone();
            expected.remove(at / 30);
            assert_eq!(decode_angle(&damaged), expected, "byte {at} changed by {mask:#x}");
        }
    }
}

#[test]
fn a_lost_byte_costs_its_own_packet_at_most_and_falsifies_no_measurement() {
    let truth = flight(330, 6);
    let measurements: Vec<AnglePacket> = truth.iter().map(measured).collect();
    let mut wrong_timers = 0;
    for at in 90..330 * 30 - 90 {
        let first = at / 30 - 3;
        let window = &truth[first..(first + 8).min(330)];
        let found = decode_angle(&without(&encode(window), at - 30 * first));
        let wrong = false_packets(window, &found);
        assert!(wrong.iter().all(|packet| measurements.contains(&measured(packet))), "byte {at}");
        assert!(found.len() >= window.len() - 1, "byte {at}: {} left", found.len());
        wrong_timers += wrong.len();
    }
    // The additive checksum accepts one in 256 damaged packets. Only damage of the last two bytes before the checksum
    // has no other trace.
    assert!(wrong_timers <= 2 * 330 / 64, "{wrong_timers} wrong timers");
}

#[test]
fn an_added_byte_costs_its_own_packet_at_most_and_seldom_makes_a_false_one() {
    let truth = flight(100, 7);
    let (mut cases, mut falsified, mut headers, mut wrong_timers) = (0, 0, 0, 0);
    for at in 90..100 * 30 - 90 {
        let first = at / 30 - 3;
        let window = &truth[first..(first + 8).min(100)];
        let stream = encode(window);
        for byte in 0..=255 {
            let found = decode_angle(&with(&stream, at - 30 * first, byte));
            let wrong = false_packets(window, &found);
            assert!(wrong.len() <= 1, "byte {byte:#x} before {at}");
            assert!(found.len() >= window.len() - 1, "byte {byte:#x} before {at}");
            cases += 1;
            for packet in wrong {
                if window.iter().any(|truth| measured(truth) == measured(packet)) {
                    wrong_timers += 1;
                } else if byte == 0xFF {
                    headers += 1;
                } else {
                    falsified += 1;
                }
            }
        }
    }
    println!("{cases}: {wrong_timers} wrong timers, {falsified} and {headers} wrong measurements");
    // The checksum alone accepts one in 256 damaged packets.
    assert!(wrong_timers < cases / 3000, "{wrong_timers} of {cases}");
    assert!(falsified < cases / 20_000, "{falsified} of {cases}");
    // A header byte may be added to a packet whose first word begins with another header byte. The sum and the end are
    // then valid, one byte later.
    let beginnings = truth.iter().filter(|packet| packet.attitude[0] >> 8 == -1).count();
    assert!(headers <= 30 * beginnings, "{headers} of {beginnings} packets");
}

#[test]
fn of_twenty_thousand_packets_with_one_in_a_hundred_short_of_a_byte_none_is_false() {
    let truth = flight(20_000, 8);
    let mut random = Random(8);
    let (mut stream, mut intact) = (Vec::new(), Vec::new());
    for packet in &truth {
        let bytes = packet.encode();
        if random.below(100) == 0 {
            stream.extend(without(&bytes, random.below(30)));
        } else {
            stream.extend(bytes);
            intact.push(*packet);
        }
    }
    let found = decode_angle(&stream);
    let mut rest = intact.iter();
    for packet in &found {
        assert!(rest.any(|truth| truth == packet), "a false packet: {packet:?}");
    }
    // Intact packets with damage on both sides are lost in addition to the damaged packets.
    assert!(intact.len() - found.len() <= 6, "{} of {}", found.len(), intact.len());
}

#[test]
fn noise_bursts_make_no_packet_and_cost_only_what_they_hit() {
    for seed in 0..200 {
        let truth = flight(12, seed);
        let mut random = Random(seed);
        let length = 1 + random.below(3000);
        let noise: Vec<u8> = (0..length).map(|_| random.byte()).collect();
        let stream = [encode(&truth[..6]), noise[..length].to_vec(), encode(&truth[6..])].concat();
        let found = decode_angle(&stream);
        assert_eq!(found, truth, "seed {seed}: {length} bytes of noise");
    }
}

#[test]
fn half_an_hour_of_noise_makes_no_packet() {
    let mut random = Random(9);
    let mut decoder = Decoder::new(Mode::Angle);
    for _ in 0..1800 {
        let noise: Vec<u8> = (0..3840).map(|_| random.byte()).collect();
        assert_eq!(decode(&mut decoder, &noise), []);
    }
    assert!(!decoder.is_locked());
}

#[test]
fn packets_full_of_headers_and_replies_decode_like_any_other() {
    for word in [0xFF00, 0x00FF, 0xFFFF, 0x4148, 0x5243, 0xFF41, 0x48FF] {
        let signed = [word as u16 as i16; 3];
        let truth: Vec<AnglePacket> = (0..50)
            .map(|index: u16| AnglePacket {
                attitude: signed,
                angular_rate: signed,
                acceleration: signed,
                magnetic_field: signed,
                temperature: word as u16,
                timer: index.wrapping_mul(27_178),
            })
            .collect();
        let stream = encode(&truth);
        assert_eq!(decode_angle(&stream), truth, "{word:#06x}");
        for start in 0..60 {
            let found = decode_angle(&stream[start..]);
            assert_eq!(found[found.len() - 40..], truth[10..], "{word:#06x} from byte {start}");
        }
    }
}

#[test]
fn a_packet_whose_temperature_jumps_waits_for_the_next() {
    let mut truth = flight(10, 10);
    truth[5].temperature += 400;
    let stream = encode(&truth);
    let mut decoder = Decoder::new(Mode::Angle);
    assert_eq!(decode(&mut decoder, &stream[..6 * 30]).len(), 5);
    assert_eq!(decoder.counts().packets_held_back, 1);
    assert_eq!(decode(&mut decoder, &stream[6 * 30..]).len(), 5);
    assert_eq!(decoder.counts().packets, 10);
    assert_eq!(decoder.counts().bytes_lost(), 0);
}

#[test]
fn the_counts_say_what_was_lost_and_why() {
    let truth = flight(10, 11);
    let mut stream = encode(&truth);
    stream[4 * 30 + 12] ^= 0x04;
    let mut decoder = Decoder::new(Mode::Angle);
    decode(&mut decoder, &stream);
    let counts = *decoder.counts();
    assert_eq!((counts.packets, counts.locks_lost, counts.bytes_lost()), (9, 1, 30));
    assert!(counts.bytes_of_wrong_checksum >= 1);

    let mut decoder = Decoder::new(Mode::Angle);
    decode(&mut decoder, b"no header.");
    assert_eq!(
        *decoder.counts(),
        PacketCounts { bytes_without_header: 10, ..PacketCounts::default() }
    );
}

#[test]
fn an_announced_packet_needs_no_second_one() {
    let truth = flight(3, 12);
    let mut decoder = Decoder::new(Mode::Angle);
    let noise = [0xFF, 0x12, 0x34];
    decode(&mut decoder, &noise);
    for packet in &truth {
        decoder.expect_packet();
        assert_eq!(decode(&mut decoder, &packet.encode()), [Packet::Angle(*packet)]);
    }
    assert_eq!(decoder.counts().bytes_abandoned, 3);
    assert_eq!(decoder.counts().packets_missing, 0);
}

#[test]
fn numbers_are_skipped_where_packets_may_be_missing() {
    let truth = flight(9, 13);
    let sequences = |stream: &[u8]| {
        let (mut decoder, mut bytes) = (Decoder::new(Mode::Angle), stream);
        std::iter::from_fn(|| decoder.next_packet(&mut bytes))
            .map(|found| (found.offset, found.sequence))
            .collect::<Vec<_>>()
    };
    let whole = sequences(&encode(&truth));
    assert!(whole.windows(2).all(|pair| pair[1].1 == pair[0].1 + 1 && pair[1].0 == pair[0].0 + 30));

    let gap = sequences(&without(&encode(&truth), 100));
    let at = gap.iter().position(|&(offset, _)| offset == 119).unwrap();
    assert!(gap[at].1 > gap[at - 1].1 + 1);

    let mut decoder = Decoder::new(Mode::Angle);
    let numbers = [true, false, true, true].into_iter().filter_map(|answers| {
        decoder.expect_packet();
        let bytes = truth[0].encode();
        decoder.next_packet(&mut if answers { &bytes[..] } else { &[] }).map(|found| found.sequence)
    });
    let numbers: Vec<u64> = numbers.collect();
    assert!(numbers[1] > numbers[0] + 1 && numbers[2] == numbers[1] + 1, "{numbers:?}");
}

#[test]
fn bytes_that_are_no_packet_are_refused_with_the_cause() {
    let bytes = AnglePacket { attitude: [0x1234; 3], ..Default::default() }.encode();
    for length in 0..30 {
        let error = PacketError::Length { expected: 30, found: length };
        assert_eq!(AnglePacket::decode(&bytes[..length]), Err(error));
    }
    assert_eq!(AnglePacket::decode(&bytes[1..]), Err(PacketError::Header { found: bytes[1] }));
    let mut damaged = bytes;
    damaged[7] = damaged[7].wrapping_add(3);
    let expected = bytes[29].wrapping_add(3);
    let error = PacketError::Checksum { expected, found: bytes[29] };
    assert_eq!(AnglePacket::decode(&damaged), Err(error));
}

fn any_signed() -> impl Strategy<Value = [i16; 3]> {
    any::<[i16; 3]>()
}

prop_compose! {
    fn any_angle()(
        attitude in any_signed(), angular_rate in any_signed(), acceleration in any_signed(),
        magnetic_field in any_signed(), temperature in any::<u16>(), timer in any::<u16>(),
    ) -> AnglePacket {
        AnglePacket { attitude, angular_rate, acceleration, magnetic_field, temperature, timer }
    }
}

proptest! {
    #[test]
    fn every_packet_survives_the_wire(angle in any_angle(), word in any::<u16>()) {
        let AnglePacket { angular_rate, acceleration, magnetic_field, temperature, timer, .. } =
            angle;
        let scaled =
            ScaledPacket { angular_rate, acceleration, magnetic_field, temperature, timer };
        let voltage = VoltagePacket {
            angular_rate: [word, 1, 2], acceleration: [3, word, 4], magnetic_field: [5, 6, word],
            temperature, timer,
        };
        prop_assert_eq!(AnglePacket::decode(&angle.encode()), Ok(angle));
        prop_assert_eq!(ScaledPacket::decode(&scaled.encode()), Ok(scaled));
        prop_assert_eq!(VoltagePacket::decode(&voltage.encode()), Ok(voltage));
        for (mode, bytes, packet) in [
            (Mode::Angle, angle.encode().to_vec(), Packet::Angle(angle)),
            (Mode::Scaled, scaled.encode().to_vec(), Packet::Scaled(scaled)),
            (Mode::Voltage, voltage.encode().to_vec(), Packet::Voltage(voltage)),
        ] {
            prop_assert_eq!(bytes.len(), mode.packet_length());
            prop_assert_eq!(decode(&mut Decoder::new(mode), &bytes.repeat(2)), [packet; 2]);
        }
    }

    #[test]
    fn every_byte_of_any_stream_is_accounted_for(
        pieces in prop::collection::vec(prop_oneof![
            prop::collection::vec(any::<u8>(), 0..80),
            prop::collection::vec(Just(0xFF), 0..80),
            any_angle().prop_map(|packet| packet.encode().to_vec()),
        ], 0..40),
        announce in any::<u64>(),
        mode in prop::sample::select(vec![Mode::Angle, Mode::Scaled, Mode::Voltage]),
    ) {
        let mut decoder = Decoder::new(mode);
        let length = mode.packet_length() as u64;
        let (mut total, mut last) = (0, None);
        for (index, piece) in pieces.iter().enumerate() {
            if announce >> (index % 64) & 1 == 1 {
                decoder.expect_packet();
            }
            total += piece.len() as u64;
            let mut bytes = &piece[..];
            while let Some(found) = decoder.next_packet(&mut bytes) {
                prop_assert!(found.offset + length <= total);
                if let Some((offset, sequence)) = last {
                    prop_assert!(found.offset >= offset + length && found.sequence > sequence);
                }
                last = Some((found.offset, found.sequence));
            }
            let counts = decoder.counts();
            let waiting = total - length * counts.packets - counts.bytes_lost();
            prop_assert!(waiting < 2 * length, "{} bytes wait", waiting);
        }
    }
}
