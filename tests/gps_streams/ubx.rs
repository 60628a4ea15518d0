//! UBX messages that give a fix, messages that do not, and the configuration of a receiver.

use approx::assert_abs_diff_eq;
use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav::gps::ubx::{Configuration, ConfigurationError, Decoder};
use hovernav::gps::{Correction, Dimension, Protocol, ReceiverFix, ReceiverTime};
use hovernav::time::Time;

use crate::fixes;
use hovernav_fly::devices::encode;
use hovernav_fly::devices::encode::{Epoch, ubx_message};

fn read(wire: &[u8]) -> Vec<ReceiverFix> {
    fixes(Protocol::Ubx, wire)
}

/// A NAV-PVT with a changed payload and a valid checksum.
fn changed(change: impl Fn(&mut Vec<u8>)) -> Vec<u8> {
    let wire = encode::ubx_pvt(&Epoch::flying(0));
    let mut payload = wire[6..wire.len() - 2].to_vec();
    change(&mut payload);
    ubx_message(0x01, 0x07, &payload)
}

fn solution(epoch: &Epoch, fix_type: u8, flags: u8) -> Vec<u8> {
    let place =
        Geodetic::from_degrees(epoch.latitude_deg, epoch.longitude_deg, epoch.height_m).unwrap();
    let velocity = place.ecef_to_ned().inverse() * Vector::from(epoch.velocity_ned_mps.unwrap());
    let centi = |value: f64| ((value * 100.0).round() as i32).to_le_bytes();
    let mut payload = epoch.time_of_week_ms.to_le_bytes().to_vec();
    payload.extend((-5_000i32).to_le_bytes());
    payload.extend(encode::WEEK.to_le_bytes());
    payload.extend([fix_type, flags]);
    for value in place.to_ecef().to_array() {
        payload.extend(centi(value));
    }
    payload.extend(centi(2.8));
    for value in velocity.to_array() {
        payload.extend(centi(value));
    }
    payload.extend(centi(0.17));
    payload.extend(260u16.to_le_bytes());
    payload.extend([0, epoch.satellites, 0, 0, 0, 0]);
    ubx_message(0x01, 0x06, &payload)
}

#[test]
fn what_nav_pvt_does_not_vouch_for_is_no_fix() {
    assert_eq!(read(&changed(|_| {})).len(), 1);
    for fix_type in [0, 1, 5, 6, 255] {
        assert_eq!(read(&changed(|payload| payload[20] = fix_type)), [], "type {fix_type}");
    }
    assert_eq!(read(&changed(|payload| payload[21] = 0)), [], "gnssFixOK not set");
    assert_eq!(read(&changed(|payload| payload[78] = 1)), [], "invalidLlh set");
}

#[test]
fn nav_pvt_reports_dimension_and_correction() {
    let fix = |fix_type: u8, flags: u8| {
        read(&changed(|payload| payload[20..22].copy_from_slice(&[fix_type, flags])))[0]
    };
    assert_eq!(fix(2, 0x01).dimension, Some(Dimension::TwoD));
    assert_eq!(fix(3, 0x01).correction, Some(Correction::None));
    assert_eq!(fix(3, 0x03).correction, Some(Correction::Differential));
    assert_eq!(fix(3, 0x43).correction, Some(Correction::RtkFloat));
    assert_eq!(fix(4, 0x83).correction, Some(Correction::RtkFixed));
    assert_eq!(fix(4, 0x83).dimension, Some(Dimension::ThreeD));
}

#[test]
fn values_that_cannot_be_are_refused() {
    let put = |offset: usize, value: i32| {
        read(&changed(|payload| payload[offset..offset + 4].copy_from_slice(&value.to_le_bytes())))
    };
    assert_eq!(put(28, 900_000_001), [], "latitude");
    assert_eq!(put(24, 1_800_000_001), [], "longitude");
    assert_eq!(put(32, 200_000_000), [], "height");
    assert_eq!(put(48, 700_000), [], "velocity");
}

#[test]
fn an_accuracy_of_zero_is_an_unknown_one() {
    let fix = read(&changed(|payload| payload[40..44].fill(0)))[0];
    assert_eq!(fix.position_sigma_m, None);
    assert!(fix.velocity_sigma_mps.is_some());
}

#[test]
fn a_date_that_is_not_valid_leaves_the_week_unknown() {
    let time = |valid: u8, year: u16| {
        let wire = changed(|payload| {
            payload[4..6].copy_from_slice(&year.to_le_bytes());
            payload[11] = valid;
        });
        read(&wire)[0].time
    };
    let week = |time| match time {
        Some(ReceiverTime::Gps { week, time_of_week_ns: 446_988_000_000_000, .. }) => week,
        other => panic!("{other:?}"),
    };
    assert_eq!(week(time(0x37, 2_026)), Some(encode::WEEK));
    assert_eq!(week(time(0x30, 2_026)), None);
    assert_eq!(week(time(0x37, 2_025)), None);
}

#[test]
fn the_short_nav_pvt_of_protocol_14_is_read() {
    let long = read(&changed(|_| {}));
    assert_eq!(read(&changed(|payload| payload.truncate(84))), long);
}

#[test]
fn nav_sol_alone_is_a_fix_in_centimetres() {
    let epoch = Epoch::flying(2);
    let fix = read(&solution(&epoch, 3, 0x0D))[0];
    let place =
        Geodetic::from_degrees(epoch.latitude_deg, epoch.longitude_deg, epoch.height_m).unwrap();
    let found = fix.at(Time::ZERO).unwrap();
    assert!(found.position.displacement_from(&place).norm() < 0.01);
    assert!(
        (found.velocity_mps().unwrap() - Vector::from(epoch.velocity_ned_mps.unwrap())).norm()
            < 0.01
    );
    assert!((fix.position_sigma_m.unwrap() - Vector::new(2.8, 2.8, 2.8)).norm() < 1e-12);
    assert_eq!(
        fix.time,
        Some(ReceiverTime::Gps {
            week: Some(encode::WEEK),
            time_of_week_ns: 446_989_999_995_000,
            leap_seconds: None
        })
    );
    for (fix_type, flags) in [(0, 0x0D), (1, 0x0D), (5, 0x0D), (3, 0x0C)] {
        assert_eq!(read(&solution(&epoch, fix_type, flags)), [], "{fix_type} {flags:#x}");
    }
}

#[test]
fn the_finer_position_and_velocity_stay_in_whatever_order_they_come() {
    let epoch = Epoch::flying(2);
    let older = encode::ubx_older(&epoch);
    for wire in [
        [solution(&epoch, 3, 0x0D), older.clone()].concat(),
        [older.clone(), solution(&epoch, 3, 0x0D)].concat(),
    ] {
        let fix = read(&wire)[0];
        assert_eq!(read(&wire).len(), 1);
        assert!((fix.position_sigma_m.unwrap() - Vector::new(1.1, 1.1, 1.6)).norm() < 1e-12);
        let [north, east] = fix.horizontal_velocity_mps.unwrap();
        assert_abs_diff_eq!(north, 4.9, epsilon = 1e-12);
        assert_abs_diff_eq!(east, -5.6, epsilon = 1e-12);
        assert_eq!(fix.satellites, Some(epoch.satellites));
    }
    // If either of the two reports no fix, there is no fix.
    assert_eq!(read(&[solution(&epoch, 0, 0x0C), older].concat()), []);
}

#[test]
fn a_position_that_no_message_vouches_for_is_no_fix() {
    let older = encode::ubx_older(&Epoch::flying(0));
    let position = &older[..36];
    assert_eq!(read(position), []);
    assert_eq!(read(&older[..36 + 24]).len(), 1, "with NAV-STATUS");
}

#[test]
fn where_nav_pvt_comes_too_it_is_the_fix_and_the_only_one() {
    let mut wire = Vec::new();
    for index in 0..6 {
        let epoch = Epoch::flying(index);
        wire.extend(solution(&epoch, 3, 0x0D));
        wire.extend(encode::ubx_pvt(&epoch));
        wire.extend(encode::ubx_older(&Epoch { horizontal_sigma_m: 2.2, ..epoch }));
    }
    let fixes = read(&wire);
    assert_eq!(fixes.len(), 6);
    for fix in fixes {
        assert_eq!(fix.position_sigma_m.unwrap().to_array(), [1.1, 1.1, 1.6]);
    }
}

#[test]
fn a_message_that_starts_inside_a_damaged_one_is_found_with_its_own_arrival() {
    let whole = encode::ubx_pvt(&Epoch::flying(0));
    let mut decoder = Decoder::default();
    // The first message is cut off after 50 bytes.
    assert_eq!(decoder.read(&mut &whole[..50], Time::ZERO), None);
    assert_eq!(decoder.read(&mut &whole[..60], Time::ZERO + 1.0), None);
    let fix = decoder.read(&mut &whole[60..], Time::ZERO + 2.0).unwrap();
    assert_eq!(fix.arrival, Time::ZERO + 1.0);
    assert_eq!(decoder.counts().damaged, 1);
}

fn answer(accepted: bool, class: u8, id: u8) -> Vec<u8> {
    ubx_message(0x05, u8::from(accepted), &[class, id])
}

#[test]
fn a_receiver_is_set_message_by_message_each_awaiting_its_acknowledgement() {
    let mut decoder = Decoder::default();
    let mut configuration = Configuration::new(10).unwrap();
    let mut now = Time::ZERO;
    let mut sent = Vec::new();
    let mut message = configuration.poll(&mut decoder, now);
    while let Some(asked) = message {
        let bytes = asked.as_bytes();
        sent.push(bytes.to_vec());
        // Without an answer the request is repeated, but not too early.
        assert_eq!(configuration.poll(&mut decoder, now + 0.9), None);
        assert_eq!(configuration.poll(&mut decoder, now + 1.0), Some(asked));
        // The answer to another message is ignored.
        decoder.read(&mut answer(true, 0x06, 0x24).as_slice(), now + 1.1);
        assert_eq!(configuration.poll(&mut decoder, now + 1.1), None);
        decoder.read(&mut answer(true, bytes[2], bytes[3]).as_slice(), now + 1.2);
        now = now + 1.2;
        message = configuration.poll(&mut decoder, now);
    }
    assert!(configuration.is_done());
    let mut expected = vec![
        ubx_message(0x06, 0x08, &[100, 0, 1, 0, 1, 0]),
        ubx_message(0x06, 0x01, &[0x01, 0x07, 1]),
    ];
    expected.extend((0..6).map(|sentence| ubx_message(0x06, 0x01, &[0xF0, sentence, 0])));
    assert_eq!(sent, expected);
}

#[test]
fn a_receiver_that_refuses_the_old_messages_is_set_by_keys() {
    let mut decoder = Decoder::default();
    let mut configuration = Configuration::new(5).unwrap();
    configuration.poll(&mut decoder, Time::ZERO).unwrap();
    decoder.read(&mut answer(false, 0x06, 0x08).as_slice(), Time::ZERO);
    let message = configuration.poll(&mut decoder, Time::ZERO + 0.1).unwrap();
    // CFG-VALSET in RAM: CFG-RATE-MEAS 200 ms, CFG-MSGOUT-UBX_NAV_PVT_UART1 1,
    // CFG-UART1OUTPROT-NMEA 0.
    let mut payload = vec![0, 1, 0, 0];
    payload.extend([0x01, 0x00, 0x21, 0x30, 200, 0]);
    payload.extend([0x07, 0x00, 0x91, 0x20, 1]);
    payload.extend([0x02, 0x00, 0x74, 0x10, 0]);
    assert_eq!(message.as_bytes(), ubx_message(0x06, 0x8A, &payload));
    decoder.read(&mut answer(true, 0x06, 0x8A).as_slice(), Time::ZERO + 0.2);
    assert_eq!(configuration.poll(&mut decoder, Time::ZERO + 0.2), None);
    assert!(configuration.is_done());

    let mut refused = Configuration::new(5).unwrap();
    for id in [0x08, 0x8A] {
        refused.poll(&mut decoder, Time::ZERO).unwrap();
        decoder.read(&mut answer(false, 0x06, id).as_slice(), Time::ZERO);
        if id == 0x8A {
            assert_eq!(refused.poll(&mut decoder, Time::ZERO), None);
        }
    }
    assert!(refused.is_refused());
}

#[test]
fn rates_outside_one_to_ten_hertz_are_refused_by_name() {
    for found_hz in [0, 11, 255] {
        let error = Configuration::new(found_hz).unwrap_err();
        assert_eq!(error, ConfigurationError::Rate { found_hz });
        assert!(error.to_string().contains(&found_hz.to_string()));
    }
}
