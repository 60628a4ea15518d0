//! ROS 2 bags as users have them: without metadata, packed, cut off, damaged, and with a clock that steps.

use std::fs;
use std::path::Path;

use hovernav_dataset::Dataset;
use hovernav_formats::{Options, open, open_bytes};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use crate::alike::{Flight, mcap, ulog, warns};

fn read(bytes: &[u8]) -> Dataset {
    open_bytes(bytes, "log".as_ref(), &Options::default()).unwrap().dataset
}

fn record(kind: u8, body: &[u8]) -> Vec<u8> {
    [&[kind][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

/// The records of a file or of a chunk, with their kinds.
fn records(bytes: &[u8]) -> Vec<(u8, &[u8])> {
    let (mut found, mut rest) = (Vec::new(), bytes);
    while rest.len() >= 9 && rest[0] != 2 {
        let length = u64::from_le_bytes(rest[1..9].try_into().unwrap()) as usize;
        found.push((rest[0], &rest[9..9 + length]));
        rest = &rest[9 + length..];
    }
    found
}

/// `flight` without chunks; `after` gives the records that follow each message.
fn plain(flight: &Flight, after: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let chunked = mcap(flight);
    let mut bytes = chunked[..8].to_vec();
    for (kind, body) in records(&chunked[8..]) {
        match kind {
            1 => bytes.extend(record(1, body)),
            // Times, sizes and the empty name of the compression precede the records.
            6 => {
                for (kind, body) in records(&body[40..]) {
                    bytes.extend(record(kind, body));
                    bytes.extend(if kind == 5 { after(body) } else { Vec::new() });
                }
            }
            _ => {}
        }
    }
    [&bytes[..], &record(2, &[0; 20]), &chunked[..8]].concat()
}

#[test]
fn velocities_belong_to_fixes_of_the_same_pass_of_the_clock() {
    let mut flight = Flight::at_rest(100.0);
    for time_s in
        flight.samples_s.iter_mut().chain(flight.fixes.iter_mut().map(|row| &mut row.time_s))
    {
        *time_s -= if *time_s > 110.0 { 7.0 } else { 0.0 };
    }
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let name = text("geometry_msgs/msg/TwistStamped");
    let schema = [&[9, 0][..], &name, &text(""), &text("")].concat();
    let channel = [&[9, 0, 9, 0][..], &text("/gps/velocity"), &text("cdr"), &text("")].concat();
    let number = std::cell::Cell::new(0.0);
    let bytes = plain(&flight, |message| {
        // The fixes are the shorter messages.
        if message.len() > 200 {
            return Vec::new();
        }
        let north_mps = 0.1 * number.replace(number.get() + 1.0);
        let doubles = [0.0, north_mps, 0.0, 0.0, 0.0, 0.0_f64].map(f64::to_le_bytes).concat();
        let message = record(5, &[&[9, 0], &message[2..42], &doubles].concat());
        [record(3, &schema), record(4, &channel), message].concat()
    });
    let dataset = read(&bytes);
    assert_eq!(dataset.fixes.len(), 20, "{:?}", dataset.warnings);
    for (number, fix) in dataset.fixes.iter().enumerate() {
        let [north_mps, _] = fix.horizontal_velocity_mps.unwrap();
        assert!((north_mps - 0.1 * number as f64).abs() < 1e-9, "fix {number}: {north_mps} m/s");
    }
}

#[test]
fn a_bag_without_metadata_is_the_mcap_files_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("flight_9.mcap"), mcap(&Flight::at_rest(1.0))).unwrap();
    let second = compress_to_vec(&mcap(&Flight::at_rest(21.0))[..], CompressionLevel::Fastest);
    for ending in ["zst", "zstd"] {
        let packed = path(&format!("flight_10.mcap.{ending}"));
        fs::write(&packed, &second).unwrap();
        let dataset = open(folder.path(), &Options::default()).unwrap().dataset;
        let counts = (dataset.imu.len(), dataset.fixes.len());
        assert_eq!(counts, (2000, 40), "{ending}: {:?}", dataset.warnings);
        fs::remove_file(packed).unwrap();
    }
}

#[test]
fn a_directory_with_one_log_is_named_with_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("flight.ulg"), ulog(&Flight::at_rest(1.0))).unwrap();
    let error = open(folder.path(), &Options::default()).unwrap_err().to_string();
    assert!(error.contains("expected its log") && error.contains("flight.ulg"), "{error}");
}

/// Reads the log in a packed file of these bytes.
fn unpacked(folder: &Path, packed: &[u8]) -> Dataset {
    let path = folder.join("flight.mcap.zstd");
    fs::write(&path, packed).unwrap();
    open(&path, &Options::default()).unwrap().dataset
}

#[test]
fn a_packed_file_is_read_up_to_its_damage() {
    let folder = tempfile::tempdir().unwrap();
    let packed = compress_to_vec(&mcap(&Flight::at_rest(1.0))[..], CompressionLevel::Fastest);
    let short = folder.path().join("short.mcap.zstd");
    fs::write(&short, &packed[..500]).unwrap();
    let error = open(&short, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("the zstd file is cut off"), "{error}");
    for bytes in [plain(&Flight::at_rest(1.0), |_| Vec::new()), mcap(&Flight::at_rest(1.0))] {
        let packed = compress_to_vec(&bytes[..], CompressionLevel::Fastest);
        let cut = &packed[..packed.len() * 9 / 10];
        let mut damaged = packed.clone();
        damaged[packed.len() * 9 / 10..].fill(0xFF);
        for packed in [cut, &damaged] {
            let dataset = unpacked(folder.path(), packed);
            assert!((300..1000).contains(&dataset.imu.len()), "{:?}", dataset.warnings);
            assert!(warns(&dataset, "the file ends"), "{:?}", dataset.warnings);
            assert!(!warns(&dataset, "Error"), "{:?}", dataset.warnings);
        }
    }
}

#[test]
fn garbage_between_records_costs_only_itself() {
    let bytes = plain(&Flight::at_rest(1.0), |_| Vec::new());
    let (mut at, mut count) = (8, 0);
    while count < 300 {
        count += usize::from(bytes[at] == 5);
        at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    let random = |length: usize| {
        (0..length as u64).map(|k| (k.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56) as u8 | 1)
    };
    let zeros = std::iter::repeat_n(0, 5000);
    for garbage in [random(3).collect(), random(5000).collect(), zeros.collect::<Vec<u8>>()] {
        let dataset = read(&[&bytes[..at], &garbage, &bytes[at..]].concat());
        assert!(dataset.imu.len() >= 998, "{} {:?}", dataset.imu.len(), dataset.warnings);
        assert!(warns(&dataset, &format!("damaged at byte {at}")), "{:?}", dataset.warnings);
        assert!(warns(&dataset, "bytes skipped up to the next record"), "{:?}", dataset.warnings);
        // The garbage replaces records.
        let after = &bytes[(at + garbage.len()).min(bytes.len())..];
        let dataset = read(&[&bytes[..at], &garbage, after].concat());
        assert!(dataset.imu.len() >= 970, "{} {:?}", dataset.imu.len(), dataset.warnings);
    }
}

#[test]
fn an_infinite_height_is_unknown() {
    let mut flight = Flight::at_rest(1.0);
    flight.fixes[5].height_m = f64::INFINITY;
    for bytes in [mcap(&flight), ulog(&flight)] {
        let dataset = read(&bytes);
        assert_eq!(dataset.fixes.len(), 20, "{:?}", dataset.warnings);
        assert!(dataset.fixes[5].two_dimensional);
    }
}

/// Drivers that set no status send -2 since ROS 2 Jazzy; without a fix the status is -1.
#[test]
fn a_status_that_is_not_set_is_a_fix() {
    let mut flight = Flight::at_rest(1.0);
    flight.fixes.iter_mut().for_each(|row| row.has_fix = false);
    // Without chunks, whose checksums a change would invalidate.
    let mut bytes = plain(&flight, |_| Vec::new());
    assert_eq!(read(&bytes).fixes.len(), 0);
    for at in 0..bytes.len() {
        if bytes[at..].starts_with(&[b'a', b'b', b'c', 0, 0xFF, 0, 1, 0]) {
            bytes[at + 4] = 0xFE;
        }
    }
    assert_eq!(read(&bytes).fixes.len(), 20);
}
