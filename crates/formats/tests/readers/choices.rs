//! Choice of the sensor to read if one of several is dead or frozen.

use std::fmt::Write as _;

use hovernav::gps::Fix;
use hovernav_dataset::Dataset;
use hovernav_formats::{Options, open_bytes};

use crate::alike::{FORMATS, Flight, Row, dataflash, message, ulog, written};

fn read(bytes: &[u8]) -> Dataset {
    open_bytes(bytes, "log".as_ref(), &Options::default()).unwrap().dataset
}

fn notes(dataset: &Dataset, words: &str) -> bool {
    dataset.notes.iter().any(|note| note.contains(words))
}

/// A ULog with the messages of one more topic. `other` makes the body of each from a message of the topic `of` and its
/// number.
fn with_another(
    log: &[u8],
    (instance, definition, name): (u8, &str, &str),
    of: u8,
    other: impl Fn(&mut [u8], f32) -> Vec<u8>,
) -> Vec<u8> {
    let (mut at, mut number) = (16, 0.0);
    let mut with = log[..at].to_vec();
    with.extend(message(b'F', definition.as_bytes()));
    while at < log.len() {
        let end = at + 3 + usize::from(u16::from_le_bytes([log[at], log[at + 1]]));
        let (kind, mut body) = (log[at + 2], log[at + 3..end].to_vec());
        if kind == b'D' && body[0] == of {
            if number == 0.0 {
                with.extend(message(b'A', &[&[instance, 7, 0], name.as_bytes()].concat()));
            }
            number += 1.0;
            let another = other(&mut body, number);
            with.extend(message(b'D', &[&[7, 0], &another[..]].concat()));
        }
        with.extend(message(kind, &body));
        at = end;
    }
    with
}

#[test]
fn vehicle_imu_is_read_where_sensor_combined_is_all_zero() {
    let definition = "vehicle_imu:uint64_t timestamp;float[3] delta_angle;float[3] delta_velocity;\
                      uint32_t delta_angle_dt;uint32_t delta_velocity_dt;";
    let log = ulog(&Flight::at_rest(1.0));
    let log = with_another(&log, (0, definition, "vehicle_imu"), 0, |body, number| {
        let values = [1e-8 * number, 0.0, 0.0, 0.0, 0.0, -0.1962_f32].map(f32::to_le_bytes);
        let dt = 20_000_u32.to_le_bytes().repeat(2);
        let another = [&body[2..10], &values.concat(), &dt].concat();
        body[10..].fill(0);
        another
    });
    let dataset = read(&log);
    assert_eq!(dataset.imu.len(), 1000, "{:?}", dataset.warnings);
    assert!(notes(&dataset, "vehicle_imu 0 (1000 messages) is read"), "{:?}", dataset.notes);
}

#[test]
fn a_frozen_unit_is_not_read_where_another_changes() {
    let definition = "another:uint8_t nothing;";
    let log = ulog(&Flight::at_rest(1.0));
    let log = with_another(&log, (1, definition, "sensor_combined"), 0, |body, number| {
        [&body[2..10], &(1e-6 * number).to_le_bytes(), &body[14..]].concat()
    });
    let dataset = read(&log);
    assert!(notes(&dataset, "sensor_combined 1 (1000 messages) is read"), "{:?}", dataset.notes);

    let mut text = String::new();
    for (number, line) in dataflash(&Flight::at_rest(1.0)).lines().enumerate() {
        writeln!(text, "{line}").unwrap();
        if let Some(time) = line.strip_prefix("IMU, ").and_then(|rest| rest.split(", ").next()) {
            let rate = 1e-6 * number as f64;
            writeln!(text, "IMU, {time}, 1, {rate}, 0, 0, 0.01, 0, -9.81, 1, 1").unwrap();
        }
    }
    let dataset = read(text.as_bytes());
    assert!(notes(&dataset, "IMU 1 (1000 messages) is read"), "{:?}", dataset.notes);
}

#[test]
fn a_frozen_receiver_is_not_read_where_another_changes() {
    let mut flight = Flight::at_rest(1.0);
    let first = flight.fixes[0];
    flight.fixes = (0..200).map(|k| Row { time_s: 1.01 + 0.1 * f64::from(k), ..first }).collect();
    let definition = "another:uint8_t nothing;";
    let name = "vehicle_gps_position";
    let log = with_another(&ulog(&flight), (1, definition, name), 1, |body, number| {
        let lat_deg = 47.0 + 1e-6 * f64::from(number);
        [&body[2..10], &lat_deg.to_le_bytes(), &body[18..]].concat()
    });
    let dataset = read(&log);
    assert!(
        notes(&dataset, "vehicle_gps_position 1 (200 messages) is read"),
        "{:?}",
        dataset.notes
    );
}

#[test]
fn a_receiver_in_static_hold_loses_and_one_at_rest_does_not() {
    /// Latitude, degrees, and speed, m/s, of two receivers.
    type Readings = fn(f64) -> [(f64, f64); 2];
    let cases: [(&str, Readings, usize); 5] = [
        ("position in hold", |t| [(47.0, 3.1), (47.0 + 2.7e-5 * t, 3.0)], 1),
        ("velocity in hold", |t| [(47.0 + 2.7e-5 * t, 0.0), (47.0 + 2.7e-5 * t, 3.0)], 1),
        ("the second in hold", |t| [(47.0 + 2.7e-5 * t, 3.0), (47.0, 0.0)], 0),
        ("at rest, the second noisy", |t| [(47.0, 0.0), (47.0 + 1e-5 * (9.0 * t).sin(), 0.1)], 0),
        (
            "at rest, then in motion",
            |t| {
                let moved = 2.7e-5 * (t - 40.0).max(0.0);
                let speed = if t > 40.0 { 3.0 } else { 0.0 };
                [(47.0 + moved, speed), (47.0 + moved + 1e-5 * (9.0 * t).sin(), speed + 0.1)]
            },
            0,
        ),
    ];
    for format in FORMATS.into_iter().filter(|format| *format != "dataset") {
        for (what, readings, expected) in cases {
            // The positions of a bag have no velocity.
            if format == "mcap" && what.starts_with("velocity") {
                continue;
            }
            let mut flight = Flight::at_rest(1.0);
            let first = flight.fixes[0];
            flight.samples_s = (0..1600).map(|k| 1.0 + 0.05 * f64::from(k)).collect();
            let epoch = |k: u32| {
                let time_s = 1.01 + 0.2 * f64::from(k);
                let rows = readings(time_s).into_iter().enumerate();
                rows.map(move |(receiver, (lat_deg, north_mps))| Row {
                    time_s,
                    lat_deg,
                    north_mps: if format == "mcap" { f64::NAN } else { north_mps },
                    receiver,
                    ..first
                })
            };
            flight.fixes = (0..400).flat_map(epoch).collect();
            let dataset = written(&flight, format).read();
            let is_read = |fix: &Fix| {
                let k = ((fix.time.seconds() - dataset.fixes[0].time.seconds()) / 0.2).round();
                let (lat_deg, _) = readings(1.01 + 0.2 * k)[expected];
                (fix.position.latitude_deg() - lat_deg).abs() < 2e-7
            };
            let notes = (&dataset.notes, &dataset.warnings);
            let read = dataset.fixes.iter().filter(|fix| is_read(fix)).count();
            assert!(read > 390 && read == dataset.fixes.len(), "{format}: {what}: {notes:?}");
        }
    }
}

/// A DataFlash log in text with two units that change, where `line` makes lines from the time of each sample, µs.
fn with_two_units(line: impl Fn(&str, usize) -> String) -> String {
    let mut text = String::new();
    let log = dataflash(&Flight::at_rest(1.0));
    for (number, of_first) in log.lines().enumerate() {
        let time = of_first.strip_prefix("IMU, ").and_then(|rest| rest.split(", ").next());
        match time {
            Some(time) => text += &line(time, number),
            None => writeln!(text, "{of_first}").unwrap(),
        }
    }
    text
}

fn unit(time: &str, number: usize, instance: usize, rest: &str) -> String {
    let rate = 1e-6 * number as f64;
    format!("IMU, {time}, {instance}, {rate}, 0, 0, 0.01, 0, -9.81, 1, 1{rest}\n")
}

#[test]
fn the_unit_of_the_primary_core_is_read() {
    let formats = "FMT, 64, 31, PARM, QNf, TimeUS,Name,Value\n\
                   FMT, 131, 13, XKF4, QBB, TimeUS,C,PI\n";
    for (parameter, primary, expected) in
        [("", 0, 0), ("", 1, 1), ("PARM, 0, EK3_IMU_MASK, 2\n", 0, 1)]
    {
        let text = with_two_units(|time, number| {
            let [first, second] = [0, 1].map(|instance| unit(time, number, instance, ""));
            format!("{first}{second}XKF4, {time}, 0, {primary}\nXKF4, {time}, 1, {primary}\n")
        });
        let dataset = read(format!("{formats}{parameter}{text}").as_bytes());
        let words = format!("IMU {expected} (1000 messages) is read");
        assert!(notes(&dataset, &words), "{parameter} {primary}: {:?}", dataset.notes);
    }
}

#[test]
fn a_unit_that_counts_errors_is_not_read_where_another_counts_none() {
    let counters = "BBII, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,GH,AH,EG,EA";
    for (gyro_errors, force_errors, expected) in [(0, 0, 0), (1, 0, 1), (0, 1, 1)] {
        let text = with_two_units(|time, number| {
            let errors = [gyro_errors, force_errors].map(|each| each * number / 4);
            let first = unit(time, number, 0, &format!(", {}, {}", errors[0], errors[1]));
            first + &unit(time, number, 1, ", 7, 7")
        });
        let text = text.replacen("BB, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,GH,AH", counters, 1);
        let dataset = read(text.as_bytes());
        let words = format!("inertial unit: IMU {expected} (1000 messages");
        assert!(notes(&dataset, &words), "{gyro_errors} {force_errors}: {:?}", dataset.notes);
    }
}

#[test]
fn the_receiver_in_use_is_read() {
    let mut flight = Flight::at_rest(1.0);
    let epoch = |k: u32| {
        let time_s = 1.01 + 0.1 * f64::from(k);
        let of = |receiver: usize| Row {
            time_s,
            receiver,
            lat_deg: 47.0 + 1e-7 * f64::from(k),
            ..flight.fixes[0]
        };
        [of(0), of(1)]
    };
    flight.fixes = (0..200).flat_map(epoch).collect();
    let log = dataflash(&flight);
    for used in 0..2 {
        // By the receiver's own message, and by the EKF's.
        let mut marked =
            log.replacen("QBBIHLLefff, ", "QBBIHLLefffB, ", 1).replacen("GCrs,VZ", "GCrs,VZ,U", 1);
        let mut selected = String::from("FMT, 132, 15, XKFS, QBBBBB, TimeUS,C,MI,BI,GI,AI\n");
        for receiver in 0..2 {
            let is_used = u8::from(receiver == used);
            let lines = marked.lines().map(|line| {
                let is_of = line.starts_with("GPS")
                    && line.split(", ").nth(2) == Some(&receiver.to_string());
                if is_of { format!("{line}, {is_used}\n") } else { format!("{line}\n") }
            });
            marked = lines.collect();
        }
        for line in log.lines() {
            writeln!(selected, "{line}").unwrap();
            if line.starts_with("GPS") {
                writeln!(selected, "XKFS, 1000000, 0, 0, 0, {used}, 0").unwrap();
            }
        }
        for text in [marked, selected] {
            let dataset = read(text.as_bytes());
            let words = format!("GPS {used} (200 messages) is read");
            assert!(notes(&dataset, &words), "{:?} {text}", dataset.notes);
        }
    }
}
