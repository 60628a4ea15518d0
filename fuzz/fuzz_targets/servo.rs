//! Any bytes, through the complete processing of the bytes of the pulse-timing microcontroller.
//!
//! Delivered packets are in the stream, in order and byte for byte. Captured pulses are valid for a servo. Pieces of
//! any size give the same result.
#![no_main]

use hovernav::servo::packet::{Decoder, LENGTH, PacketCapture};
use hovernav::servo::{LONGEST_MS, SHORTEST_MS, SignalConfig};
use hovernav::time::Time;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|stream: &[u8]| {
    let mut decoder = Decoder::default();
    let mut end = 0;
    for (at, byte) in stream.iter().enumerate() {
        if let Some(received) = decoder.push(*byte) {
            let start = at + 1 - LENGTH;
            assert!(start >= end, "packets overlap");
            // The packet may contain widths whose bit is not set; such widths are not compared.
            let (sent, again) = (&stream[start..=at], received.packet.encode());
            assert_eq!((sent[2], sent[3]), (again[2], again[3]));
            for (_, at) in [(0, 4), (1, 6), (2, 8), (3, 10), (4, 12), (7, 14)]
                .into_iter()
                .filter(|(bit, _)| sent[3] & (1 << bit) != 0)
            {
                let width = at..at + 2;
                assert_eq!(sent[width.clone()], again[width]);
            }
            end = at + 1;
        }
    }
    let counts = decoder.counts();
    assert_eq!(counts.bytes, stream.len() as u64);
    assert!(counts.packets * LENGTH as u64 <= counts.bytes);

    let mut whole = PacketCapture::default();
    whole.receive(stream, Time::ZERO);
    let piece = stream.first().map_or(1, |first| usize::from(*first).max(1));
    let mut pieces = PacketCapture::default();
    for bytes in stream.chunks(piece) {
        pieces.receive(bytes, Time::ZERO);
    }
    assert_eq!(whole.pulses(), pieces.pulses());
    for (_, captured) in whole.pulses().channels.iter() {
        assert!(
            captured
                .pulse
                .is_none_or(|pulse| { (SHORTEST_MS..=LONGEST_MS).contains(&pulse.width_ms) })
        );
    }
    let _ = whole.pulses().signal(Time::ZERO, &SignalConfig::default());
});
