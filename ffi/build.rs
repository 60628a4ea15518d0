//! Names the shared library by the version of its binary interface, so that the system never starts a program with a
//! library of another version.

use std::env;
use std::error::Error;

/// The file with the version. The build of the package runs this again when it changes.
const SOURCE: &str = include_str!("src/object.rs");

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=src/object.rs");
    let abi: u32 = SOURCE
        .lines()
        .find_map(|line| line.strip_prefix("pub const HOVERNAV_ABI: u32 = ")?.strip_suffix(';'))
        .ok_or("found no `pub const HOVERNAV_ABI: u32 = ` in src/object.rs, expected one")?
        .parse()?;
    // Only for ELF shared libraries: elsewhere the option has another name or does not exist.
    let elf = ["android", "dragonfly", "freebsd", "linux", "netbsd", "openbsd"];
    if elf.contains(&env::var("CARGO_CFG_TARGET_OS")?.as_str()) {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libhovernav_c.so.{abi}");
    }
    Ok(())
}
