//! Frames of MAVLink telemetry logs.

/// A MAVLink 2 frame after its time, µs.
pub fn frame(time_us: u64, sequence: u8, message: u32, seed: u8, payload: &[u8]) -> Vec<u8> {
    let id = message.to_le_bytes();
    let mut body = vec![payload.len() as u8, 0, 0, sequence, 1, 1, id[0], id[1], id[2]];
    body.extend(payload);
    let mut crc = 0xFFFFu16;
    for &byte in body.iter().chain([&seed]) {
        let mut tmp = byte ^ (crc as u8);
        tmp ^= tmp << 4;
        let tmp = u16::from(tmp);
        crc = (crc >> 8) ^ (tmp << 8) ^ (tmp << 3) ^ (tmp >> 4);
    }
    let mut bytes = time_us.to_be_bytes().to_vec();
    bytes.push(0xFD);
    bytes.extend(body);
    bytes.extend(crc.to_le_bytes());
    bytes
}
