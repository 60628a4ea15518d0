//! Vehicles from other makers: a recorded stream, and behaviour that hovernav vehicles do not have.

use std::net::UdpSocket;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use crate::common::browser::{Browser, chromium};
use crate::common::sender::Sender;
use crate::common::{newest, serve, until};
use approx::assert_abs_diff_eq;
use hovernav_ground::channel::Id;
use hovernav_ground::frames::Rigging;
use hovernav_ground::lamps::{Light, control, lamps};
use hovernav_ground::link::{Link, Source, lock};
use hovernav_ground::station::{Station, now_s};
use hovernav_ground::store::TextLevel;
use mavlink::dialects::common::{
    GLOBAL_POSITION_INT_DATA, MavAutopilot, MavMessage, MavType, SERVO_OUTPUT_RAW_DATA,
};

/// `tests/log.tlog` of the crate `mavlink` in the cargo registry.
fn log_of_the_crate() -> Option<Vec<u8>> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cargo")))?;
    let of = |directory: PathBuf| Some(std::fs::read_dir(directory).ok()?.flatten());
    of(home.join("registry/src"))?
        .filter_map(|index| of(index.path()))
        .flatten()
        .filter(|one| one.file_name().to_string_lossy().starts_with("mavlink-0."))
        .find_map(|one| std::fs::read(one.path().join("tests/log.tlog")).ok())
}

/// The log of an ArduSub vehicle on a bench with its ground station, 11.5 s, from the tests of the crate `mavlink`:
/// times, s, and the frames of both.
fn recorded() -> Option<Vec<(f64, Vec<u8>)>> {
    let Some(log) = log_of_the_crate() else {
        hovernav_testing::skip("the sources of the crate mavlink are missing");
        return None;
    };
    let mut frames = Vec::new();
    let mut rest = &log[..];
    while let Some((stamp, after)) = rest.split_first_chunk::<8>() {
        assert_eq!(after[0], 0xFD);
        let (frame, after) = after.split_at(12 + usize::from(after[1]));
        frames.push((1e-6 * u64::from_be_bytes(*stamp) as f64, frame.to_vec()));
        rest = after;
    }
    Some(frames)
}

fn station() -> Station {
    Station::new(Rigging::default(), None, "test")
}

#[test]
fn a_real_submarine_is_received_next_to_its_ground_station() {
    let Some(frames) = recorded() else { return };
    let mut station = station();
    for (time_s, frame) in &frames {
        station.receive(frame, *time_s);
    }
    // The values in the last messages of the log, decoded by another program.
    let expected = [
        (Id::Roll, -1.550_444_5f64.to_degrees(), 0.01),
        (Id::Pitch, 0.018_209_86f64.to_degrees(), 0.01),
        (Id::Yaw, 1.124_525_5f64.to_degrees(), 0.01),
        (Id::RateP, 0.013_284_387f64.to_degrees(), 0.01),
        (Id::AccelY, 1.098, 1e-9),
        (Id::MagZ, -0.434, 1e-9),
        (Id::Output1, 1.5, 1e-9),
        (Id::Radio8, 1.5, 1e-9),
        (Id::GpsFix, 0.0, 0.0),
        (Id::BatteryLeft, 32.0, 0.0),
        (Id::InnovationHeading, 5.0 * 0.050_908_08, 0.01),
    ];
    for (id, value, room) in expected {
        let found = newest(&station, id);
        assert!((found - value).abs() <= room, "{id:?}: {found}, expected {value}");
    }
    // The vehicle has no GPS receiver and sends zeros for its position. Its outputs are not those of a helicopter.
    for id in [Id::Latitude, Id::GpsLatitude, Id::Altitude, Id::Satellites, Id::ServoThrottle] {
        let found = newest(&station, id);
        assert!(found.is_nan() || found == 0.0, "{id:?}: {found}");
    }
    assert!(newest(&station, Id::Latitude).is_nan());

    let value = |id| newest(&station, id);
    assert_eq!(control(value, None).flies, "MANUAL");
    let lamps = lamps(value, None);
    let of = |name| lamps.iter().find(|lamp| lamp.name == name).unwrap();
    assert_eq!(of("arming").why, "not armed");
    assert_eq!(of("attitude").light, Light::Good);
    assert_eq!((of("position").light, of("GPS").light), (Light::Care, Light::Bad));
    assert_eq!(of("loop").light, Light::Unknown);
    let text = |line: &hovernav_ground::store::TextLine| {
        line.level == TextLevel::Warning && line.text == "MYGCS: 255, heartbeat lost"
    };
    assert!(station.store.texts_from(0).0.any(text));

    // All messages of the vehicle, including its own dialect, and none of the ground station.
    let link = station.link(now_s());
    assert_eq!((link.frames, link.lost, link.damaged), (1136, 0, 0));
}

#[test]
fn its_stream_is_received_by_udp_in_real_time() {
    let Some(frames) = recorded() else { return };
    let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let station = Arc::new(Mutex::new(station()));
    let source: Source = format!("udp:{free}").parse().unwrap();
    let link = Link::open(&source, Arc::clone(&station)).unwrap();
    until("the address is open", || lock(&station).link(now_s()).port == "address open");
    let vehicle = UdpSocket::bind("127.0.0.1:0").unwrap();
    vehicle.set_nonblocking(true).unwrap();
    let (start_s, first_s) = (now_s(), frames[0].0);
    let (mut told, mut due_s) = (0, start_s);
    for (time_s, frame) in frames.iter().take_while(|(time_s, _)| time_s - first_s < 3.0) {
        due_s = start_s + time_s - first_s;
        thread::sleep(Duration::from_secs_f64((due_s - now_s()).max(0.0)));
        vehicle.send_to(frame, free).unwrap();
        told += u64::from(frame[5] == 1);
    }
    until("all frames arrive", || lock(&station).link(now_s()).frames == told);
    // Delay of the last frame that is caused by the machine itself.
    let late_s = now_s() - due_s;
    drop(link);
    let station = lock(&station);
    let state = station.link(now_s());
    assert_eq!((state.frames, state.lost, state.damaged), (told, 0, 0));
    assert!(state.delay_s < 1.0 + late_s, "{state:?}");
    let rolls = station.store.series(Id::Roll).between(0.0, f64::INFINITY);
    let rolls: Vec<f64> = rolls.map(|(_, roll)| roll).filter(|roll| !roll.is_nan()).collect();
    assert!(rolls.len() > 7 && rolls.iter().all(|roll| (roll + 88.1).abs() < 0.1), "{rolls:?}");
    // No command was sent to the vehicle: MAVLink has no `#`.
    assert!(vehicle.recv(&mut [0; 16]).is_err());
}

#[test]
fn the_page_names_its_mode_and_says_that_it_is_not_armed() {
    let (Some(frames), Some(chromium)) = (recorded(), chromium()) else { return };
    let served = serve(None);
    let mut page = Browser::open(&chromium, &format!("http://{}/", served.address), 1400, 950);
    page.wait("document.querySelectorAll('#plots .plot canvas').length === 6");
    // At 5 s every shown value is younger than two of its periods.
    for (time_s, frame) in frames.iter().take_while(|(time_s, _)| time_s - frames[0].0 < 5.0) {
        served.receive(frame, *time_s);
    }
    page.wait("document.getElementById('flies').textContent === 'MANUAL'");
    page.wait("document.getElementById('lamps').innerText.includes('not armed')");
    page.wait("document.getElementById('angles').textContent.startsWith('roll -88.1')");
    page.wait("document.getElementById('link').textContent.includes('0 lost, 0 damaged')");
    page.keep("mavlink");
    page.key("2");
    page.wait("document.getElementById('ready').textContent === 'not reported'");
    assert!(page.said.is_empty(), "{:?}", page.said);
}

#[test]
fn the_gimbal_and_the_other_ground_station_are_not_the_vehicle() {
    let (mut vehicle, mut gimbal, mut other) =
        (Sender::new(1, 1), Sender::new(1, 154), Sender::new(255, 190));
    let mut station = station();
    for k in 0..100u32 {
        let at_s = 1e9 + 0.1 * f64::from(k);
        // The other senders start first.
        let mut bytes = gimbal.attitude(100 * k, 1.0);
        if k % 10 == 0 {
            bytes.extend(
                other.heartbeat(MavAutopilot::MAV_AUTOPILOT_INVALID, MavType::MAV_TYPE_GCS),
            );
            let kind = MavType::MAV_TYPE_GIMBAL;
            bytes.extend(gimbal.heartbeat(MavAutopilot::MAV_AUTOPILOT_INVALID, kind));
        }
        if k > 20 {
            if k % 10 == 5 {
                let kind = MavType::MAV_TYPE_QUADROTOR;
                bytes.extend(vehicle.heartbeat(MavAutopilot::MAV_AUTOPILOT_PX4, kind));
            }
            bytes.extend(vehicle.attitude(100 * k, 0.5));
        }
        station.receive(&bytes, at_s);
    }
    assert_abs_diff_eq!(newest(&station, Id::Roll), 0.5f64.to_degrees(), epsilon = 0.01);
    let value = |id| newest(&station, id);
    assert_eq!(control(value, None).flies, "POSCTL");
    assert_eq!(lamps(value, None)[0].why, "armed");
    assert_eq!(station.link(1e9 + 10.0).lost, 0);
}

#[test]
fn messages_that_nobody_here_knows_are_neither_lost_nor_damaged() {
    let mut vehicle = Sender::new(7, 1);
    let mut station = station();
    let mut sent = 0;
    for k in 0..300u32 {
        let mut bytes = vehicle.attitude(30 * k, 0.1);
        // A payload that looks like the beginning of another message.
        let payload = [0xFD, 9, 0, 0, k as u8, 7, 1, 30, 0, 0, 0xFE, 28];
        bytes.extend(vehicle.foreign(50_000 + k % 20, &payload, 17 + (k % 20) as u8));
        sent += 2;
        if k == 150 {
            // Two messages are really missing.
            vehicle.header.sequence = vehicle.header.sequence.wrapping_add(2);
        }
        for piece in bytes.chunks(5) {
            station.receive(piece, 1e9 + 0.03 * f64::from(k));
        }
    }
    let link = station.link(1e9 + 9.0);
    assert_eq!((link.frames, link.lost, link.damaged), (sent, 2, 0));
}

#[test]
fn datagrams_that_overtake_each_other_are_not_lost() {
    let mut vehicle = Sender::new(1, 1);
    let frames: Vec<_> = (0..400u32).map(|k| vehicle.attitude(30 * k, 0.1)).collect();
    let mut station = station();
    for pair in frames.chunks(2) {
        for frame in pair.iter().rev() {
            station.receive(frame, 1e9);
        }
    }
    let link = station.link(1e9 + 9.0);
    assert!(link.frames == 400 && link.lost <= 1, "{link:?}");
}

#[test]
fn a_message_that_is_not_sent_any_more_has_no_value_any_more() {
    let mut vehicle = Sender::new(1, 1);
    let mut station = station();
    for k in 0..200u32 {
        let at_s = 1e9 + 0.1 * f64::from(k);
        let mut bytes = Vec::new();
        if k < 100 {
            bytes.extend(vehicle.attitude(100 * k, 0.1));
        }
        let servos =
            SERVO_OUTPUT_RAW_DATA { servo1_raw: 1000 + k as u16, ..SERVO_OUTPUT_RAW_DATA::DEFAULT };
        if k % 10 == 0 {
            let kind = MavType::MAV_TYPE_QUADROTOR;
            bytes.extend(vehicle.heartbeat(MavAutopilot::MAV_AUTOPILOT_PX4, kind));
        }
        bytes.extend(vehicle.say(&MavMessage::SERVO_OUTPUT_RAW(servos)));
        station.receive(&bytes, at_s);
    }
    assert!(newest(&station, Id::Roll).is_nan());
    // Messages without a time stamp are still used.
    assert_abs_diff_eq!(newest(&station, Id::Output1), 1.199, epsilon = 1e-9);
}

#[test]
fn altitude_and_velocity_of_a_vehicle_without_local_position_have_their_own_names() {
    let mut vehicle = Sender::new(1, 1);
    let mut station = station();
    let place = GLOBAL_POSITION_INT_DATA {
        lat: 13_500_000,
        lon: 1_038_200_000,
        alt: 42_000,
        relative_alt: 12_000,
        vx: 150,
        vy: -50,
        vz: 20,
        ..GLOBAL_POSITION_INT_DATA::DEFAULT
    };
    station.receive(&vehicle.attitude(0, 0.0), 1e9);
    station.receive(&vehicle.say(&MavMessage::GLOBAL_POSITION_INT(place)), 1e9);
    let found = [Id::Altitude, Id::AboveHome, Id::VelN, Id::VelE, Id::VelU, Id::BodyU]
        .map(|id| newest(&station, id));
    assert_eq!(found, [42.0, 12.0, 1.5, -0.5, -0.2, 1.5]);
    assert!(newest(&station, Id::Height).is_nan(), "that is above the ellipsoid");
}
