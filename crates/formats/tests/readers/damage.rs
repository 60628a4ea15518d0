//! Damaged, truncated and foreign files: the readable part is used, or the file is rejected. No reader panics,
//! hangs or allocates without limit.
//!
//! `HOVERNAV_MUTATIONS` is the number of damaged files per reader, 300 by default.

use std::path::Path;

use hovernav_dataset::LogError;
use hovernav_formats::{Log, Options, open, open_bytes};
use hovernav_testing::shared;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn shared_log(name: &str) -> Option<Vec<u8>> {
    shared(format!("logs/{name}")).map(|path| std::fs::read(path).unwrap())
}

fn read(bytes: &[u8]) -> Result<Log, LogError> {
    open_bytes(bytes, Path::new("log"), &Options::default())
}

/// The first messages of a telemetry log, made by this test: attitudes and inertial samples of MAVLink 1.
fn telemetry() -> Vec<u8> {
    let crc = |bytes: &[u8]| {
        bytes.iter().fold(0xFFFF_u16, |crc, &byte| {
            let mut low = byte ^ crc as u8;
            low ^= low << 4;
            let low = u16::from(low);
            (crc >> 8) ^ (low << 8) ^ (low << 3) ^ (low >> 4)
        })
    };
    let mut log = Vec::new();
    let mut put = |index: u32, number: u8, seed: u8, payload: &[u8]| {
        log.extend((1_700_000_000_000_000 + 20_000 * u64::from(index)).to_be_bytes());
        let mut frame = vec![payload.len() as u8, index as u8, 1, 1, number];
        frame.extend(payload);
        let sum = crc(&[&frame[..], &[seed]].concat());
        log.push(0xFE);
        log.extend(frame);
        log.extend(sum.to_le_bytes());
    };
    for index in 0..200_u32 {
        let boot_ms = (20 * index).to_le_bytes();
        let mut imu = boot_ms.to_vec();
        for value in [10_i16, -20, -1000, 3, -4, 5 + index as i16, 200, 10, 450] {
            imu.extend(value.to_le_bytes());
        }
        put(index, 26, 170, &imu);
        let mut fix = (20_000 * u64::from(index)).to_le_bytes().to_vec();
        for value in [471_234_567_i32, 85_123_456, 500_000] {
            fix.extend(value.to_le_bytes());
        }
        fix.extend([80, 0, 120, 0, 250, 0, 0x28, 0x23, 3, 11]);
        put(index, 24, 24, &fix);
    }
    log
}

#[test]
fn a_telemetry_log_is_read() {
    let log = read(&telemetry()).unwrap();
    assert_eq!(log.dataset.imu.len(), 200);
    assert_eq!(log.dataset.fixes.len(), 200);
}

#[test]
fn a_truncated_log_gives_its_complete_messages_or_an_error() {
    for name in ["px4-quad-vibration-2025.ulg", "ardupilot-short.bin"] {
        let Some(bytes) = shared_log(name) else { continue };
        let whole = read(&bytes).unwrap().dataset.imu.len();
        let mut last = 0;
        for tenths in 1..10 {
            let length = bytes.len() * tenths / 10;
            match read(&bytes[..length]) {
                Ok(log) => {
                    let found = log.dataset.imu.len();
                    assert!(found >= last && found <= whole);
                    last = found;
                    let says = |warning: &String| {
                        warning.starts_with("at byte ") && warning.ends_with(", which is ignored")
                    };
                    assert!(log.dataset.warnings.iter().any(says), "{:?}", log.dataset.warnings);
                }
                Err(error) => {
                    let error = error.to_string();
                    assert!(error.contains("without inertial samples"), "{error}");
                }
            }
        }
        assert!(last > whole / 2, "{name}: {last} of {whole}");
    }
}

#[test]
fn a_stretch_of_garbage_costs_only_what_it_covers() {
    for name in ["px4-quad-vibration-2025.ulg", "ardupilot-bench.bin"] {
        let Some(mut bytes) = shared_log(name) else { continue };
        let whole = read(&bytes).unwrap().dataset.imu.len();
        let middle = bytes.len() / 2;
        bytes[middle..middle + 2000].fill(0x55);
        let log = read(&bytes).unwrap();
        assert!(log.dataset.imu.len() + 100 >= whole, "{name}: {}", log.dataset.imu.len());
        let place = log.dataset.warnings.iter().find_map(|warning| {
            let (place, _) = warning.strip_prefix("at byte ")?.split_once(':')?;
            place.parse::<usize>().ok()
        });
        let place = place.unwrap();
        assert!((middle - 70_000..=middle + 2000).contains(&place), "{place}, damaged at {middle}");
    }
}

#[test]
fn errors_name_the_type_of_foreign_files() {
    let error = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    assert!(error(b"\x1f\x8b\x08\0").starts_with("log: at byte 0: found a gzip file"));
    assert!(error(b"").starts_with("log: at byte 0: found an empty file"));
    assert!(
        error(b"ULog\x01\x12\x35\x01").contains("found a PX4 ULog that ends within its header")
    );
    let missing = open(Path::new("no such log"), &Options::default()).unwrap_err();
    assert!(matches!(missing, LogError::Io { .. }));
    #[cfg(unix)]
    {
        let device = open(Path::new("/dev/zero"), &Options::default()).unwrap_err().to_string();
        assert_eq!(device, "/dev/zero: found a pipe or a device, expected a file or a directory");
    }
}

/// A damaged copy of `seed`, in `bytes`.
fn mutate(seed: &[u8], other: &[u8], random: &mut ChaCha8Rng, bytes: &mut Vec<u8>) {
    bytes.clear();
    bytes.extend_from_slice(seed);
    let below = |random: &mut ChaCha8Rng, limit: usize| random.next_u64() as usize % limit.max(1);
    for _ in 0..=below(random, 8) {
        let at = below(random, bytes.len());
        match random.next_u32() % 7 {
            0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = random.next_u32() as u8),
            1 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << (at % 8)),
            2 => bytes.truncate(at),
            3 => {
                let end = (at + below(random, 64)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            4 => {
                let from = below(random, other.len());
                let length = below(random, 64).min(other.len() - from);
                let piece = other[from..from + length].iter().copied();
                bytes.splice(at.min(bytes.len())..at.min(bytes.len()), piece);
            }
            5 => {
                let fill = [0, 0xFF, 0x7F, 0x80][below(random, 4)];
                let length = below(random, 16);
                bytes.iter_mut().skip(at).take(length).for_each(|byte| *byte = fill);
            }
            _ => {
                let to = below(random, bytes.len());
                let length = below(random, 300);
                let piece: Vec<u8> = bytes.iter().copied().skip(at).take(length).collect();
                bytes.splice(to..to, piece);
            }
        }
    }
}

#[test]
fn damaged_logs_neither_panic_nor_hang() {
    let count = std::env::var("HOVERNAV_MUTATIONS").ok().and_then(|text| text.parse().ok());
    let count: usize = count.unwrap_or(300);
    let text = b"FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n\
        FMT, 129, 40, IMU, Qffffff, TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n\
        FMT, 130, 50, GPS, QBIHBcLLefff, TimeUS,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ\n\
        FMTU, 10, 129, s------, F000000\nMULT, 0, 70, 1e-6\nPARM, 1000, GPS_DELAY_MS, 200\n\
        IMU, 1000000, 0.1, 0.2, 0.3, 0.0, 0.1, -9.8\nGPS, 1000000, 3, 1000, 2000, 9, 1.0, 47.1, 8.5, 500, 1, 90, 0\n\
        IMU, 1020000, 0.1, 0.2, 0.4, 0.0, 0.1, -9.8\nMSG, 1030000, hello\n";
    let mut seeds: Vec<(&str, Vec<u8>)> =
        vec![("telemetry", telemetry()), ("DataFlash as text", text.to_vec())];
    for (kind, name, starts) in [
        // Damage is concentrated in the definitions and the first data after them.
        ("ULog", "sample_log_small.ulg", 90_000),
        ("ULog, old", "sample_appended_multiple.ulg", 60_000),
        ("DataFlash", "ardupilot-short.bin", 65_536),
        ("DataFlash of PX4", "ardupilot-bench.bin", 8_000),
    ] {
        if let Some(mut bytes) = shared_log(name) {
            bytes.truncate(starts);
            seeds.push((kind, bytes));
        }
    }
    let mut bytes = Vec::new();
    for (number, (kind, seed)) in seeds.iter().enumerate() {
        let mut random = ChaCha8Rng::seed_from_u64(number as u64 + 1);
        let mut read_whole = 0;
        for _ in 0..count {
            mutate(seed, &seeds[(number + 1) % seeds.len()].1, &mut random, &mut bytes);
            if let Ok(log) = read(&bytes) {
                read_whole += 1;
                assert!(log.dataset.warnings.iter().map(String::len).sum::<usize>() < 20_000);
                assert!(log.dataset.imu.len() <= bytes.len());
            }
        }
        println!("{kind}: {count} damaged files, {read_whole} read");
    }
}
