//! `include/hovernav.h` is up to date with its source.

use std::fs;
use std::path::Path;

fn header() -> String {
    let place = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(place.join("cbindgen.toml")).unwrap();
    let bindings =
        cbindgen::Builder::new().with_crate(place).with_config(config).generate().unwrap();
    let mut bytes = Vec::new();
    bindings.write(&mut bytes);
    readable(&String::from_utf8(bytes).unwrap())
}

/// The generator's text without the parts that C does not need. These parts are conditions for Rust, the prefix of a
/// type before the name of a constant, and the three declarations of each enumeration.
fn readable(text: &str) -> String {
    let text = text
        .replace("HovernavHOVERNAV_", "HOVERNAV_")
        .replace("struct HovernavHovernav", "struct Hovernav")
        .replace("HovernavHovernav", "Hovernav");
    let mut lines: Vec<String> = Vec::new();
    let mut source = text.lines().map(str::trim_end).peekable();
    while let Some(line) = source.next() {
        if line == "// # Safety" {
            while source.peek().is_some_and(|line| line.starts_with("//")) {
                source.next();
            }
            while lines.last().is_some_and(|line| line == "//") {
                lines.pop();
            }
        } else if let Some(name) = line.strip_prefix("enum ").filter(|_| !line.contains('{')) {
            // The lines of an enumeration: condition, type, end of the condition, brace.
            let kind = source.nth(1).unwrap().trim_start_matches([' ', ':']).to_owned();
            source.nth(1);
            lines.push(format!("typedef {kind} {name};"));
            lines.push("enum {".to_owned());
        } else if line == "#ifndef __cplusplus" {
            source.by_ref().find(|line| *line == "#endif // __cplusplus");
        } else {
            lines.push(line.to_owned());
        }
    }
    lines.join("\n") + "\n"
}

#[test]
fn the_header_is_fresh() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/hovernav.h");
    let made = header();
    if std::env::var_os("HOVERNAV_WRITE_HEADER").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    let different = made.lines().zip(kept.lines()).position(|(made, kept)| made != kept);
    assert!(
        made == kept,
        "{} is stale from line {} on: HOVERNAV_WRITE_HEADER=1 cargo test -p hovernav-ffi --test interface header::",
        path.display(),
        different.map_or(made.lines().count().min(kept.lines().count()), |line| line) + 1
    );
}
