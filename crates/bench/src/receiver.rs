//! A fix as a message of a u-blox receiver: UBX-NAV-PVT.
//!
//! # Source
//! u-blox, *M8 Receiver description including protocol specification*, UBX-13003221, section UBX-NAV-PVT.

use hovernav::gps::Fix;

const PAYLOAD: usize = 92;
/// Sync characters, class, identifier and length, then payload and checksum.
pub const LENGTH: usize = 6 + PAYLOAD + 2;

/// The message of `fix` at second `second` of a day.
pub fn nav_pvt(fix: &Fix, second: u64) -> [u8; LENGTH] {
    let [north, east] = fix.horizontal_velocity_mps.unwrap_or_default();
    let down = fix.down_velocity_mps.unwrap_or_default();
    let mm = |metres: f64| (metres * 1e3).round() as i32;
    let degrees = |degrees: f64| (degrees * 1e7).round() as i32;
    let clock = [second / 3_600 % 24, second / 60 % 60, second % 60].map(|part| part as u8);

    let mut bytes = [0; LENGTH];
    let mut put = |at: usize, value: &[u8]| {
        if let Some(place) = bytes.get_mut(at..at + value.len()) {
            place.copy_from_slice(value);
        }
    };
    put(0, &[0xB5, 0x62, 0x01, 0x07, PAYLOAD as u8, 0]);
    let body = 6;
    put(body, &((second % 604_800 * 1_000) as u32).to_le_bytes());
    put(body + 4, &2025_u16.to_le_bytes());
    put(body + 6, &[6, 1, clock[0], clock[1], clock[2], 0x07]);
    put(body + 20, &[3, 0x01, 0, 12]);
    put(body + 24, &degrees(fix.position.longitude_deg()).to_le_bytes());
    put(body + 28, &degrees(fix.position.latitude_deg()).to_le_bytes());
    put(body + 32, &mm(fix.position.height_m).to_le_bytes());
    put(body + 36, &mm(fix.position.height_m - 47.0).to_le_bytes());
    put(body + 40, &mm(0.8).to_le_bytes());
    put(body + 44, &mm(1.5).to_le_bytes());
    put(body + 48, &mm(north).to_le_bytes());
    put(body + 52, &mm(east).to_le_bytes());
    put(body + 56, &mm(down).to_le_bytes());
    put(body + 60, &mm(north.hypot(east)).to_le_bytes());
    put(body + 68, &mm(0.1).to_le_bytes());
    put(body + 76, &150_u16.to_le_bytes());

    let (mut a, mut b) = (0_u8, 0_u8);
    for byte in bytes.iter().skip(2).take(4 + PAYLOAD) {
        a = a.wrapping_add(*byte);
        b = b.wrapping_add(a);
    }
    let [.., first, second] = &mut bytes;
    (*first, *second) = (a, b);
    bytes
}
