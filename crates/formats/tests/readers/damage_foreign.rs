//! Damaged captures, MCAP files, text and mappings are read or rejected, without panics and without excessive
//! memory.
//!
//! `HOVERNAV_MUTATIONS` is the number of damaged files per reader, 300 by default.

use std::fs;
use std::path::Path;

use hovernav_formats::{Options, Proposal, open, open_bytes};
use hovernav_testing::shared;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn mutations() -> usize {
    let count = std::env::var("HOVERNAV_MUTATIONS").ok().and_then(|text| text.parse().ok());
    count.unwrap_or(300)
}

fn capture(name: &str) -> Option<Vec<u8>> {
    shared(format!("captures/{name}")).map(|path| fs::read(path).unwrap())
}

fn below(random: &mut ChaCha8Rng, limit: usize) -> usize {
    random.next_u64() as usize % limit.max(1)
}

/// `seed` with some bytes changed, removed, inserted or repeated.
fn damaged(seed: &[u8], alphabet: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=below(random, 6) {
        let at = below(random, bytes.len());
        match below(random, 6) {
            0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << (at % 8)),
            1 => bytes.truncate(at),
            2 => {
                let end = (at + below(random, 40)).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            3 => {
                let count = 1 + below(random, 12);
                let piece: Vec<u8> =
                    (0..count).map(|_| alphabet[below(random, alphabet.len())]).collect();
                bytes.splice(at..at, piece);
            }
            4 => {
                let fill = [0, 0xFF, 0x7F, 0x80][below(random, 4)];
                let length = below(random, 12);
                bytes.iter_mut().skip(at).take(length).for_each(|byte| *byte = fill);
            }
            _ => {
                let piece: Vec<u8> =
                    bytes.iter().copied().skip(at).take(below(random, 200)).collect();
                let to = below(random, bytes.len());
                bytes.splice(to..to, piece);
            }
        }
    }
    bytes
}

/// An MCAP file with two IMUs and a receiver.
fn mcap_file() -> Vec<u8> {
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut writer = mcap::WriteOptions::new()
        .compression(None)
        .chunk_size(Some(4_000))
        .create(file.reopen().unwrap())
        .unwrap();
    let mut channels = Vec::new();
    for (topic, schema) in [
        ("/imu", "sensor_msgs/msg/Imu"),
        ("/fix", "sensor_msgs/msg/NavSatFix"),
        ("/vel", "geometry_msgs/msg/TwistStamped"),
        ("/odom", "nav_msgs/msg/Odometry"),
    ] {
        let schema = writer.add_schema(schema, "ros2msg", b"").unwrap();
        channels.push(writer.add_channel(schema, topic, "cdr", &Default::default()).unwrap());
    }
    for index in 0..40_u64 {
        for &channel_id in &channels {
            let mut data = vec![0, 1, 0, 0, 9, 0, 0, 0];
            data.extend((index as u32 * 10_000_000).to_le_bytes());
            data.extend([5, 0, 0, 0, b'b', b'a', b's', b'e', 0]);
            data.resize(700, 1);
            let log_time = 9_000_000_000 + index * 10_000_000;
            let header = mcap::records::MessageHeader {
                channel_id,
                sequence: 0,
                log_time,
                publish_time: log_time,
            };
            writer.write_to_known_channel(&header, &data).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    fs::read(file.path()).unwrap()
}

#[test]
fn damaged_bytes_neither_panic_nor_hang() {
    let mut seeds = vec![("ROS 2", mcap_file())];
    for (kind, name) in [
        ("DMU", "dmu_synthetic/clean_330.bin"),
        ("TSIP", "gpsd/trimble-lassen_iq.log"),
        ("UBX", "gpsd/ublox-neo-m8n.log"),
        ("NMEA", "gpsd/hab-gpspi.log"),
    ] {
        seeds.extend(capture(name).map(|bytes| (kind, bytes)));
    }
    let alphabet: Vec<u8> = (0..=255).collect();
    for (number, (kind, seed)) in seeds.iter().enumerate() {
        let mut random = ChaCha8Rng::seed_from_u64(100 + number as u64);
        let mut read = 0;
        for _ in 0..mutations() {
            let bytes = damaged(seed, &alphabet, &mut random);
            if let Ok(log) = open_bytes(&bytes, Path::new("log"), &Options::default()) {
                read += 1;
                assert!(log.dataset.imu.len() + log.dataset.fixes.len() <= bytes.len());
                let said: usize = log.dataset.warnings.iter().map(String::len).sum();
                assert!(said < 20_000, "{said}");
            }
        }
        println!("{kind}: {} damaged files, {read} read", mutations());
    }
}

#[test]
fn an_attachment_shorter_than_its_header_does_not_end_the_reading() {
    // 32 bytes are enough for the attachment's header but not for its checksum.
    let attachment: Vec<u8> = [&[9_u8][..], &32_u64.to_le_bytes(), &[0; 32]].concat();
    let seed = mcap_file();
    let whole = open_bytes(&seed, Path::new("log"), &Options::default()).unwrap();
    let mut bytes = seed.clone();
    bytes.splice(8..8, attachment);
    let log = open_bytes(&bytes, Path::new("log"), &Options::default()).unwrap();
    assert_eq!(log.dataset.imu.len(), whole.dataset.imu.len());
}

#[test]
fn damaged_text_neither_panics_nor_hangs() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("flight.csv");
    let out = place.path().join("mapped");
    let mut seed = String::from("time_ms;gx;gy;gz;ax;ay;az;roll;pitch;yaw;mx;my;mz;lat;lon;alt\n");
    for row in 0..60 {
        let t = f64::from(row);
        seed.push_str(&format!(
            "{};{};0,5;-1,5;0,01;0,02;1;{};2;3;20;1;40;47,1;8,5;500\n",
            30 * row,
            t.sin().to_string().replace('.', ","),
            (t / 10.0).to_string().replace('.', ",")
        ));
    }
    fs::write(&file, &seed).unwrap();
    let proposal = Proposal::of(std::slice::from_ref(&file)).unwrap();
    proposal.write(&out, false).unwrap();
    let mapping = fs::read(out.join("mapping.toml")).unwrap();
    let alphabet = b"0123456789-+.,;\t \"#eEnainf\n\r[]=xyz'\xff\0";
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let (mut proposed, mut read) = (0, 0);
    for round in 0..mutations() {
        fs::write(&file, damaged(seed.as_bytes(), alphabet, &mut random)).unwrap();
        proposed += usize::from(Proposal::of(std::slice::from_ref(&file)).is_ok());
        let damages_mapping = round % 2 == 0;
        let text = if damages_mapping {
            damaged(&mapping, alphabet, &mut random)
        } else {
            mapping.clone()
        };
        fs::write(out.join("mapping.toml"), text).unwrap();
        read += usize::from(open(&out, &Options::default()).is_ok());
    }
    println!("text: {} damaged files, {proposed} proposed, {read} read", mutations());
}
