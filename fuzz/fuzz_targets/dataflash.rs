//! DataFlash logs: inputs that begin like one, and any bytes after a description of inertial samples. The bytes are
//! binary or, after an odd first byte, text.
#![no_main]

use std::path::Path;

use hovernav_formats::{Options, open_bytes};
use libfuzzer_sys::fuzz_target;

const TEXT: &[u8] = b"FMT, 129, 40, IMU, Qffffff, TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n";

fuzz_target!(|data: &[u8]| {
    let mut described = vec![0xA3, 0x95, 0x80, 129, 35];
    for (text, length) in
        [("IMU", 4), ("Qffffff", 16), ("TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ", 64)]
    {
        let end = described.len() + length;
        described.extend(text.bytes());
        described.resize(end, 0);
    }
    let whole = match data.first() {
        _ if data.starts_with(&described[..3]) || data.starts_with(b"FMT") => data,
        Some(first) if first % 2 == 1 => &[TEXT, data].concat(),
        _ => &[&described, data].concat(),
    };
    let _ = open_bytes(whole, Path::new("fuzzed.bin"), &Options::default());
});
