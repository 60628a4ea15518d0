//! The heading of two antennas, from the bytes of NAV-RELPOSNED.

use approx::assert_abs_diff_eq;
use hovernav::gps::ubx::Decoder;
use hovernav::time::Time;

use hovernav_fly::devices::encode::ubx_message;

fn payload(flags: u32) -> Vec<u8> {
    let mut payload = vec![0; 64];
    payload[0] = 1;
    payload[4..8].copy_from_slice(&345_600_200u32.to_le_bytes());
    payload[20..24].copy_from_slice(&102i32.to_le_bytes());
    payload[24..28].copy_from_slice(&27_012_345i32.to_le_bytes());
    payload[35] = (-25i8) as u8;
    payload[52..56].copy_from_slice(&35_000u32.to_le_bytes());
    payload[60..].copy_from_slice(&flags.to_le_bytes());
    payload
}

/// A good fix, a valid relative position with fixed ambiguities, a moving base, a valid heading.
const GOOD: u32 = 0b1_0011_0111;

fn heading(payload: &[u8]) -> (Option<hovernav::gps::ReceiverHeading>, u32) {
    let mut decoder = Decoder::default();
    let wire = ubx_message(0x01, 0x3C, payload);
    assert!(decoder.read(&mut &wire[..], Time::ZERO + 7.0).is_none());
    (decoder.take_antenna_heading(), decoder.counts().damaged)
}

#[test]
fn nav_relposned_gives_heading_sigma_and_length() {
    let found = heading(&payload(GOOD)).0.unwrap();
    assert_eq!(found.time_of_week_ms, 345_600_200);
    assert_abs_diff_eq!(found.heading.heading_rad, -89.87655f64.to_radians(), epsilon = 1e-9);
    assert_abs_diff_eq!(found.heading.sigma_rad.unwrap(), 0.35f64.to_radians(), epsilon = 1e-12);
    assert_abs_diff_eq!(found.heading.length_m.unwrap(), 1.0175, epsilon = 1e-12);
    assert_eq!(found.heading.time, Time::ZERO + 7.0);
}

#[test]
fn a_heading_that_the_receiver_does_not_vouch_for_is_none() {
    // No fix; not valid; float ambiguities; no valid heading; no accuracy.
    for flags in [GOOD & !1, GOOD & !4, GOOD ^ 0b1_1000, GOOD & !0x100] {
        assert_eq!(heading(&payload(flags)), (None, 0), "{flags:b}");
    }
    let mut without_accuracy = payload(GOOD);
    without_accuracy[52..56].fill(0);
    assert_eq!(heading(&without_accuracy), (None, 0));
    let mut other_version = payload(GOOD);
    other_version[0] = 0;
    assert_eq!(heading(&other_version), (None, 1));
}

#[test]
fn a_heading_is_reported_once_and_does_no_harm_to_fixes() {
    let mut decoder = Decoder::default();
    let wire = [ubx_message(0x01, 0x3C, &payload(GOOD)), vec![0xB5, 0x62, 0x01]].concat();
    assert!(decoder.read(&mut &wire[..], Time::ZERO).is_none());
    assert!(decoder.take_antenna_heading().is_some());
    assert!(decoder.take_antenna_heading().is_none());
}
