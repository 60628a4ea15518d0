//! Flight records: inputs that begin like one, and any bytes in a chunk with a valid checksum.
#![no_main]

use std::path::Path;

use hovernav_record::{Record, RecordInfo};
use libfuzzer_sys::fuzz_target;

/// A configuration of minimal length, because every input reads it again.
const CONFIGURATION: &[u8] = br#"{"version":"0","start_ns":0,"start_unix_ns":0,"fly_toml":
    "[dmu]\nport='a'\n[receiver]\nport='b'\nprotocol='ubx'"}"#;

fuzz_target!(|data: &[u8]| {
    if data.starts_with(b"\x89MCAP") {
        return check(data);
    }
    // Without topics in the file, the writer's own numbers of topics apply: the first one is the configuration.
    let mut message = vec![5];
    message.extend((22 + CONFIGURATION.len() as u64).to_le_bytes());
    message.extend([1, 0]);
    message.extend([0; 20]);
    message.extend(CONFIGURATION);
    check(&[b"\x89MCAP0\r\n", &chunk(&message)[..], &chunk(data)].concat());
});

fn check(file: &[u8]) {
    if let Ok(record) = Record::read(file, Path::new("fuzzed.mcap")) {
        let _ = RecordInfo(&record).to_string();
        let _ = record.reproduced_by(&record.solutions);
        let _ = record.dataset();
    }
}

/// A chunk of `records`, as MCAP frames it.
fn chunk(records: &[u8]) -> Vec<u8> {
    let length = (records.len() as u64).to_le_bytes();
    let mut body = vec![0; 16];
    body.extend(length);
    body.extend(crc32(records).to_le_bytes());
    body.extend([0; 4]);
    body.extend(length);
    body.extend(records);
    let mut chunk = vec![6];
    chunk.extend((body.len() as u64).to_le_bytes());
    chunk.extend(body);
    chunk
}

/// The CRC-32 of zip files, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 }
        })
    })
}
