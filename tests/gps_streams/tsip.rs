//! TSIP reports that give a fix, and reports that do not.

use approx::assert_abs_diff_eq;
use hovernav::earth::Geodetic;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::tsip::{Decoder, Health, IoOptions};
use hovernav::gps::{Correction, Dimension, Protocol, ReceiverFix, ReceiverTime};
use hovernav::time::Time;

use crate::fixes;
use hovernav_fly::devices::encode;
use hovernav_fly::devices::encode::{Epoch, tsip_packet};

fn singles(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

fn read(wire: &[u8]) -> Vec<ReceiverFix> {
    fixes(Protocol::Tsip, wire)
}

#[test]
fn the_manuals_bytes_are_the_manuals_fix() {
    // Two packets of a Lassen iQ in Playa del Carmen, with the time of fix of the first.
    let wire = [
        &[0x10, 0x84][..],
        &[0x3F, 0xD7, 0x0A, 0xCE, 0x29, 0x30, 0x4C, 0xC2],
        &[0xBF, 0xF8, 0x50, 0x58, 0x68, 0x41, 0xE4, 0x3F],
        &[0x40, 0x29, 0xC8, 0xD4, 0x17, 0xA0, 0x00, 0x00],
        &[0xC0, 0xD2, 0xC5, 0x54, 0x5E, 0x01, 0x92, 0x66, 0x48, 0xDA, 0x41, 0x80, 0x10, 0x03],
        &[0x10, 0x56, 0x3E, 0x91, 0x4F, 0xF9, 0x3E, 0xC2, 0x7F, 0x11, 0x3A, 0x5B, 0xEA, 0x00],
        &[0x42, 0xF7, 0x09, 0xC3, 0x48, 0xDA, 0x41, 0x80, 0x10, 0x03],
    ]
    .concat();
    let fix = read(&wire)[0];
    assert_abs_diff_eq!(fix.latitude_rad, 0.360_034_504_149_734_26, epsilon = 1e-16);
    assert_abs_diff_eq!(fix.longitude_rad, -1.519_615_561_728_883_6, epsilon = 1e-15);
    assert_eq!(fix.height_m, Some(12.892_243_135_720_491));
    let [north, east] = fix.horizontal_velocity_mps.unwrap();
    assert_abs_diff_eq!(north, 0.379_875_69, epsilon = 1e-8);
    assert_abs_diff_eq!(east, 0.283_813_27, epsilon = 1e-8);
    assert_abs_diff_eq!(fix.down_velocity_mps.unwrap(), -0.000_838_905_57, epsilon = 1e-10);
    assert!(matches!(
        fix.time,
        Some(ReceiverTime::Gps { week: None, time_of_week_ns: 446_988_000_000_000, .. })
    ));
}

#[test]
fn earth_fixed_reports_give_the_same_fix_as_local_ones() {
    let epoch = Epoch::flying(3);
    let place =
        Geodetic::from_degrees(epoch.latitude_deg, epoch.longitude_deg, epoch.height_m).unwrap();
    let velocity: Vector<Ned> = epoch.velocity_ned_mps.unwrap().into();
    let [x, y, z] = place.to_ecef().to_array();
    let [vx, vy, vz] = (place.ecef_to_ned().inverse() * velocity).to_array();
    let time = (epoch.time_of_week_ms / 1_000) as f32;
    let speed = tsip_packet(0x43, &singles(&[vx as f32, vy as f32, vz as f32, 0.0, time]));
    let double = [doubles(&[x, y, z, 0.0]), singles(&[time])].concat();
    let single = singles(&[x as f32, y as f32, z as f32, time]);
    for (position, limit_m) in
        [(tsip_packet(0x83, &double), 1e-8), (tsip_packet(0x42, &single), 0.5)]
    {
        for wire in [[position.clone(), speed.clone()].concat(), [speed.clone(), position].concat()]
        {
            let fix = read(&wire)[0].at(Time::ZERO).unwrap();
            assert!(fix.position.displacement_from(&place).norm() < limit_m);
            assert!((fix.velocity_mps().unwrap() - velocity).norm() < 2e-6);
        }
    }
}

#[test]
fn coarse_and_stored_positions_are_no_fix() {
    let coarse = singles(&[0.023, 1.8, 40.0, 0.0, 446_988.0]);
    assert_eq!(read(&tsip_packet(0x4A, &coarse)), []);
    let stored = [doubles(&[0.023, 1.8, 40.0, 0.0]), singles(&[-1.0])].concat();
    assert_eq!(read(&tsip_packet(0x84, &stored)), []);
}

#[test]
fn the_receivers_health_reports_why_no_fix_comes() {
    let mut decoder = Decoder::default();
    assert_eq!(decoder.health(), None);
    let wire = tsip_packet(0x46, &[0x09, 0x10]);
    assert_eq!(decoder.read(&mut wire.as_slice(), Time::ZERO), None);
    assert_eq!(decoder.health(), Some(Health { status: 9, errors: 0x10 }));
}

#[test]
fn what_cannot_be_is_refused() {
    let lla = |latitude: f64, longitude: f64, height: f64, time: f32| {
        let payload = [doubles(&[latitude, longitude, height, 0.0]), singles(&[time])].concat();
        tsip_packet(0x84, &payload)
    };
    assert_eq!(read(&lla(0.1, 0.2, 30.0, 10.0)).len(), 1);
    for wire in [
        lla(1.571, 0.2, 30.0, 10.0),
        lla(f64::NAN, 0.2, 30.0, 10.0),
        lla(0.1, f64::INFINITY, 30.0, 10.0),
        lla(0.1, 6.3, 30.0, 10.0),
        lla(0.1, 0.2, 1e6, 10.0),
        lla(0.1, 0.2, 30.0, 604_800.0),
        lla(0.1, 0.2, 30.0, f32::NAN),
        tsip_packet(0x83, &[doubles(&[0.0; 4]), singles(&[10.0])].concat()),
    ] {
        assert_eq!(read(&wire), []);
    }
    // An impossible velocity is rejected, the position is used.
    let fast = tsip_packet(0x56, &singles(&[1e9, 0.0, 0.0, 0.0, 10.0]));
    let fix = read(&[lla(0.1, 0.2, 30.0, 10.0), fast].concat())[0];
    assert_eq!(fix.horizontal_velocity_mps, None);
}

#[test]
fn position_and_velocity_of_different_seconds_are_not_mixed() {
    let epochs = [0, 1, 2].map(Epoch::flying);
    let wire = [
        encode::tsip_lla(&epochs[0]),
        encode::tsip_enu(&epochs[1]),
        encode::tsip_lla(&epochs[2]),
        encode::tsip_enu(&epochs[2]),
    ]
    .concat();
    let fixes = read(&wire);
    assert_eq!(fixes.len(), 2);
    assert_eq!(fixes[0].horizontal_velocity_mps, None);
    assert!(fixes[1].horizontal_velocity_mps.is_some());
}

#[test]
fn a_receiver_that_sends_one_fix_in_two_forms_gives_it_once() {
    for second_first in [false, true] {
        let mut wire = Vec::new();
        for index in 0..4 {
            let epoch = Epoch::flying(index);
            let forms = [encode::tsip_lla(&epoch), encode::tsip_superpacket(&epoch)];
            wire.extend(if second_first {
                [forms[1].clone(), forms[0].clone()].concat()
            } else {
                forms.concat()
            });
            wire.extend(tsip_packet(0x82, &[3]));
        }
        let fixes = read(&wire);
        assert_eq!(fixes.len(), 4);
        assert!(fixes.iter().all(|fix| fix.horizontal_velocity_mps.is_some()));
    }
}

#[test]
fn a_superpacket_that_says_so_is_no_fix() {
    let good = encode::tsip_superpacket(&Epoch::flying(0));
    // No byte of this packet is stuffed, so payload offset n is wire offset n + 2.
    let with = |offset: usize, value: u8| {
        let mut wire = good.clone();
        wire[offset + 2] = value;
        read(&wire)
    };
    assert_eq!(with(27, 0x00).len(), 1);
    assert_eq!(with(27, 0x01), []);
    assert_eq!(with(27, 0x04)[0].dimension, Some(Dimension::TwoD));
    assert_eq!(with(27, 0x02)[0].correction, Some(Correction::Differential));
    // A datum other than WGS-84 means another position.
    assert_eq!(with(26, 0x05), []);
    let mut overflow = good.clone();
    overflow[4..6].copy_from_slice(&[0x80, 0x00]);
    assert_eq!(read(&overflow)[0].horizontal_velocity_mps, None);
}

#[test]
fn the_compact_packet_of_later_units_is_a_fix() {
    let semicircles = |degrees: f64| (degrees / 180.0 * f64::from(1u32 << 31)).round() as i64;
    let mut payload = vec![0x23];
    payload.extend(446_988_000u32.to_be_bytes());
    payload.extend(2_410u16.to_be_bytes());
    payload.extend([18, 0x20]);
    payload.extend((semicircles(-33.5) as i32).to_be_bytes());
    payload.extend((semicircles(246.0) as u32).to_be_bytes());
    payload.extend(1_234_567i32.to_be_bytes());
    for counts in [100i16, -50, 25] {
        payload.extend(counts.to_be_bytes());
    }
    payload.extend([0, 0]);
    let fix = read(&tsip_packet(0x8F, &payload))[0];
    assert_abs_diff_eq!(fix.latitude_rad.to_degrees(), -33.5, epsilon = 5e-8);
    assert_abs_diff_eq!(fix.longitude_rad.to_degrees(), -114.0, epsilon = 5e-8);
    assert_eq!(fix.height_m, Some(1_234.567));
    // Bit 5 of the status: steps of 0.02 m/s.
    assert_eq!(fix.horizontal_velocity_mps, Some([-1.0, 2.0]));
    assert_eq!(fix.down_velocity_mps, Some(-0.5));
}

#[test]
fn heights_above_the_sea_are_distinguished_from_those_above_the_ellipsoid() {
    let options = |position| tsip_packet(0x55, &[position, 0x02, 0x00, 0x08]);
    let epoch = encode::tsip_epoch(&Epoch::flying(0));
    let fix = read(&[options(0x16), epoch.clone()].concat())[0];
    assert_eq!((fix.height_m, fix.altitude_msl_m), (None, Some(41.0)));
    let fix = read(&[options(0x12), epoch].concat())[0];
    assert_eq!((fix.height_m, fix.altitude_msl_m), (Some(41.0), None));
}

#[test]
fn times_in_utc_are_not_taken_for_gps_time() {
    let options = IoOptions { timing: 0x01, ..IoOptions::NAVIGATION };
    let reply = [options.position, options.velocity, options.timing, options.auxiliary];
    let wire = [tsip_packet(0x55, &reply), encode::tsip_epoch(&Epoch::flying(0))].concat();
    assert!(matches!(
        read(&wire)[0].time,
        Some(ReceiverTime::Utc { day: None, time_of_day_ns: 14_988_000_000_000 })
    ));
}

#[test]
fn the_week_is_right_on_both_sides_of_its_end_and_of_a_rollover() {
    let time = |week: i16, seconds: f32| {
        tsip_packet(
            0x41,
            &[&singles(&[seconds])[..], &week.to_be_bytes(), &singles(&[18.0])].concat(),
        )
    };
    let lla = |seconds: f32| {
        let payload = [doubles(&[0.1, 0.2, 30.0, 0.0]), singles(&[seconds])].concat();
        tsip_packet(0x84, &payload)
    };
    for sent in [2_410, 2_410 - 1_024, 2_410 - 2_048] {
        let wire = [
            time(sent, 604_796.0),
            lla(604_799.0),
            lla(0.0),
            time(sent + 1, 1.5),
            lla(604_799.0),
            lla(2.0),
        ]
        .concat();
        let weeks: Vec<_> = read(&wire)
            .iter()
            .map(|fix| match fix.time {
                Some(ReceiverTime::Gps { week, leap_seconds: Some(18), .. }) => week,
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(weeks, [Some(2_410), Some(2_411), Some(2_410), Some(2_411)], "sent {sent}");
    }
    // A receiver with an unknown time sends -1.
    let wire = [time(2_410, -1.0), lla(5.0)].concat();
    assert!(matches!(read(&wire)[0].time, Some(ReceiverTime::Gps { week: None, .. })));
}

#[test]
fn geometry_from_long_ago_says_nothing_of_a_fix() {
    let mut decoder = Decoder::default();
    let satellites = encode::tsip_satellites(&Epoch::flying(0));
    decoder.read(&mut satellites.as_slice(), Time::ZERO);
    let mut at = |seconds: f64, index: u32| {
        let wire = encode::tsip_epoch(&Epoch::flying(index));
        // The satellites of an epoch without its own 0x6D.
        let mut rest = &wire[..90];
        decoder.read(&mut rest, Time::ZERO + seconds).map(|fix| fix.satellites)
    };
    assert_eq!(at(5.0, 0), Some(Some(8)));
    assert_eq!(at(15.0, 1), Some(None));
}

#[test]
fn a_fix_is_out_with_the_second_of_position_and_velocity() {
    let mut decoder = Decoder::default();
    let epoch = Epoch::flying(0);
    let wire = [encode::tsip_lla(&epoch), encode::tsip_enu(&epoch)].concat();
    let (mut before, mut last) = wire.split_at(wire.len() - 1);
    assert_eq!(decoder.read(&mut before, Time::ZERO), None);
    let fix = decoder.read(&mut last, Time::ZERO + 0.07).unwrap();
    assert_eq!(fix.arrival, Time::ZERO);
}
