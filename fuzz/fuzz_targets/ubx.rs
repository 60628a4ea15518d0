//! UBX: any bytes, and any payload in messages with a valid checksum.
#![no_main]

mod receiver;

use hovernav::gps::Protocol;
use libfuzzer_sys::fuzz_target;

const MESSAGES: [(u8, u8, usize); 10] = [
    (0x01, 0x02, 28),
    (0x01, 0x03, 16),
    (0x01, 0x04, 18),
    (0x01, 0x06, 52),
    (0x01, 0x07, 84),
    (0x01, 0x07, 92),
    (0x01, 0x12, 36),
    (0x01, 0x20, 16),
    (0x05, 0x00, 2),
    (0x05, 0x01, 2),
];

fuzz_target!(|data: &[u8]| {
    receiver::check(Protocol::Ubx, data);
    receiver::check(Protocol::Ubx, &messages(data));
});

/// Messages filled with the data; one byte of it chooses each message.
fn messages(mut data: &[u8]) -> Vec<u8> {
    let mut wire = Vec::new();
    while let Some((choice, rest)) = data.split_first() {
        let (class, id, length) = MESSAGES[usize::from(*choice) % MESSAGES.len()];
        let (payload, rest) = rest.split_at(length.min(rest.len()));
        let start = wire.len() + 2;
        wire.extend([0xB5, 0x62, class, id]);
        wire.extend((payload.len() as u16).to_le_bytes());
        wire.extend(payload);
        let (mut a, mut b) = (0u8, 0u8);
        for byte in &wire[start..] {
            a = a.wrapping_add(*byte);
            b = b.wrapping_add(a);
        }
        wire.extend([a, b]);
        data = rest;
    }
    wire
}
