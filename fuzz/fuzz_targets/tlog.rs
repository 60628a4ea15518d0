//! MAVLink telemetry logs: inputs that may begin with a frame, and any bytes after two frames.
#![no_main]

use std::path::Path;

use hovernav_formats::{Options, open_bytes};
use libfuzzer_sys::fuzz_target;

/// A time and an empty frame of MAVLink 1, of an unused message.
const FRAME: [u8; 16] = [0, 5, 0x9F, 0, 0, 0, 0, 0, 0xFE, 0, 0, 1, 1, 250, 0, 0];

fuzz_target!(|data: &[u8]| {
    let begins = matches!(data.get(8), Some(0xFD | 0xFE));
    let whole = if begins { data } else { &[&FRAME, &FRAME[..], data].concat() };
    let _ = open_bytes(whole, Path::new("fuzzed.tlog"), &Options::default());
});
