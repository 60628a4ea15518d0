//! The first minute of `datasets/heli-hover` as arrays in the program, and the path of `memory.x`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Number of inertial samples compiled in: a minute.
const SAMPLES: usize = 1_980;

fn rows<const N: usize>(table: &Path) -> Vec<[f64; N]> {
    println!("cargo::rerun-if-changed={}", table.display());
    let text = fs::read_to_string(table).expect("the repository holds the flight");
    let number = |field: &str| field.trim().parse().expect("a number");
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(number).collect();
        <[f64; N]>::try_from(numbers).expect("as many columns as the header has")
    };
    text.lines().skip(1).map(row).collect()
}

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo names it"));
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo names it"));
    let flight = here.join("../../datasets/heli-hover");
    let mut imu = rows::<13>(&flight.join("imu.csv"));
    imu.truncate(SAMPLES);
    let end_s = imu.last().expect("samples")[0];
    let mut gps = rows::<11>(&flight.join("gps.csv"));
    gps.retain(|row| row[0] < end_s);

    // Debug output of an f64 reads back as the same bits.
    let mut text = String::new();
    let (samples, fixes) = (imu.len(), gps.len());
    writeln!(text, "static IMU: [[f64; 13]; {samples}] = {imu:?};").expect("memory");
    writeln!(text, "static GPS: [[f64; 11]; {fixes}] = {gps:?};").expect("memory");
    fs::write(out.join("flight.rs"), text).expect("cargo's directory can be written");

    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "none") {
        fs::copy(here.join("memory.x"), out.join("memory.x")).expect("as above");
        println!("cargo::rustc-link-search={}", out.display());
        println!("cargo::rustc-link-arg-bin=emulated=-Tlink.x");
    }
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory.x");
}
