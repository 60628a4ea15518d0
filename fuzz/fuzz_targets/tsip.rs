//! TSIP: any bytes, and any data in packets of the right length.
#![no_main]

mod receiver;

use hovernav::gps::Protocol;
use libfuzzer_sys::fuzz_target;

const PACKETS: [(u8, usize); 19] = [
    (0x41, 10),
    (0x42, 16),
    (0x43, 20),
    (0x45, 10),
    (0x46, 2),
    (0x4A, 20),
    (0x4A, 9),
    (0x4B, 3),
    (0x55, 4),
    (0x56, 20),
    (0x57, 8),
    (0x5C, 24),
    (0x6D, 17),
    (0x6D, 21),
    (0x82, 1),
    (0x83, 36),
    (0x84, 36),
    (0x8F, 56),
    (0x8F, 29),
];

fuzz_target!(|data: &[u8]| {
    receiver::check(Protocol::Tsip, data);
    receiver::check(Protocol::Tsip, &packets(data));
});

/// Packets filled with the data; one byte of it chooses each packet.
fn packets(mut data: &[u8]) -> Vec<u8> {
    let mut wire = Vec::new();
    while let Some((choice, rest)) = data.split_first() {
        let (id, length) = PACKETS[usize::from(*choice) % PACKETS.len()];
        let (payload, rest) = rest.split_at(length.min(rest.len()));
        wire.extend([0x10, id]);
        for (index, byte) in payload.iter().enumerate() {
            let byte = match (id, length, index) {
                (0x8F, 56, 0) => 0x20,
                (0x8F, 29, 0) => 0x23,
                (0x6D, 17, 0) => byte & 0x0F,
                (0x6D, 21, 0) => byte & 0x0F | 0x40,
                _ => *byte,
            };
            wire.push(byte);
            if byte == 0x10 {
                wire.push(0x10);
            }
        }
        wire.extend([0x10, 0x03]);
        data = rest;
    }
    wire
}
