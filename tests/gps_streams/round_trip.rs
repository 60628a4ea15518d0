//! Encoded data is decoded unchanged, for any values and any cut of the stream.

use hovernav::frames::Vector;
use hovernav::gps::tsip::{
    Differential, Framer, GpsTime, Health, IoOptions, LastFix, MachineStatus, PositionLla,
    PositionXyz, Report, VelocityEnu, VelocityXyz, Version,
};
use hovernav::gps::{Protocol, Receiver, ReceiverFix, ReceiverTime};
use hovernav::time::Time;
use proptest::array::uniform4;
use proptest::prelude::*;

use hovernav_fly::devices::encode;
use hovernav_fly::devices::encode::Epoch;

fn epochs() -> impl Strategy<Value = Epoch> {
    (
        (0u32..604_000, -89.9f64..89.9, -179.9f64..179.9, -400.0f64..9_000.0),
        (-50.0f64..50.0, -50.0f64..50.0, -20.0f64..20.0, 4u8..=12),
    )
        .prop_map(|((time, latitude_deg, longitude_deg, height_m), (n, e, d, satellites))| {
            Epoch {
                // The time counts from midnight of the day of the UBX and NMEA encoders.
                time_of_week_ms: (432_018 + time % 86_000) * 1_000,
                latitude_deg,
                longitude_deg,
                height_m,
                velocity_ned_mps: Some([n, e, d]),
                satellites,
                ..Epoch::flying(0)
            }
        })
}

/// The fixes of a stream passed in two pieces.
fn read(protocol: Protocol, wire: &[u8], cut: usize) -> Vec<ReceiverFix> {
    let mut receiver = Receiver::new(protocol);
    let mut fixes = Vec::new();
    let (first, second) = wire.split_at(cut % (wire.len() + 1));
    for mut piece in [first, second] {
        while let Some(fix) = receiver.read(&mut piece, Time::ZERO) {
            fixes.push(fix);
        }
    }
    fixes.extend(receiver.flush());
    fixes
}

fn near(found: f64, expected: f64, limit: f64) -> bool {
    (found - expected).abs() <= limit
}

/// Whether position and velocity are equal to within the resolution with which they are sent.
fn came_back(fix: &ReceiverFix, epoch: &Epoch, degrees: f64, metres: f64, mps: f64) -> bool {
    let [north, east, down] = epoch.velocity_ned_mps.unwrap();
    let velocity = fix.horizontal_velocity_mps;
    near(fix.latitude_rad.to_degrees(), epoch.latitude_deg, degrees)
        && near(fix.longitude_rad.to_degrees(), epoch.longitude_deg, degrees)
        && fix.height_m.is_some_and(|height| near(height, epoch.height_m, metres))
        && velocity.is_some_and(|[n, e]| near(n, north, mps) && near(e, east, mps))
        && fix.down_velocity_mps.is_none_or(|found| near(found, down, mps))
}

fn gps_time(epoch: &Epoch, leap_seconds: Option<u8>) -> ReceiverTime {
    ReceiverTime::Gps {
        week: Some(encode::WEEK),
        time_of_week_ns: u64::from(epoch.time_of_week_ms) * 1_000_000,
        leap_seconds,
    }
}

proptest! {
    #[test]
    fn tsip_fixes_come_back(epoch in epochs(), cut: usize) {
        let mut wire = encode::tsip_satellites(&epoch);
        wire.extend(encode::tsip_time(&epoch));
        wire.extend(encode::tsip_epoch(&epoch));
        let fixes = read(Protocol::Tsip, &wire, cut);
        prop_assert_eq!(fixes.len(), 1);
        prop_assert!(came_back(&fixes[0], &epoch, 1e-13, 0.0, 4e-6), "{:?}", fixes[0]);
        prop_assert_eq!(fixes[0].satellites, Some(epoch.satellites));
        prop_assert_eq!(fixes[0].time, Some(gps_time(&epoch, Some(18))));
        prop_assert!(fixes[0].down_velocity_mps.is_some());
    }

    #[test]
    fn superpackets_come_back(epoch in epochs(), cut: usize) {
        let fixes = read(Protocol::Tsip, &encode::tsip_superpacket(&epoch), cut);
        prop_assert_eq!(fixes.len(), 1);
        prop_assert!(came_back(&fixes[0], &epoch, 4.3e-8, 5.1e-4, 2.6e-3), "{:?}", fixes[0]);
        prop_assert_eq!(fixes[0].satellites, Some(epoch.satellites));
        prop_assert_eq!(fixes[0].time, Some(gps_time(&epoch, Some(18))));
    }

    #[test]
    fn nav_pvt_comes_back(epoch in epochs(), cut: usize) {
        let fixes = read(Protocol::Ubx, &encode::ubx_pvt(&epoch), cut);
        prop_assert_eq!(fixes.len(), 1);
        prop_assert!(came_back(&fixes[0], &epoch, 5.1e-8, 5.1e-4, 5.1e-4), "{:?}", fixes[0]);
        prop_assert_eq!(fixes[0].satellites, Some(epoch.satellites));
        prop_assert_eq!(fixes[0].time, Some(gps_time(&epoch, Some(18))));
    }

    #[test]
    fn messages_of_older_u_blox_receivers_come_back(epoch in epochs(), cut: usize) {
        let fixes = read(Protocol::Ubx, &encode::ubx_older(&epoch), cut);
        prop_assert_eq!(fixes.len(), 1);
        prop_assert!(came_back(&fixes[0], &epoch, 5.1e-8, 5.1e-4, 5.1e-3), "{:?}", fixes[0]);
    }

    #[test]
    fn nmea_fixes_come_back(epoch in epochs(), cut: usize) {
        let fixes = read(Protocol::Nmea, &encode::nmea_epoch(&epoch), cut);
        prop_assert_eq!(fixes.len(), 1);
        // The course is sent with two digits.
        prop_assert!(came_back(&fixes[0], &epoch, 1e-8, 6e-3, 7e-3), "{:?}", fixes[0]);
        prop_assert_eq!(fixes[0].down_velocity_mps, None);
        let unix_s = (20_532 - 5) * 86_400 + i64::from(epoch.time_of_week_ms / 1_000) - 18;
        let unix_ns = fixes[0].time.and_then(|time| time.unix_ns());
        prop_assert_eq!(unix_ns, Some(unix_s * 1_000_000_000));
    }

    #[test]
    fn any_tsip_packet_comes_through_the_framer(
        id in any::<u8>().prop_filter("no id", |id| ![0x03, 0x10].contains(id)),
        // Half of the bytes are those used for framing.
        payload in prop::collection::vec(prop_oneof![any::<u8>(), Just(0x10), Just(0x03)], 0..=255),
        cut: usize,
    ) {
        let wire = encode::tsip_packet(id, &payload);
        let (mut first, mut second) = wire.split_at(cut % wire.len());
        let mut framer = Framer::default();
        prop_assert_eq!(framer.next(&mut first, Time::ZERO), None);
        let packet = framer.next(&mut second, Time::ZERO).unwrap();
        prop_assert_eq!((packet.id, packet.payload), (id, payload.as_slice()));
    }

    #[test]
    fn every_plain_tsip_report_comes_back(
        doubles in uniform4(-1e7f64..1e7),
        singles in uniform4(-1e4f32..1e4),
        time_of_fix_s in 0f32..6e5,
        week: i16,
        bytes: [u8; 10],
    ) {
        let [a, b, c, d] = doubles;
        let [e, f, g, h] = singles;
        let [u, v, w, x, ..] = bytes;
        let big = |values: &[f64]| -> Vec<u8> {
            values.iter().flat_map(|value| value.to_be_bytes()).collect()
        };
        let small = |values: &[f32]| -> Vec<u8> {
            values.iter().flat_map(|value| value.to_be_bytes()).collect()
        };
        let join = |parts: &[&[u8]]| parts.concat();
        let single = |value: f32| f64::from(value);
        let lla = PositionLla {
            latitude_rad: a, longitude_rad: b, height_m: c, clock_bias_m: d, time_of_fix_s,
        };
        let coarse = PositionLla {
            latitude_rad: single(e),
            longitude_rad: single(f),
            height_m: single(g),
            clock_bias_m: single(h),
            time_of_fix_s,
        };
        for (id, payload, expected) in [
            (
                0x41,
                join(&[&small(&[time_of_fix_s]), &week.to_be_bytes(), &small(&[e])]),
                Report::GpsTime(GpsTime { time_of_week_s: time_of_fix_s, week, utc_offset_s: e }),
            ),
            (
                0x42,
                small(&[e, f, g, time_of_fix_s]),
                Report::PositionXyz(PositionXyz {
                    position_m: Vector::new(single(e), single(f), single(g)),
                    clock_bias_m: None,
                    time_of_fix_s,
                }),
            ),
            (
                0x43,
                small(&[e, f, g, h, time_of_fix_s]),
                Report::VelocityXyz(VelocityXyz {
                    velocity_mps: Vector::new(single(e), single(f), single(g)),
                    clock_bias_rate_mps: h,
                    time_of_fix_s,
                }),
            ),
            (
                0x45,
                bytes.to_vec(),
                Report::Version(Version {
                    navigation: bytes[..5].try_into().unwrap(),
                    signal: bytes[5..].try_into().unwrap(),
                }),
            ),
            (0x46, vec![u, v], Report::Health(Health { status: u, errors: v })),
            (0x4A, small(&[e, f, g, h, time_of_fix_s]), Report::CoarsePositionLla(coarse)),
            (
                0x4A,
                join(&[&small(&[e, f]), &[u]]),
                Report::ReferenceHeight { height_m: e, active: u != 0 },
            ),
            (
                0x4B,
                vec![u, v, w],
                Report::MachineStatus(MachineStatus { machine: u, status_1: v, status_2: w }),
            ),
            (
                0x55,
                vec![u, v, w, x],
                Report::IoOptions(IoOptions { position: u, velocity: v, timing: w, auxiliary: x }),
            ),
            (
                0x56,
                small(&[e, f, g, h, time_of_fix_s]),
                Report::VelocityEnu(VelocityEnu {
                    east_mps: e,
                    north_mps: f,
                    up_mps: g,
                    clock_bias_rate_mps: h,
                    time_of_fix_s,
                }),
            ),
            (
                0x57,
                join(&[&[u, v], &small(&[e]), &week.to_be_bytes()]),
                Report::LastFix(LastFix { source: u, diagnostic: v, time_of_week_s: e, week }),
            ),
            (0x82, vec![u], Report::Differential(Differential { mode: u })),
            (
                0x83,
                join(&[&big(&doubles), &small(&[time_of_fix_s])]),
                Report::PositionXyz(PositionXyz {
                    position_m: Vector::new(a, b, c),
                    clock_bias_m: Some(d),
                    time_of_fix_s,
                }),
            ),
            (0x84, join(&[&big(&doubles), &small(&[time_of_fix_s])]), Report::PositionLla(lla)),
        ] {
            let wire = encode::tsip_packet(id, &payload);
            let mut framer = Framer::default();
            let packet = framer.next(&mut wire.as_slice(), Time::ZERO).unwrap();
            prop_assert_eq!(Report::read(packet.id, packet.payload), Ok(expected));
            // A payload with one byte more or less is not a report.
            prop_assert!(Report::read(id, &payload[1..]).is_err());
        }
    }
}
