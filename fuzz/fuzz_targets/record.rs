//! Flight records: any bytes, and any bytes in a chunk whose checksum holds.
#![no_main]

use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};

use hovernav_log::FlyConfig;
use hovernav_log::record::{Header, Record, RecordInfo, Recorder};
use hovernav::time::Time;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    check(data);
    let mut file = beginning().clone();
    file.extend(chunk(data));
    check(&file);
});

fn check(file: &[u8]) {
    if let Ok(record) = Record::read(file, Path::new("fuzzed.mcap")) {
        let _ = RecordInfo(&record).to_string();
        let _ = record.reproduced_by(&record.solutions);
        let _ = record.dataset();
    }
}

/// The first bytes of a record: its topics and configuration.
fn beginning() -> &'static Vec<u8> {
    static BEGINNING: OnceLock<Vec<u8>> = OnceLock::new();
    BEGINNING.get_or_init(|| {
        let disk = Disk::default();
        let header = Header::new(FlyConfig::default(), Time::ZERO, 0);
        let _recorder = Recorder::start(disk.clone(), &header).expect("memory takes everything");
        let bytes = disk.0.lock().expect("no thread panics");
        bytes.clone()
    })
}

#[derive(Clone, Default)]
struct Disk(Arc<Mutex<Vec<u8>>>);

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().expect("no thread panics").extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
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
