//! MCAP with ROS 2 messages: inputs that begin like one, and any bytes as records after the header.
#![no_main]

use std::path::Path;

use hovernav_formats::{Options, open_bytes};
use libfuzzer_sys::fuzz_target;

/// The magic, and a header of another library's file: profile `ros2`, library `x`.
const HEADER: &[u8] = b"\x89MCAP0\r\n\x01\x0d\0\0\0\0\0\0\0\x04\0\0\0ros2\x01\0\0\0x";

fuzz_target!(|data: &[u8]| {
    let whole = if data.starts_with(b"\x89MCAP") { data } else { &[HEADER, data].concat() };
    let _ = open_bytes(whole, Path::new("fuzzed.mcap"), &Options::default());
});
