//! Any bytes, in pieces of any size, through the complete processing of the inertial unit's bytes: decoder,
//! plausibility, clock, calibration, and the link around them.
//!
//! The first three bytes of an input choose the mode, the size of the pieces and when a packet is
//! announced; the rest is the stream.
#![no_main]

use hovernav::dmu::{
    Calibration, Decoder, Flow, Link, LinkAction, Mode, Packet, Plausibility, SampleClock,
};
use hovernav::time::Time;
use libfuzzer_sys::fuzz_target;

fn encode(packet: &Packet) -> ([u8; 30], usize) {
    let mut bytes = [0; 30];
    match packet {
        Packet::Angle(packet) => bytes = packet.encode(),
        Packet::Scaled(packet) => bytes[..24].copy_from_slice(&packet.encode()),
        Packet::Voltage(packet) => bytes[..24].copy_from_slice(&packet.encode()),
    }
    (bytes, if matches!(packet, Packet::Angle(_)) { 30 } else { 24 })
}

/// Decodes `stream` in pieces of `piece` bytes and asserts three properties. Each packet is at its reported offset in
/// the stream. Each byte is accounted for. Each time is later than the previous one.
fn decode(mode: Mode, piece: usize, announce: u8, stream: &[u8]) -> Decoder {
    let mut decoder = Decoder::new(mode);
    let mut plausibility = Plausibility::default();
    let mut clock = SampleClock::new(mode.transfer_time_s());
    let calibration = Calibration::new(200.0, 4.0).expect("a unit's ranges");
    let (mut arrival, mut previous, mut end, mut numbers) = (Time::ZERO, None, 0, 0..0);
    for (index, mut bytes) in stream.chunks(piece).enumerate() {
        if announce != 0 && index % usize::from(announce) == 0 {
            decoder.expect_packet();
        }
        arrival = arrival + bytes.len() as f64 * 2.6e-4;
        while let Some(received) = decoder.next_packet(&mut bytes) {
            let (encoded, length) = encode(&received.packet);
            let at = usize::try_from(received.offset).expect("within the input");
            assert!(at >= end && received.sequence >= numbers.end);
            assert_eq!(stream[at..at + length], encoded[..length]);
            end = at + length;
            numbers.end = received.sequence + 1;
            plausibility.check(&received.packet).for_each(|reason| {
                std::hint::black_box(reason);
            });
            if let Some(measurement) = calibration.measure(&received.packet) {
                assert!(measurement.angular_rate_radps.is_finite());
                assert!(measurement.specific_force_mps2.is_finite());
                assert!(measurement.magnetic_field_gauss.is_finite());
            }
            let timer = received.packet.timer();
            if let Ok(stamp) = clock.stamp(timer, received.sequence, arrival) {
                assert!(previous.is_none_or(|previous| stamp.time > previous));
                previous = Some(stamp.time);
            }
        }
    }
    let counts = decoder.counts();
    let done = counts.packets * mode.packet_length() as u64 + counts.bytes_lost();
    assert!(stream.len() as u64 - done < 2 * mode.packet_length() as u64);
    decoder
}

/// Passes the bytes as replies of an IMU: the link asks, waits and starts over, and always makes progress.
fn converse(mode: Mode, flow: Flow, piece: usize, stream: &[u8]) {
    let mut now = Time::ZERO;
    let mut link = Link::new(mode, flow, now);
    let mut pieces = stream.chunks(piece);
    let mut silent = false;
    for _ in 0..200 {
        match link.next_action(now) {
            LinkAction::Write(_) | LinkAction::Lost(_) => {}
            LinkAction::ReadUntil(time) => {
                assert!(time > now);
                // Bytes and silence alternate, so that replies can occur alone.
                now = if silent { time } else { time.min(now + 1e-3) };
                let mut bytes = if silent { &[] } else { pieces.next().unwrap_or_default() };
                while link.next_packet(&mut bytes, now).is_some() {}
                silent = !silent;
            }
        }
    }
}

fuzz_target!(|input: &[u8]| {
    let [mode, piece, announce, stream @ ..] = input else { return };
    let piece = usize::from(*piece).max(1);
    let flow = if mode & 4 == 0 { Flow::Continuous } else { Flow::Polled { cycle_s: 0.0303 } };
    let mode = [Mode::Angle, Mode::Scaled, Mode::Voltage][usize::from(mode % 3)];
    let pieces = decode(mode, piece, *announce, stream);
    if *announce == 0 {
        assert_eq!(pieces.counts(), decode(mode, stream.len().max(1), 0, stream).counts());
    }
    converse(mode, flow, piece, stream);
});
