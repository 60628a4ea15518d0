//! Real receivers' streams, compared with the decoding of other programs.
//!
//! `gpsd` publishes captures with its own decoding (`.chk`, JSON). The Lassen iQ captures have been decoded a third
//! time, packet by packet (`.decoded.jsonl`). Where gpsd is known to be wrong, the expected values come from the bytes,
//! and the table below gives the reason.

use std::fs;
use std::path::Path;

use hovernav::gps::tsip::{Decoder, Framer, Report};
use hovernav::gps::{Protocol, Receiver, ReceiverFix, ReceiverTime};
use hovernav::time::Time;
use hovernav_testing::shared;
use serde_json::{Value, json};

const DAY_NS: i64 = 86_400_000_000_000;

/// A capture in a supported protocol.
struct Capture {
    name: &'static str,
    protocol: Protocol,
    /// Number of fixes in the capture.
    fixes: usize,
    /// Number of these fixes that gpsd prints. gpsd reports an epoch once the next epoch has begun, and therefore skips
    /// some at the ends.
    confirmed: usize,
    /// Positions that gpsd prints but that are not fixes by the rules here, with the reason.
    beyond: (usize, &'static str),
    time: Agreement,
}

/// Precision to which gpsd's times can be compared.
#[derive(Clone, Copy, PartialEq)]
enum Agreement {
    DateAndTime,
    /// gpsd assumes a rollover of the date and adds 1024 weeks, or guesses the date before the receiver reports it.
    TimeOfDay,
    /// gpsd uses the time of GLL, which differs from that of this receiver's fix by a second.
    Nothing,
}

const fn capture(
    name: &'static str,
    protocol: Protocol,
    fixes: usize,
    confirmed: usize,
) -> Capture {
    let beyond = (0, "");
    Capture { name, protocol, fixes, confirmed, beyond, time: Agreement::DateAndTime }
}

const GLL: &str = "a GLL by itself, with a time of its own or none";
const TWICE: &str = "RMC gives the position of GGA again with fewer digits";

const READ: &[Capture] = &[
    capture("april6_2019", Protocol::Nmea, 2, 2),
    capture("foretrex-201", Protocol::Nmea, 7, 6),
    Capture { time: Agreement::Nothing, ..capture("garmin48", Protocol::Nmea, 7, 7) },
    capture("gp-320fw-2019-04-07-coldboot", Protocol::Nmea, 2, 2),
    capture("hab-gpspi", Protocol::Nmea, 3, 3),
    Capture { beyond: (1, GLL), ..capture("magellan315", Protocol::Nmea, 3, 3) },
    capture("motorola-t805", Protocol::Nmea, 16, 16),
    Capture {
        beyond: (1, GLL),
        time: Agreement::TimeOfDay,
        ..capture("neo-m8n", Protocol::Nmea, 23, 22)
    },
    capture("nmea-fuzzy-cases", Protocol::Nmea, 14, 14),
    capture("nmea-rtk", Protocol::Nmea, 122, 122),
    Capture { beyond: (1, TWICE), ..capture("tcp-test", Protocol::Nmea, 1, 1) },
    Capture {
        beyond: (2, "GGA with | among its digits, which gpsd's replay truncates"),
        time: Agreement::TimeOfDay,
        ..capture("tcp-torture", Protocol::Nmea, 1, 1)
    },
    Capture { beyond: (1, TWICE), ..capture("udp-test", Protocol::Nmea, 1, 1) },
    capture("ublox-8", Protocol::Nmea, 72, 72),
    capture("ublox-lea-4h", Protocol::Nmea, 9, 8),
    capture("ublox-lea-5h", Protocol::Nmea, 20, 19),
    // Before NAV-TIMEGPS gpsd assumes 18 leap seconds, where there were 14 and 15.
    Capture {
        beyond: (1, "time with guessed leap seconds"),
        ..capture("ublox-aek-4t", Protocol::Ubx, 4, 3)
    },
    Capture {
        beyond: (1, "time with guessed leap seconds"),
        ..capture("ublox-lea-4t", Protocol::Ubx, 2, 1)
    },
    capture("ublox-neo-m8n", Protocol::Ubx, 24, 22),
    capture("ublox-neo-m8t", Protocol::Ubx, 39, 39),
    capture("trimble-lassen_iq", Protocol::Tsip, 30, 30),
    Capture {
        time: Agreement::TimeOfDay,
        ..capture("trimble-lassen_iq-playacar", Protocol::Tsip, 40, 40)
    },
];

/// One of gpsd's reports of position.
struct Reported {
    unix_ns: Option<i64>,
    latitude_deg: f64,
    longitude_deg: f64,
    value: Value,
}

/// The bytes of a capture, without the comment lines at its head.
fn wire_bytes(path: &Path) -> Vec<u8> {
    let mut bytes = fs::read(path).unwrap();
    while bytes.first() == Some(&b'#') {
        let line = bytes.iter().position(|byte| *byte == b'\n').unwrap();
        bytes.drain(..=line);
    }
    bytes
}

fn reported(path: &Path) -> Vec<Reported> {
    let text = fs::read(path).unwrap();
    String::from_utf8_lossy(&text)
        .lines()
        .filter(|line| line.starts_with("{\"class\":\"TPV\""))
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .filter_map(|value| {
            Some(Reported {
                unix_ns: value["time"].as_str().map(unix_ns),
                latitude_deg: value["lat"].as_f64()?,
                longitude_deg: value["lon"].as_f64()?,
                value,
            })
        })
        .collect()
}

/// `2006-12-22T04:09:38.000Z` in nanoseconds since 1970.
fn unix_ns(text: &str) -> i64 {
    let time = chrono::NaiveDateTime::parse_from_str(text, "%Y-%m-%dT%H:%M:%S%.fZ").unwrap();
    time.and_utc().timestamp_nanos_opt().unwrap()
}

fn receiver(protocol: Protocol) -> Receiver {
    match protocol {
        // The captures are older than the floor for live receivers.
        Protocol::Tsip => Receiver::Tsip(Decoder::with_week_floor(1_300)),
        other => Receiver::new(other),
    }
}

fn fixes_of(protocol: Protocol, bytes: &[u8]) -> Vec<ReceiverFix> {
    let mut receiver = receiver(protocol);
    let mut rest = bytes;
    let mut fixes = Vec::new();
    while let Some(fix) = receiver.read(&mut rest, Time::ZERO) {
        fixes.push(fix);
    }
    fixes.extend(receiver.flush());
    fixes
}

/// Nanoseconds since midnight UTC. Without leap seconds from the receiver, gpsd assumes 18.
fn time_of_day_ns(time: ReceiverTime) -> i64 {
    match time {
        ReceiverTime::Utc { time_of_day_ns, .. } => time_of_day_ns as i64,
        ReceiverTime::Gps { time_of_week_ns, leap_seconds, .. } => (time_of_week_ns as i64
            - i64::from(leap_seconds.unwrap_or(18)) * 1_000_000_000)
            .rem_euclid(DAY_NS),
    }
}

/// Whether the fix and the report are of one epoch at one position. Positions may differ by 2e-7°, because of gpsd's
/// constant for semicircles and its number of digits.
fn agree(capture: &Capture, fix: &ReceiverFix, reported: &Reported) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 2e-7;
    let same_time = capture.time == Agreement::Nothing
        || reported.unix_ns.zip(fix.time).is_none_or(|(unix_ns, time)| {
            (unix_ns.rem_euclid(DAY_NS) - time_of_day_ns(time)).abs() < 1_000_000
        });
    same_time
        && near(fix.latitude_rad.to_degrees(), reported.latitude_deg)
        && near(fix.longitude_rad.to_degrees(), reported.longitude_deg)
}

/// The smallest difference between a value of this project and any of gpsd's values for the epoch. gpsd prints an epoch
/// after each message, and fills in missing values from the previous fix.
fn least_difference<'a>(
    ours: Option<f64>,
    reported: impl Iterator<Item = &'a Value>,
    key: &str,
) -> Option<f64> {
    let theirs = reported.filter_map(|value| value[key].as_f64());
    theirs.zip(std::iter::repeat(ours?)).map(|(a, b)| (a - b).abs()).reduce(f64::min)
}

#[test]
fn every_capture_gives_the_fixes_that_gpsd_reports() {
    let Some(folder) = shared("captures/gpsd") else { return };
    for capture in READ {
        let name = capture.name;
        let fixes = fixes_of(capture.protocol, &wire_bytes(&folder.join(format!("{name}.log"))));
        let reported = reported(&folder.join(format!("{name}.log.chk")));
        let of = |fix: &ReceiverFix| -> Vec<&Reported> {
            reported.iter().filter(|reported| agree(capture, fix, reported)).collect()
        };
        let confirmed = fixes.iter().filter(|fix| !of(fix).is_empty()).count();
        let beyond = reported
            .iter()
            .filter(|reported| !fixes.iter().any(|fix| agree(capture, fix, reported)))
            .count();
        assert_eq!(fixes.len(), capture.fixes, "{name}: fixes");
        assert_eq!(confirmed, capture.confirmed, "{name}: fixes that gpsd reports too");
        assert_eq!(beyond, capture.beyond.0, "{name}: beyond {:?}", capture.beyond.1);

        for fix in &fixes {
            let same = of(fix);
            let values = || same.iter().map(|reported| &reported.value);
            let [north, east] = fix.horizontal_velocity_mps.map_or([None; 2], |v| v.map(Some));
            let compare = |ours: Option<f64>, key: &str, limit: f64| {
                let difference = least_difference(ours, values(), key);
                assert!(
                    difference.is_none_or(|difference| difference <= limit),
                    "{name}: {key} differs by {difference:?}: {fix:?}, {:?}",
                    values().collect::<Vec<_>>(),
                );
            };
            if capture.time != Agreement::Nothing {
                compare(fix.height_m, "altHAE", 1e-4);
                compare(fix.altitude_msl_m, "altMSL", 1e-4);
            }
            match capture.protocol {
                Protocol::Nmea => {
                    // Without a course gpsd computes the speed from the positions.
                    let told = values().any(|value| value["track"].is_number());
                    let course = north.zip(east).filter(|_| fix.ground_speed_mps > Some(0.0));
                    let course = course.map(|(n, e)| e.atan2(n).to_degrees().rem_euclid(360.0));
                    compare(fix.ground_speed_mps.filter(|_| told), "speed", 6e-4);
                    compare(course, "track", 1e-3);
                }
                Protocol::Ubx => {
                    compare(fix.ground_speed_mps, "speed", 1.5e-3);
                    compare(north, "velN", 6e-4);
                    compare(east, "velE", 6e-4);
                    compare(fix.down_velocity_mps, "velD", 6e-4);
                }
                // gpsd prints 0.000 for all velocities here, but six of the packets contain other values. These packets
                // are compared one by one below.
                Protocol::Tsip => {}
            }
            if capture.time == Agreement::DateAndTime {
                let ours = fix.time.and_then(|time| time.unix_ns());
                let theirs = same.iter().find_map(|reported| reported.unix_ns);
                assert!(
                    ours.zip(theirs).is_none_or(|(a, b)| (a - b).abs() < 1_000_000),
                    "{name}: {ours:?} and {theirs:?}"
                );
            }
        }
    }
}

#[test]
fn no_capture_in_another_protocol_gives_a_fix() {
    let mut streams = 0;
    for folder in ["gpsd", "trimble", "nmea"] {
        let Some(folder) = shared(format!("captures/{folder}")) else { continue };
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let extension = path.extension().and_then(|extension| extension.to_str());
            if !matches!(extension, Some("log" | "tsip")) {
                continue;
            }
            let name = path.file_stem().unwrap().to_string_lossy().into_owned();
            let bytes = wire_bytes(&path);
            for protocol in [Protocol::Tsip, Protocol::Nmea, Protocol::Ubx] {
                let is_read = READ.iter().any(|c| c.name == name && c.protocol == protocol)
                    || (protocol == Protocol::Nmea && name.starts_with("nmea"));
                if !is_read {
                    assert_eq!(fixes_of(protocol, &bytes), [], "{name} as {protocol:?}");
                    streams += 1;
                }
            }
        }
    }
    println!("{streams} streams in another protocol, no fix");
}

#[test]
fn a_capture_cut_into_any_pieces_gives_the_same_fixes() {
    let Some(folder) = shared("captures/gpsd") else { return };
    for capture in READ {
        let bytes = wire_bytes(&folder.join(format!("{}.log", capture.name)));
        let whole = fixes_of(capture.protocol, &bytes);
        for size in [1, 2, 3, 7, 64, 255, 1_000] {
            let mut receiver = receiver(capture.protocol);
            let mut fixes = Vec::new();
            for mut piece in bytes.chunks(size) {
                while let Some(fix) = receiver.read(&mut piece, Time::ZERO) {
                    fixes.push(fix);
                }
            }
            fixes.extend(receiver.flush());
            assert_eq!(fixes, whole, "{} in pieces of {size}", capture.name);
        }
    }
}

#[test]
fn the_lassen_iq_packets_are_those_decoded_apart_from_this_project() {
    let Some(folder) = shared("captures/gpsd") else { return };
    for name in ["trimble-lassen_iq", "trimble-lassen_iq-playacar"] {
        let path = folder.join(format!("{name}.log"));
        // Offsets count from the start of the file, comments included.
        let file = fs::read(&path).unwrap();
        let first = file.len() - wire_bytes(&path).len();
        let expected: Vec<Value> = fs::read_to_string(folder.join(format!("{name}.decoded.jsonl")))
            .unwrap()
            .lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .filter(|packet: &Value| packet["k"] != "BAD")
            .collect();
        let mut framer = Framer::default();
        let mut found = Vec::new();
        for (offset, byte) in file.iter().enumerate().skip(first) {
            // The offset replaces the time of arrival.
            let arrival = Time::from_nanoseconds(offset as i64);
            let mut bytes = std::slice::from_ref(byte);
            if let Some(packet) = framer.next(&mut bytes, arrival) {
                let report = Report::read(packet.id, packet.payload).unwrap();
                let described = describe(&report, packet.arrival.nanoseconds()).to_string();
                // The found values pass through text, like the expected values. serde_json reads some decimal numbers
                // with an error of one bit.
                found.push(serde_json::from_str::<Value>(&described).unwrap());
            }
        }
        assert_eq!(found.len(), expected.len(), "{name}");
        for (found, expected) in found.iter().zip(&expected) {
            for (key, value) in found.as_object().unwrap() {
                assert_eq!(value, &expected[key], "{name}: {key} of {expected}");
            }
            assert_eq!(found["off"], expected["off"]);
        }
    }
}

/// A report in the notation of the `.decoded.jsonl` files.
fn describe(report: &Report, offset: i64) -> Value {
    let double = |value: f32| f64::from(value);
    let mut value = match report {
        Report::GpsTime(time) => json!({
            "k": "41 time", "tow": double(time.time_of_week_s), "week": time.week,
            "utc_off": double(time.utc_offset_s),
        }),
        Report::Health(health) => {
            json!({"k": "46 health", "status": health.status, "err": health.errors})
        }
        Report::MachineStatus(machine) => json!({
            "k": "4b mach", "id": machine.machine, "s1": machine.status_1, "s2": machine.status_2,
        }),
        Report::VelocityEnu(enu) => json!({
            "k": "56 enu", "e": double(enu.east_mps), "n": double(enu.north_mps),
            "u": double(enu.up_mps), "bias_rate": double(enu.clock_bias_rate_mps),
            "tof": double(enu.time_of_fix_s),
        }),
        Report::Tracking(tracking) => json!({
            "k": "5c trk", "prn": tracking.prn, "slot": tracking.channel,
            "acq": tracking.acquisition, "eph": tracking.ephemeris,
            "snr": double(tracking.signal), "tlm": double(tracking.time_of_week_s),
            "el": double(tracking.elevation_rad).to_degrees(),
            "az": double(tracking.azimuth_rad).to_degrees(),
            "old": tracking.flags[0], "msec": tracking.flags[1], "bad": tracking.flags[2],
            "coll": tracking.flags[3],
        }),
        Report::SatelliteSelection(selection) => {
            let [pdop, hdop, vdop, tdop] = selection.dilution.map(f64::from);
            json!({
                "k": "6d sel", "dim": selection.dimension, "manual": u8::from(selection.manual),
                "n": selection.prn().len(), "pdop": pdop, "hdop": hdop, "vdop": vdop,
                "tdop": tdop, "prn": selection.prn(),
            })
        }
        Report::Differential(differential) => json!({"k": "82 dgps", "mode": differential.mode}),
        Report::PositionLla(lla) => json!({
            "k": "84 lla dp", "lat": lla.latitude_rad.to_degrees(),
            "lon": lla.longitude_rad.to_degrees(), "alt": lla.height_m, "bias": lla.clock_bias_m,
            "tof": double(lla.time_of_fix_s),
        }),
        Report::Superpacket(packet) => {
            let degrees = |semicircles: f64| semicircles * 180.0 / f64::from(1u32 << 31);
            let [east, north, up] = packet.velocity_counts;
            let mps = |counts: i16| f64::from(counts) * packet.velocity_step_mps;
            let longitude_deg = degrees(f64::from(packet.longitude_semicircles));
            let used = packet.issues().iter().filter(|issue| issue.prn != 0);
            json!({
                "k": "8f-20", "e": mps(east), "n": mps(north), "u": mps(up),
                "raw": packet.velocity_counts, "scale": packet.velocity_step_mps,
                "tow": f64::from(packet.time_of_week_ms) / 1e3,
                "lat": degrees(f64::from(packet.latitude_semicircles)),
                "lon": if longitude_deg > 180.0 { longitude_deg - 360.0 } else { longitude_deg },
                "alt": f64::from(packet.height_mm) / 1e3, "datum": packet.datum,
                "flags": packet.fix, "nsv": packet.satellites, "leap": packet.leap_seconds,
                "week": packet.week,
                "sv": used.map(|issue| [issue.prn, issue.issue]).collect::<Vec<_>>(),
                "len": 40 + 2 * packet.issues().len(),
            })
        }
        other => panic!("{other:?} is not in these captures"),
    };
    value["off"] = offset.into();
    value
}
