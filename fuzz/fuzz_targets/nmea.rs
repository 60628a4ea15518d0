//! NMEA: any bytes, and any lines with a valid checksum.
#![no_main]

mod receiver;

use hovernav::gps::Protocol;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    receiver::check(Protocol::Nmea, data);
    receiver::check(Protocol::Nmea, &sentences(data));
});

/// Each line of the data as a sentence with a valid checksum; an existing checksum is replaced.
fn sentences(data: &[u8]) -> Vec<u8> {
    let mut wire = Vec::new();
    for line in data.split(|byte| *byte == b'\n' || *byte == b'$') {
        let body = line.split(|byte| *byte == b'*').next().unwrap_or_default();
        let sum = body.iter().fold(0, |sum, byte| sum ^ byte);
        wire.push(b'$');
        wire.extend(body);
        wire.extend(format!("*{sum:02X}\r\n").into_bytes());
    }
    wire
}
