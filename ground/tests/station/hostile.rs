//! A million hostile frames and ten thousand hostile requests: no value of a hostile frame is shown, and no frame of
//! the vehicle is lost.

use std::io::{Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpStream};

use crate::common::sender::Sender;
use crate::common::{Client, cycle, newest, raw, serve};
use hovernav_ground::channel::Id;
use hovernav_ground::decode::Protocol;
use hovernav_ground::frames::Rigging;
use hovernav_ground::station::Station;
use mavlink::dialects::common::{
    ATTITUDE_DATA, GLOBAL_POSITION_INT_DATA, HIGHRES_IMU_DATA, MavAutopilot, MavMessage, MavType,
    STATUSTEXT_DATA,
};
use tungstenite::Message;

/// Random numbers. Source: Marsaglia, *Xorshift RNGs*, Journal of Statistical Software 8 (2003).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    fn bytes(&mut self, most: usize) -> Vec<u8> {
        (0..self.below(most + 1)).map(|_| self.next() as u8).collect()
    }

    /// Changes one to three bits.
    fn damage(&mut self, bytes: &mut [u8]) {
        for _ in 0..=self.below(3) {
            let place = self.below(bytes.len());
            bytes[place] ^= 1 << self.below(8);
        }
    }
}

/// A message that looks like one of the vehicle's, with values that no vehicle has.
fn absurd(random: &mut Random) -> MavMessage {
    let value = [f32::NAN, f32::INFINITY, -1e38, 7.0, 0.3][random.below(5)];
    match random.below(4) {
        0 => MavMessage::ATTITUDE(ATTITUDE_DATA { roll: value, ..ATTITUDE_DATA::DEFAULT }),
        1 => {
            MavMessage::HIGHRES_IMU(HIGHRES_IMU_DATA { xgyro: value, ..HIGHRES_IMU_DATA::DEFAULT })
        }
        2 => MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            lat: i32::MAX,
            ..GLOBAL_POSITION_INT_DATA::DEFAULT
        }),
        _ => MavMessage::STATUSTEXT(STATUSTEXT_DATA {
            text: "\u{1b}[2J\u{7}hostile".into(),
            ..STATUSTEXT_DATA::DEFAULT
        }),
    }
}

#[test]
fn a_million_hostile_frames_show_nothing_and_cost_no_frame_of_the_vehicle() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut station = Station::new(Rigging::default(), Some(Protocol::Mavlink), "test");
    let mut vehicle = Sender::new(1, 1);
    let mut others: Vec<_> = [(1, 190), (2, 1), (200, 1), (255, 190)]
        .map(|(system, part)| Sender::new(system, part))
        .into();
    let (mut sent, mut hostile, mut time_s) = (0, 0, 1e9);
    while hostile < 1_000_000 {
        if hostile % 1000 == 0 {
            let kind = MavType::MAV_TYPE_HELICOPTER;
            let beat = vehicle.heartbeat(MavAutopilot::MAV_AUTOPILOT_GENERIC, kind);
            station.receive(&beat, time_s);
            sent += 1;
        }
        let own = vehicle.attitude(((time_s - 1e9) * 1e3) as u32, 0.25);
        station.receive(&own, time_s);
        sent += 1;
        time_s += 0.03;
        for _ in 0..10 {
            let other = random.below(others.len());
            let bytes = match random.below(6) {
                0 => random.bytes(300),
                1 => {
                    let mut bytes = own.clone();
                    random.damage(&mut bytes);
                    bytes
                }
                2 => others[other].say(&absurd(&mut random)),
                3 => {
                    let kind = MavType::MAV_TYPE_HELICOPTER;
                    others[other].heartbeat(MavAutopilot::MAV_AUTOPILOT_PX4, kind)
                }
                4 => {
                    let (id, payload) = (random.next() as u32 & 0xFF_FFFF, random.bytes(255));
                    others[other].foreign(id, &payload, random.next() as u8)
                }
                _ => {
                    let whole = others[other].say(&absurd(&mut random));
                    whole[..random.below(whole.len())].to_vec()
                }
            };
            station.receive(&bytes, time_s);
            hostile += 1;
        }
    }
    // The parser may still wait for the end of a long frame that hostile bytes seem to begin. The zeros end it.
    station.receive(&[0; 600], time_s);
    let link = station.link(time_s);
    println!("{} of {sent} frames, {} damaged, {} lost", link.frames, link.damaged, link.lost);
    // One in 256 damaged frames looks like an unknown message of the vehicle, so the counts are a little too high.
    assert!(link.frames >= sent && link.frames - sent < sent / 200 && link.lost < sent / 1000);
    // No value is missing: the store is full and has no gap.
    let kept: Vec<_> = station.store.series(Id::Roll).between(0.0, f64::INFINITY).collect();
    assert!(kept.len() == 40_000 && kept.iter().all(|(_, roll)| !roll.is_nan()), "{}", kept.len());
    let rolls = station.store.series(Id::Roll).between(0.0, f64::INFINITY);
    let shown = 0.25f64.to_degrees();
    assert!(rolls.into_iter().all(|(_, roll)| roll.is_nan() || (roll - shown).abs() < 0.01));
    assert_eq!(newest(&station, Id::RateP), 0.0);
    for id in [Id::Latitude, Id::Altitude] {
        assert!(newest(&station, id).is_nan(), "{id:?}");
    }
    assert!(station.store.texts_from(0).0.all(|line| !line.text.contains("hostile")));
}

#[test]
fn hostile_packed_frames_show_nothing_and_cost_no_frame_of_the_vehicle() {
    let mut random = Random(7);
    let mut station = Station::new(Rigging::default(), Some(Protocol::Frames), "test");
    let (mut sent, mut hostile) = (0, 0);
    for number in 0.. {
        if hostile >= 200_000 {
            break;
        }
        let time_s = 1e9 + f64::from(number) / 33.0;
        let own = cycle(number);
        station.receive(&own, time_s);
        sent += 2;
        for _ in 0..20 {
            let mut bytes = match random.below(3) {
                0 => random.bytes(300),
                1 => own[..random.below(own.len())].to_vec(),
                _ => {
                    let mut bytes = own.clone();
                    random.damage(&mut bytes);
                    // Only the second frame is damaged; the first one stays complete.
                    bytes.drain(..random.below(100) + 1);
                    bytes
                }
            };
            // Frames end at a zero. Without it, a partial frame would spoil the next frame of the vehicle.
            bytes.push(0);
            station.receive(&bytes, time_s);
            hostile += 1;
        }
    }
    let link = station.link(1e9);
    println!("{} of {sent} frames, {} damaged, {} lost", link.frames, link.damaged, link.lost);
    assert!(link.frames >= sent && link.damaged > 100_000);
    let satellites = station.store.series(Id::Satellites).between(0.0, f64::INFINITY);
    assert!(satellites.into_iter().all(|(_, count)| count.is_nan() || count == 9.0));
}

/// The answer to a request that may be incomplete: the client sends nothing more after it.
fn damaged(host: SocketAddr, request: &[u8]) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    let mut answer = Vec::new();
    // Each of these calls may fail because the server has closed the connection.
    let _ = stream.write_all(request);
    let _ = stream.shutdown(Shutdown::Write);
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn ten_thousand_hostile_requests_change_nothing() {
    let served = serve(None);
    for number in 0..33 {
        served.receive(&cycle(number), served.start_s + f64::from(number) / 33.0);
    }
    let mut random = Random(11);
    let mut operator = Client::connect(&served, "").unwrap();
    let host = served.address;
    let words = [
        "/",
        "/main.js",
        "/socket",
        "/export.csv",
        "?from=0&to=1",
        "?from=1e308&to=-1e308",
        "?token=x",
        "/results/",
        "..",
        "%2e%2e",
        "%00",
        "etc/passwd",
        "&channels=roll_deg",
        "&record=..",
        "\u{1b}[2J",
        "%ff%fe",
        "////",
        "?",
        "#",
        ".html",
        "records",
        "x",
    ];
    for number in 0..7_000 {
        let mut path = String::from("/");
        for _ in 0..random.below(6) {
            path.push_str(words[random.below(words.len())]);
        }
        let verb = ["GET", "POST", "PUT", "DELETE", "HEAD", "BREW", "G\0T"][random.below(7)];
        let request =
            format!("{verb} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        let answer = if random.below(3) == 0 {
            let mut request = request.into_bytes();
            random.damage(&mut request);
            damaged(host, &request)
        } else {
            raw(&served, &request)
        };
        assert!(!answer.starts_with("HTTP/1.1 5"), "{number} {path}: {answer}");
        assert!(!answer.contains("root:"), "{path}");
    }
    let verbs = [
        "watch", "view", "record", "stop", "list", "open", "live", "seek", "play", "pause", "mark",
        "flow", "evaluate", "x",
    ];
    let values = [
        "null",
        "1e308",
        "-1",
        "NaN",
        "\"..\"",
        "\"/etc/passwd\"",
        "[]",
        "{}",
        "\"\\u0000\"",
        "true",
        "\"../../x\"",
        "[\"roll_deg\"]",
        "123456789012345678901234567890",
        "\"a/b/c\"",
    ];
    let fields = ["name", "to", "from", "columns", "id", "speed", "note", "channels", "on", "x"];
    for _ in 0..30 {
        let mut client = Client::connect(&served, "").unwrap();
        for _ in 0..100 {
            let verb = verbs[random.below(verbs.len())];
            // A record with a valid name would be written, because the operator's page may do that.
            let verb = if matches!(verb, "flow" | "mark") { "x" } else { verb };
            let mut text = format!("{{\"do\":\"{verb}\"");
            for _ in 0..random.below(4) {
                let (field, value) = (fields[random.below(10)], values[random.below(values.len())]);
                text.push_str(&format!(",\"{field}\":{value}"));
            }
            text.push('}');
            if random.below(4) == 0 {
                let mut bytes = text.into_bytes();
                random.damage(&mut bytes);
                text = String::from_utf8_lossy(&bytes).into_owned();
            }
            let _ = client.0.send(Message::text(text));
        }
    }
    let tick = operator.observe("tick");
    assert!(tick["now"].as_array().unwrap().iter().filter(|value| !value.is_null()).count() >= 60);
    assert!(operator.observe("state")["recording"].is_null());
    let left: Vec<_> = std::fs::read_dir(served.place.path().join("records")).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}
