//! PX4's ULog: inputs that begin like one, and any bytes after the header.
#![no_main]

use std::path::Path;

use hovernav_formats::{Options, open_bytes};
use libfuzzer_sys::fuzz_target;

const HEADER: &[u8] = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0";

fuzz_target!(|data: &[u8]| {
    let whole = if data.starts_with(b"ULog") { data } else { &[HEADER, data].concat() };
    let _ = open_bytes(whole, Path::new("fuzzed.ulg"), &Options::default());
});
