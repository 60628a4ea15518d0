//! Faults of logs. Each must cause a warning with its correct name, or no loss of data.

use std::fmt::Write as _;
use std::fs;

use hovernav_formats::{Log, Options, Proposal, open, open_bytes};

use crate::alike::{Flight, dataflash, mcap, message, tables, ulog, warns, written};
use hovernav_findings::check_fitness;

fn of_bytes(bytes: &[u8]) -> Log {
    open_bytes(bytes, "log".as_ref(), &Options::default()).unwrap()
}

/// An NMEA 0183 sentence without a date: time of day, s after midnight, and position.
pub fn gga(time_s: u32) -> Vec<u8> {
    let body = format!(
        "GPGGA,{:02}{:02}{:02}.00,4700.{time_s:04},N,00800.0000,E,1,08,1.0,400.0,M,0.0,M,,",
        time_s / 3600,
        time_s / 60 % 60,
        time_s % 60
    );
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

/// UBX NAV-PVT on Sunday, 7 January 2024, with 18 leap seconds.
pub fn pvt(time_s: u32) -> Vec<u8> {
    let mut payload = vec![0; 92];
    payload[..4].copy_from_slice(&(1000 * (time_s + 18)).to_le_bytes());
    payload[4..6].copy_from_slice(&2024_u16.to_le_bytes());
    let clock = [time_s / 3600, time_s / 60 % 60, time_s % 60].map(|part| part as u8);
    payload[6..11].copy_from_slice(&[1, 7, clock[0], clock[1], clock[2]]);
    payload[11] = 7;
    payload[20..24].copy_from_slice(&[3, 1, 0, 12]);
    for (at, value) in [(24, 80_000_000), (28, 470_000_000 + time_s as i32), (32, 400_000)] {
        payload[at..at + 4].copy_from_slice(&i32::to_le_bytes(value));
    }
    for at in [40, 44, 68] {
        payload[at..at + 4].copy_from_slice(&500_u32.to_le_bytes());
    }
    let body = [&[1, 7, 92, 0][..], &payload].concat();
    let sums = body.iter().fold([0_u8; 2], |[a, b], byte| {
        let a = a.wrapping_add(*byte);
        [a, b.wrapping_add(a)]
    });
    [&[0xB5, 0x62][..], &body, &sums].concat()
}

#[test]
fn a_change_of_protocol_loses_no_fix_where_one_of_the_two_has_no_date() {
    for (ubx, nmea) in [(1000..1080, 1080..1120), (1040..1120, 1000..1040)] {
        let mut parts = [(ubx.start, ubx.clone().flat_map(pvt).collect::<Vec<u8>>())].to_vec();
        parts.push((nmea.start, nmea.clone().flat_map(gga).collect()));
        parts.sort_by_key(|(start, _)| *start);
        let bytes: Vec<u8> = parts.into_iter().flat_map(|(_, bytes)| bytes).collect();
        let dataset = of_bytes(&bytes).dataset;
        assert_eq!(dataset.fixes.len(), 120, "{:?} {:?}", dataset.warnings, dataset.notes);
        let length_s = dataset.fixes[119].time - dataset.fixes[0].time;
        assert!((length_s - 119.0).abs() < 1e-6, "{length_s}");
        assert!(!warns(&dataset, "without a time"), "{:?}", dataset.warnings);
    }
    // With both protocols there is one fix each epoch.
    let both: Vec<u8> = (1000..1060).flat_map(|t| [pvt(t), gga(t)].concat()).collect();
    assert_eq!(of_bytes(&both).dataset.fixes.len(), 60);
}

#[test]
fn zeros_within_a_text_are_reported_and_the_rest_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let files = tables(&Flight::at_rest(1.0), folder.path(), "time_s", "ax,ay,az");
    Proposal::of(&files).unwrap().write(folder.path(), true).unwrap();
    let text = fs::read(&files[0]).unwrap();
    // A power failure occurs within row 400: the file system returns zeros.
    let line = text.iter().enumerate().filter(|(_, byte)| **byte == b'\n').nth(399).unwrap().0;
    for count in [3, 65_535, 65_536, 200_000] {
        let zeros = vec![0; count];
        fs::write(&files[0], [&text[..line + 5], &zeros, &text[line + 5..]].concat()).unwrap();
        let dataset = open(folder.path(), &Options::default()).unwrap().dataset;
        assert_eq!(dataset.imu.len(), 999, "{count} zeros: {:?}", dataset.warnings);
        let expected = format!("imu.csv: line 401: {count} zero bytes");
        assert!(warns(&dataset, &expected), "{:?}", dataset.warnings);
    }
    fs::write(&files[0], [&text[..], &[0; 100_000]].concat()).unwrap();
    let dataset = open(folder.path(), &Options::default()).unwrap().dataset;
    assert_eq!(dataset.imu.len(), 1000, "{:?}", dataset.warnings);
}

#[test]
fn type_1_is_no_fix_where_there_is_type_3() {
    for format in ["dataset", "text"] {
        let log = written(&Flight::at_rest(1.0), format);
        let folder =
            if format == "dataset" { log.path.clone() } else { log.path.parent().unwrap().into() };
        let file = folder.join("gps.csv");
        let text = fs::read_to_string(&file).unwrap();
        let typed = |types: [u32; 3]| {
            let mut typed = String::new();
            for (row, line) in text.lines().enumerate() {
                let fix_type = types[if row < 4 { 0 } else { 1 + row % 2 }];
                let line = line.strip_suffix(",3").map(|line| format!("{line},{fix_type}"));
                let line = line.unwrap_or_else(|| text.lines().next().unwrap().to_owned());
                writeln!(typed, "{line}").unwrap();
            }
            fs::write(&file, typed).unwrap();
            log.read()
        };
        let dataset = typed([1, 3, 3]);
        assert_eq!(dataset.fixes.len(), 17, "{format}: {:?}", dataset.warnings);
        assert!(warns(&dataset, "no fix, type 1"), "{format}: {:?}", dataset.warnings);
        let dataset = typed([1, 2, 3]);
        let flat = dataset.fixes.iter().filter(|fix| fix.two_dimensional).count();
        assert_eq!((dataset.fixes.len(), flat), (17, 9), "{format}: {:?}", dataset.warnings);
        // In NMEA 0183, 1 and 2 are without and with corrections, 4 and 5 are RTK.
        let dataset = typed([1, 2, 4]);
        let flat = dataset.fixes.iter().filter(|fix| fix.two_dimensional).count();
        assert_eq!((dataset.fixes.len(), flat), (20, 0), "{format}: {:?}", dataset.warnings);
    }
}

#[test]
fn commas_in_a_message_are_no_decimal_commas() {
    let format = "FMT, 131, 75, MSG, QZ, TimeUS,Message\n";
    let text = "MSG, 1000000, ArduCopter V4.5.1 (abc), frame: QUAD, X\n";
    let log = [format, text, &dataflash(&Flight::at_rest(1.0))].concat();
    let dataset = of_bytes(log.as_bytes()).dataset;
    assert!(!warns(&dataset, "commas"), "{:?}", dataset.warnings);
    assert_eq!(dataset.manifest.vehicle, "ArduCopter V4.5.1 (abc), frame: QUAD, X");
    assert_eq!(dataset.imu.len(), 1000);
}

#[test]
fn unhealthy_sensors_are_named_as_the_reason() {
    let log = dataflash(&Flight::at_rest(1.0));
    let sick = log.replace(", -9.81, 1, 1", ", -9.81, 0, 1");
    let dataset = of_bytes(sick.as_bytes()).dataset;
    let refusal = check_fitness(&dataset, "log".as_ref()).unwrap_err().to_string();
    assert!(refusal.contains("marks the gyro or the accelerometer as unhealthy"), "{refusal}");
    let baro = "FMT, 131, 50, BARO, QBfB, TimeUS,I,Alt,Health\nBARO, 1000000, 0, 400, 0\n";
    let dataset = of_bytes([&log, baro].concat().as_bytes()).dataset;
    assert!(warns(&dataset, "marks the barometer as unhealthy"), "{:?}", dataset.warnings);
}

#[test]
fn a_receiver_at_rest_with_coarse_numbers_repeats_nothing() {
    let mut flight = Flight::at_rest(1.0);
    let first = flight.fixes[0];
    // The log has 5 Hz. On average every eighth fix differs, at irregular intervals.
    let mut state = 1_u32;
    let mut height_m = 400.0;
    flight.samples_s = (0..5000).map(|k| 1.0 + 0.02 * f64::from(k)).collect();
    flight.fixes = (0..500)
        .map(|k| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            height_m += if state >> 29 == 0 { 0.1 } else { 0.0 };
            crate::alike::Row { time_s: 1.01 + 0.2 * f64::from(k), height_m, ..first }
        })
        .collect();
    for format in ["dataset", "text", "mcap"] {
        let dataset = written(&flight, format).read();
        assert_eq!(dataset.fixes.len(), 500, "{format}: {:?}", dataset.warnings);
    }
}

#[test]
fn the_onboard_solution_follows_the_clock_of_the_samples() {
    let mut flight = Flight::at_rest(100.0);
    let back = |time_s: &mut f64| *time_s -= if *time_s > 110.0 { 2.0 } else { 0.0 };
    flight.samples_s.iter_mut().for_each(back);
    flight.fixes.iter_mut().for_each(|row| back(&mut row.time_s));
    let log = ulog(&flight);
    // The log has a message of a topic before each sample.
    let mut at = 16;
    let mut with = log[..at].to_vec();
    with.extend(message(b'F', b"vehicle_attitude:uint64_t timestamp;float[4] q;"));
    with.extend(message(b'A', b"\x00\x02\x00vehicle_attitude"));
    while at < log.len() {
        let end = at + 3 + usize::from(u16::from_le_bytes([log[at], log[at + 1]]));
        if log[at + 2] == b'D' && log[at + 3] == 0 {
            let quaternion = [1.0_f32, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat();
            with.extend(message(b'D', &[&[2, 0], &log[at + 5..at + 13], &quaternion].concat()));
        }
        with.extend(&log[at..end]);
        at = end;
    }
    let Log { dataset, onboard, .. } = of_bytes(&with);
    let moments = onboard.unwrap().moments;
    assert_eq!((dataset.imu.len(), moments.len()), (1000, 1000));
    for (sample, moment) in dataset.imu.iter().zip(&moments) {
        assert!((sample.time - moment.time).abs() < 1e-3, "{:?}", sample.time);
    }
}

#[test]
fn a_restart_near_the_first_time_loses_no_row() {
    let mut flight = Flight::at_rest(100.0);
    for time_s in &mut flight.samples_s {
        *time_s -= if *time_s > 103.5 { 3.1 } else { 0.0 };
    }
    for row in &mut flight.fixes {
        row.time_s -= if row.time_s > 103.5 { 3.1 } else { 0.0 };
    }
    for format in crate::alike::FORMATS {
        let dataset = written(&flight, format).read();
        let counts = (dataset.imu.len(), dataset.fixes.len());
        assert_eq!(counts, (1000, 20), "{format}: {:?}", dataset.warnings);
    }
}

#[test]
fn a_bag_is_the_files_that_its_metadata_lists() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // The names do not state the order. The last file is of another flight.
    for (name, start_s) in [("b.mcap", 1.0), ("a.mcap", 21.0), ("other.mcap", 41.0)] {
        fs::write(path(name), mcap(&Flight::at_rest(start_s))).unwrap();
    }
    let metadata = |files: &str| {
        let text =
            format!("rosbag2_bagfile_information:\n  relative_file_paths:\n{files}  duration:\n");
        fs::write(path("metadata.yaml"), text).unwrap();
        open(folder.path(), &Options::default()).unwrap().dataset
    };
    let dataset = metadata("    - b.mcap\n    - \"a.mcap\"\n");
    assert_eq!((dataset.imu.len(), dataset.fixes.len()), (2000, 40), "{:?}", dataset.warnings);
    assert!(warns(&dataset, "other.mcap is not listed"), "{:?}", dataset.warnings);
    let dataset = metadata("    - b.mcap\n    - c.mcap\n");
    assert_eq!(dataset.imu.len(), 1000, "{:?}", dataset.warnings);
    assert!(warns(&dataset, "c.mcap is missing"), "{:?}", dataset.warnings);
}

#[test]
fn a_header_in_the_middle_of_a_table_is_skipped() {
    let log = written(&Flight::at_rest(1.0), "dataset");
    let file = log.path.join("imu.csv");
    let text = fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let twice = [&lines[..500], &lines[..1], &lines[500..]].concat().join("\n");
    fs::write(&file, twice).unwrap();
    let dataset = log.read();
    assert_eq!(dataset.imu.len(), 1000, "{:?}", dataset.warnings);
    let expected = "imu.csv: line 501 skipped: repeats the header";
    assert!(warns(&dataset, expected), "{:?}", dataset.warnings);
}

#[test]
fn a_table_that_is_no_text_is_named() {
    let log = written(&Flight::at_rest(1.0), "dataset");
    let utf16: Vec<u8> = "\u{feff}t_s,".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (bytes, expected) in [
        (&b"\x1f\x8b\x08\x00\x00abc,def"[..], "a gzip file (unpack it first)"),
        (&utf16, "text in UTF-16 (save it as UTF-8 first)"),
        (b"\x7fELF\x01\x02\x03", "binary data"),
    ] {
        fs::write(log.path.join("imu.csv"), bytes).unwrap();
        let error = open(&log.path, &Options::default()).unwrap_err().to_string();
        assert!(error.contains(&format!("imu.csv: found {expected}")), "{error}");
    }
}

#[test]
fn a_line_without_end_costs_only_itself() {
    let flight = Flight::at_rest(1.0);
    let whole = dataflash(&flight);
    let lines: Vec<&str> = whole.lines().collect();
    let long = format!("IMU, {}", "1".repeat(100_000));
    let text = [&lines[..200], &[&long], &lines[200..]].concat().join("\n") + "\n";
    let log = open_bytes(text.as_bytes(), "flight.log".as_ref(), &Options::default()).unwrap();
    assert_eq!(log.dataset.imu.len(), 1000, "{:?}", log.dataset.warnings);
    assert!(warns(&log.dataset, "line of more than 16384 bytes; ignored"));
}

#[test]
fn a_velocity_for_unknown_ones_is_no_velocity_in_any_format() {
    let mut flight = Flight::at_rest(1.0);
    for (k, row) in flight.fixes.iter_mut().enumerate() {
        row.north_mps = if k % 7 == 3 { 655.35 } else { 0.1 };
    }
    for format in crate::alike::FORMATS {
        let dataset = written(&flight, format).read();
        let fastest = dataset.fixes.iter().filter_map(|fix| fix.horizontal_velocity_mps);
        let fastest_mps = fastest.map(|[north, _]| north.abs()).fold(0.0, f64::max);
        assert_eq!(dataset.fixes.len(), 20, "{format}: {:?}", dataset.warnings);
        assert!((0.05..0.2).contains(&fastest_mps), "{format}: {fastest_mps}");
    }
}
