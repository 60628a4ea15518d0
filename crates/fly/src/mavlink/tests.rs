use mavlink::dialects::common::{
    EstimatorStatusFlags, GpsFixType, HighresImuUpdatedFlags, MavMessage, MavModeFlag, MavState,
    MavType,
};
use mavlink::{MavHeader, MavlinkReader};

use super::*;
use approx::assert_abs_diff_eq;
use hovernav::controls::Channels;
use hovernav::frames::EulerAngles;
use hovernav::telemetry::{FixKind, GpsSummary, Innovations, Sigmas, StatusFlags, SystemMode};
use hovernav_record::MavlinkRates;

pub(super) fn at(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

pub(super) fn flying(time: Time) -> Snapshot {
    Snapshot {
        mode: SystemMode::Autopilot,
        status: StatusFlags {
            attitude: true,
            velocity: true,
            servos: true,
            ..StatusFlags::default()
        },
        angular_rate_radps: Some(Vector::new(0.1, -0.2, 0.3)),
        specific_force_mps2: Some(Vector::new(0.5, -0.25, -9.81)),
        magnetic_field_gauss: Some(Vector::new(0.2, -0.03, 0.45)),
        temperature_degc: Some(31.5),
        attitude: Some(EulerAngles::from_degrees(5.0, -3.0, 170.0)),
        position: Geodetic::from_degrees(1.345_678_9, 103.680_123_4, 38.0),
        velocity_mps: Some(Vector::new(1.25, -0.5, 0.03)),
        sigmas: Sigmas { horizontal_m: Some(0.85), vertical_m: Some(1.25), ..Sigmas::default() },
        commanded_ms: Channels::from([1.2, 1.4, 1.5, 1.6, 1.7]).map(Some),
        gps: GpsSummary {
            fix: FixKind::Differential,
            satellites: Some(9),
            latitude_longitude_deg: Some([-1.345_678_9, 103.680_123_4]),
            height_m: Some(38.0),
            altitude_msl_m: Some(31.25),
            horizontal_velocity_mps: Some([3.0, -4.0]),
            hdop: Some(1.1),
            ..GpsSummary::default()
        },
        innovations: Innovations { velocity: Some(2.5), ..Innovations::default() },
        ..Snapshot::at(time)
    }
}

pub(super) fn read(bytes: &[u8]) -> Vec<(MavHeader, MavMessage)> {
    let mut reader = MavlinkReader::new(bytes);
    let mut messages = Vec::new();
    while let Ok(message) = reader.read_message(MavlinkVersion::V2) {
        messages.push(message);
    }
    messages
}

/// All messages of one snapshot, decoded with the `mavlink` crate.
pub(super) fn messages_of(mavlink: &mut Mavlink, snapshot: &Snapshot) -> Vec<MavMessage> {
    let mut bytes = Vec::new();
    mavlink.encode(snapshot, &mut bytes);
    assert!(bytes.len() <= 650);
    read(&bytes).into_iter().map(|(_, message)| message).collect()
}

#[test]
fn the_receivers_accuracies_are_in_the_extension_of_its_fix() {
    let mut snapshot = flying(at(2.0));
    snapshot.gps.height_m = Some(-12.5);
    snapshot.gps.horizontal_sigma_m = Some(1.25);
    snapshot.gps.vertical_sigma_m = Some(2.5);
    snapshot.gps.velocity_sigma_mps = Some(0.3);
    let mut bytes = Vec::new();
    Mavlink::new(MavlinkConfig::default(), Time::ZERO).encode(&snapshot, &mut bytes);
    let mut rest = &bytes[..];
    let payload = loop {
        let (frame, after) = rest.split_at(12 + usize::from(rest[1]));
        if frame[7..10] == [24, 0, 0] {
            break &frame[10..frame.len() - 2];
        }
        rest = after;
    };
    let fields = payload[30..].chunks(4).map(|field| {
        let mut whole = [0; 4];
        whole[..field.len()].copy_from_slice(field);
        i32::from_le_bytes(whole)
    });
    assert_eq!(fields.collect::<Vec<_>>(), [-12_500, 1_250, 2_500, 300]);
}

#[test]
fn messages_have_the_units_of_the_message_set() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), at(10.0));
    let messages = messages_of(&mut mavlink, &flying(at(12.5)));
    let [heartbeat, attitude, imu, local, global, gps, servos, status, ..] = &messages[..] else {
        panic!("{messages:?}")
    };

    let MavMessage::HEARTBEAT(heartbeat) = heartbeat else { panic!() };
    assert_eq!(heartbeat.mavtype, MavType::MAV_TYPE_HELICOPTER);
    assert_eq!(heartbeat.system_status, MavState::MAV_STATE_ACTIVE);
    let armed = MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED | MavModeFlag::MAV_MODE_FLAG_AUTO_ENABLED;
    assert!(heartbeat.base_mode.contains(armed));

    let MavMessage::ATTITUDE(attitude) = attitude else { panic!() };
    assert_eq!(attitude.time_boot_ms, 2_500);
    assert_abs_diff_eq!(attitude.yaw, 170f32.to_radians(), epsilon = 1e-6);
    assert_eq!((attitude.rollspeed, attitude.yawspeed), (0.1, 0.3));

    let MavMessage::HIGHRES_IMU(imu) = imu else { panic!() };
    assert_eq!((imu.time_usec, imu.zacc, imu.ymag), (2_500_000, -9.81, -0.03));
    assert_eq!(imu.fields_updated.bits(), 0b1_0001_1111_1111);

    let MavMessage::LOCAL_POSITION_NED(local) = local else { panic!() };
    assert!(local.x.abs() < 1e-6 && local.z.abs() < 1e-6);
    assert_eq!((local.vx, local.vy), (1.25, -0.5));

    let MavMessage::GLOBAL_POSITION_INT(global) = global else { panic!() };
    assert_eq!((global.lat, global.lon), (13_456_789, 1_036_801_234));
    // 38 m above the ellipsoid, with a geoid height of 6.75 m.
    assert_eq!((global.alt, global.relative_alt, global.hdg), (31_250, 0, 17_000));
    assert_eq!((global.vx, global.vy, global.vz), (125, -50, 3));

    let MavMessage::GPS_RAW_INT(gps) = gps else { panic!() };
    assert_eq!((gps.lat, gps.lon, gps.alt), (-13_456_789, 1_036_801_234, 31_250));
    assert_eq!((gps.eph, gps.epv, gps.vel, gps.cog), (110, u16::MAX, 500, 30_687));
    assert_eq!(gps.fix_type, GpsFixType::GPS_FIX_TYPE_DGPS);
    assert_eq!(gps.satellites_visible, 9);

    let MavMessage::SERVO_OUTPUT_RAW(servos) = servos else { panic!() };
    assert_eq!((servos.servo1_raw, servos.servo5_raw, servos.servo6_raw), (1_200, 1_700, 0));

    let MavMessage::ESTIMATOR_STATUS(status) = status else { panic!() };
    assert_eq!((status.vel_ratio, status.pos_horiz_accuracy), (0.5, 0.85));
    assert!(status.pos_horiz_ratio.is_nan());
    let velocity = EstimatorStatusFlags::ESTIMATOR_VELOCITY_HORIZ;
    assert!(status.flags.contains(velocity));
    assert!(!status.flags.contains(EstimatorStatusFlags::ESTIMATOR_POS_HORIZ_ABS));
}

#[test]
fn every_altitude_is_above_the_sea_also_while_the_receiver_is_silent() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    let mut altitudes = |snapshot: &Snapshot| {
        let (mut global_m, mut hud_m, mut home_m) = (None, None, None);
        for message in messages_of(&mut mavlink, snapshot) {
            match message {
                MavMessage::GLOBAL_POSITION_INT(m) => global_m = Some(f64::from(m.alt) * 1e-3),
                MavMessage::VFR_HUD(m) => hud_m = Some(f64::from(m.alt)),
                MavMessage::HOME_POSITION(m) => home_m = Some(f64::from(m.altitude) * 1e-3),
                _ => {}
            }
        }
        [global_m, hud_m, home_m]
    };
    // 38 m above the ellipsoid, with a geoid height of 6.75 m.
    assert_eq!(altitudes(&flying(at(1.0))), [Some(31.25); 3]);
    let lost = Snapshot { gps: GpsSummary::default(), ..flying(at(7.0)) };
    assert_eq!(altitudes(&lost), [Some(31.25); 3]);
}

#[test]
fn unknown_values_are_omitted_or_marked() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    let messages = messages_of(&mut mavlink, &Snapshot::at(Time::ZERO));
    let [heartbeat, imu, gps, servos, ..] = &messages[..] else { panic!("{messages:?}") };
    let MavMessage::HEARTBEAT(heartbeat) = heartbeat else { panic!() };
    assert_eq!(heartbeat.system_status, MavState::MAV_STATE_BOOT);
    let MavMessage::HIGHRES_IMU(imu) = imu else { panic!() };
    assert_eq!(imu.fields_updated, HighresImuUpdatedFlags::empty());
    let MavMessage::GPS_RAW_INT(gps) = gps else { panic!() };
    assert_eq!(gps.fix_type, GpsFixType::GPS_FIX_TYPE_NO_GPS);
    assert_eq!((gps.eph, gps.vel, gps.cog), (u16::MAX, u16::MAX, u16::MAX));
    assert_eq!(gps.satellites_visible, u8::MAX);
    let MavMessage::SERVO_OUTPUT_RAW(servos) = servos else { panic!() };
    assert_eq!(servos.servo1_raw, 0);
}

#[test]
fn messages_are_numbered_and_have_their_rates_within_the_modem_capacity() {
    let config = MavlinkConfig { system_id: 42, component_id: 7, ..MavlinkConfig::default() };
    let mut mavlink = Mavlink::new(config, Time::ZERO);
    let (mut bytes, mut cycles) = (Vec::new(), 0);
    while f64::from(cycles) * 0.0303 < 20.0 {
        mavlink.encode(&flying(at(f64::from(cycles) * 0.0303)), &mut bytes);
        cycles += 1;
    }
    assert!(bytes.len() as f64 * 10.0 / 20.0 < 0.7 * 57_600.0, "{} bytes in 20 s", bytes.len());

    let messages = read(&bytes);
    for (number, (header, _)) in messages.iter().enumerate() {
        assert_eq!((header.system_id, header.component_id), (42, 7));
        assert_eq!(header.sequence, number as u8);
    }
    let count = |wanted: fn(&MavMessage) -> bool| {
        messages.iter().filter(|(_, message)| wanted(message)).count()
    };
    assert_eq!(count(|m| matches!(m, MavMessage::HEARTBEAT(_))), 20);
    assert_eq!(count(|m| matches!(m, MavMessage::GPS_RAW_INT(_))), 40);
    assert_eq!(count(|m| matches!(m, MavMessage::LOCAL_POSITION_NED(_))), 200);
    assert_eq!(count(|m| matches!(m, MavMessage::HIGHRES_IMU(_))), 400);
    // 33 Hz is just below the rate of the loop with a period of 30.3 ms.
    assert!((650..=cycles as usize).contains(&count(|m| matches!(m, MavMessage::ATTITUDE(_)))));
}

#[test]
fn a_clock_set_back_and_a_gap_cause_neither_silence_nor_bursts() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    let mut heartbeats = |t: f64| {
        let messages = messages_of(&mut mavlink, &flying(at(t)));
        messages.iter().filter(|m| matches!(m, MavMessage::HEARTBEAT(_))).count()
    };
    let sent: Vec<_> = [1_000.0, 1_000.03, 3.0, 3.03, 500.0, 500.03].map(&mut heartbeats).into();
    assert_eq!(sent, [1, 0, 1, 0, 1, 0]);
}

#[test]
fn messages_with_a_rate_of_zero_or_an_invalid_rate_are_not_sent() {
    for rate_hz in [0.0, -1.0, f64::NAN] {
        let rates = MavlinkRates { heartbeat_hz: rate_hz, ..MavlinkRates::default() };
        let config = MavlinkConfig { rates, ..MavlinkConfig::default() };
        let messages = messages_of(&mut Mavlink::new(config, Time::ZERO), &flying(at(1.0)));
        assert!(!messages.iter().any(|message| matches!(message, MavMessage::HEARTBEAT(_))));
    }
}

#[test]
fn utc_is_sent_once_it_is_known() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    mavlink.set_utc(1_790_000_000_000_000_000, at(100.0));
    let messages = messages_of(&mut mavlink, &flying(at(100.5)));
    let stamps: Vec<_> = messages
        .iter()
        .filter_map(|message| match message {
            MavMessage::HIGHRES_IMU(imu) => Some(imu.time_usec),
            MavMessage::ATTITUDE(attitude) => Some(u64::from(attitude.time_boot_ms)),
            _ => None,
        })
        .collect();
    assert_eq!(stamps, [100_500, 1_790_000_000_500_000]);
}

#[test]
fn local_positions_are_relative_to_the_first_valid_position() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    let first = flying(at(0.0));
    let nowhere = Geodetic { latitude_rad: f64::NAN, longitude_rad: 0.0, height_m: 0.0 };
    let lost = Snapshot { position: Some(nowhere), ..flying(at(-1.0)) };
    let messages = messages_of(&mut mavlink, &lost);
    assert!(!messages.iter().any(|message| matches!(message, MavMessage::LOCAL_POSITION_NED(_))));
    messages_of(&mut mavlink, &first);
    let place = first.position.unwrap().displaced(Vector::new(30.0, -20.0, -5.0));
    let moved = Snapshot { position: Some(place), ..flying(at(1.0)) };
    let messages = messages_of(&mut mavlink, &moved);
    let local = messages.iter().find_map(|message| match message {
        MavMessage::LOCAL_POSITION_NED(local) => Some([local.x, local.y, local.z]),
        _ => None,
    });
    for (found, expected) in local.unwrap().into_iter().zip([30.0, -20.0, -5.0]) {
        assert_abs_diff_eq!(found, expected, epsilon = 0.01);
    }
}

/// Number, offset and text of the pieces of a text.
fn pieces(bytes: &[u8]) -> Vec<(u16, u8, Vec<u8>)> {
    let mut pieces = Vec::new();
    let mut rest = bytes;
    while let frame::Begun::Frame(found) = frame::begun(rest, None) {
        let mut payload = found.payload.to_vec();
        payload.resize(54, 0);
        let text = payload[1..51].split(|byte| *byte == 0).next().unwrap().to_vec();
        pieces.push((u16::from_le_bytes([payload[51], payload[52]]), payload[53], text));
        rest = &rest[found.length..];
        if rest.is_empty() {
            break;
        }
    }
    pieces
}

#[test]
fn a_long_text_is_split_into_numbered_pieces_without_loss() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), at(0.0));
    let long =
        "one-sigma of horizontal velocity, m/s: 0.812, at most 0.4; age of the last fix, s: über";
    for (number, text) in [(1, long), (2, &"x".repeat(120)), (3, &"y".repeat(100)), (0, "short")] {
        let mut bytes = Vec::new();
        mavlink.encode_text(Level::Warning, text, &mut bytes);
        let pieces = pieces(&bytes);
        let joined: Vec<u8> = pieces.iter().flat_map(|(.., text)| text.clone()).collect();
        assert_eq!(String::from_utf8(joined).unwrap(), text);
        for (place, (id, sequence, piece)) in pieces.iter().enumerate() {
            assert_eq!((*id, usize::from(*sequence)), (number, place));
            // All pieces are full, except the last, which is not: that ends the text.
            assert_eq!(piece.len() == TEXT, place + 1 < pieces.len(), "{text}");
        }
    }
}

#[test]
fn ratios_are_those_of_the_last_second() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    let (mut known, mut all) = (0, 0);
    for cycle in 0..33 * 20 {
        let time = at(f64::from(cycle) / 33.0);
        // One fix a second.
        let position = (cycle % 33 == 7).then_some(2.0);
        let innovations = Innovations { position, ..Innovations::default() };
        for message in messages_of(&mut mavlink, &Snapshot { innovations, ..flying(time) }) {
            if let MavMessage::ESTIMATOR_STATUS(status) = message
                && cycle > 33
            {
                all += 1;
                known += usize::from(status.pos_horiz_ratio == 0.4);
            }
        }
    }
    assert!(all > 30 && known == all, "{known} of {all}");
}

#[test]
fn a_text_is_sent_with_its_severity() {
    use common::MavSeverity::*;
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), at(0.0));
    for (level, expected) in [
        (Level::Info, MAV_SEVERITY_INFO),
        (Level::Warning, MAV_SEVERITY_WARNING),
        (Level::Error, MAV_SEVERITY_ERROR),
        (Level::Critical, MAV_SEVERITY_CRITICAL),
    ] {
        let mut bytes = Vec::new();
        mavlink.encode_text(level, "the pilot flies", &mut bytes);
        let messages = read(&bytes);
        let [(_, MavMessage::STATUSTEXT(said))] = &messages[..] else { panic!("{messages:?}") };
        assert_eq!(said.severity, expected);
    }
}

#[test]
fn only_a_vehicle_with_driven_servos_is_armed() {
    let armed = |snapshot: &Snapshot| {
        let mut mavlink = Mavlink::new(MavlinkConfig::default(), at(0.0));
        let messages = messages_of(&mut mavlink, snapshot);
        messages.iter().any(|message| match message {
            MavMessage::HEARTBEAT(beat) => {
                beat.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED)
            }
            _ => false,
        })
    };
    let flying = flying(at(1.0));
    assert!(armed(&flying));
    assert!(!armed(&Snapshot { commanded_ms: Channels::default(), ..flying }));
}
