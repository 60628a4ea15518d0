//! Structure of the code: direction of data flow, length of files, crates under the flight core. [`pages`] checks what
//! the documentation states about the code.

mod circles;
mod pages;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn cargo(arguments: &[&str]) -> String {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(arguments)
        .args(["--offline", "--locked"])
        .current_dir(ROOT)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The workspace's packages, each with its dependencies on other packages of the workspace. Dependencies of tests do
/// not count.
fn packages() -> BTreeMap<String, BTreeSet<String>> {
    let metadata: Value =
        serde_json::from_str(&cargo(&["metadata", "--no-deps", "--format-version", "1"])).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let name = |package: &Value| package["name"].as_str().unwrap().to_owned();
    let own: BTreeSet<String> = packages.iter().map(name).collect();
    let needs = |package: &Value| -> BTreeSet<String> {
        package["dependencies"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|dependency| dependency["kind"] != "dev")
            .map(name)
            .filter(|dependency| own.contains(dependency))
            .collect()
    };
    packages.iter().map(|package| (name(package), needs(package))).collect()
}

#[test]
fn the_flight_core_is_built_on_no_other_package_of_the_house() {
    assert_eq!(packages()["hovernav"], BTreeSet::new());
}

#[test]
fn packages_form_no_cycle_and_nothing_is_built_on_the_command() {
    let mut left = packages();
    for (package, needs) in &left {
        assert!(!needs.contains("hovernav-cli"), "{package} is built on the command");
    }
    while !left.is_empty() {
        let free: Vec<String> = left
            .iter()
            .filter(|(_, needs)| needs.iter().all(|need| !left.contains_key(need)))
            .map(|(package, _)| package.clone())
            .collect();
        assert!(!free.is_empty(), "a cycle among {:?}", left.keys());
        left.retain(|package, _| !free.contains(package));
    }
}

/// The modules of the flight core in the order of the tour in `src/lib.rs`. Modules outside the tour come first. No
/// module imports one that follows it.
const TOUR: [&str; 21] = [
    "buffer",
    "scalar",
    "matrix",
    "time",
    "frames",
    "earth",
    "imu",
    "controls",
    "dmu",
    "gps",
    "event",
    "sensors",
    "setup",
    "ins",
    "ekf",
    "health",
    "prelude",
    "autopilot",
    "servo",
    "flight_control",
    "telemetry",
];

/// The modules of the tools from a recorded flight to its score, each crate's in an order of which its README states
/// the outline. No module imports one that follows it.
const TOOLS: [(&str, &[&str]); 4] = [
    (
        "dataset",
        &[
            "error",
            "statistics",
            "table",
            "clock",
            "manifest",
            "utc",
            "magnetic_field",
            "sensors",
            "columns",
            "solution",
            "trajectory",
            "reference",
            "dataset",
        ],
    ),
    ("replay", &["comparisons", "kept", "run", "inconsistent", "smoothing"]),
    (
        "findings",
        &[
            "finding",
            "limits",
            "rates",
            "sampling",
            "vibration_lines",
            "plausibility",
            "fitness",
            "events",
            "paragraph",
            "contents",
            "survey",
        ],
    ),
    ("score", &["score", "relative", "level", "consistency", "apart", "verdict"]),
];

/// The rooms of the filter in the order of `src/ekf/mod.rs`. No room imports one that follows it.
const ROOMS: [&str; 10] = [
    "settings",
    "kernel",
    "outcome",
    "watch",
    "gate",
    "heading_search",
    "filter",
    "output",
    "measurement",
    "estimator",
];

#[test]
fn data_flows_one_way_through_the_flight_core() {
    assert_one_way(Path::new(ROOT).join("src"), "crate::", &TOUR);
}

#[test]
fn data_flows_one_way_through_the_filter() {
    assert_one_way(Path::new(ROOT).join("src/ekf"), "crate::ekf::", &ROOMS);
}

#[test]
fn data_flows_one_way_from_a_dataset_to_its_score() {
    for (name, modules) in TOOLS {
        assert_one_way(Path::new(ROOT).join("crates").join(name).join("src"), "crate::", modules);
    }
}

/// Asserts that no module below `src`, the folder of the path `root`, imports one that follows it in `order`, and that
/// `order` has every module.
fn assert_one_way(src: PathBuf, root: &str, order: &[&str]) {
    for name in order {
        let is_there = src.join(name).is_dir() || src.join(name).with_extension("rs").is_file();
        assert!(is_there, "{name} is not in {}", src.display());
    }
    for path in sources().iter().filter(|path| path.starts_with(&src)) {
        let inside = path.strip_prefix(&src).unwrap().with_extension("");
        let module = inside.iter().next().unwrap().to_str().unwrap();
        if ["lib", "mod"].contains(&module) || inside.ends_with("tests") {
            continue;
        }
        let rank = |name: &str| order.iter().position(|own| *own == name);
        let own = rank(module).unwrap_or_else(|| panic!("{module} is not in the order"));
        let text = fs::read_to_string(path).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap().lines();
        for line in code.filter(|line| !line.trim().starts_with("//")) {
            for part in line.split(root).skip(1) {
                let name: String =
                    part.chars().take_while(|&c| c.is_ascii_lowercase() || c == '_').collect();
                let later = rank(&name).is_some_and(|other| other > own);
                assert!(!later, "{module} imports {name}: {}", path.display());
            }
        }
    }
}

/// Number of crates in the tree of the flight core, including itself.
fn crates_in_core(features: &[&str]) -> usize {
    let mut arguments = vec!["tree", "-p", "hovernav", "-e", "normal,build", "--prefix", "none"];
    arguments.extend_from_slice(features);
    let tree = cargo(&arguments);
    let crates: BTreeSet<&str> =
        tree.lines().filter_map(|line| line.split(" (").next()).filter(|l| !l.is_empty()).collect();
    crates.len()
}

#[test]
fn the_flight_core_has_few_crates_under_it() {
    for protocol in ["tsip", "nmea", "ubx"] {
        let count = crates_in_core(&["--no-default-features", "--features", protocol]);
        println!("{protocol}: {count} crates");
        assert!(count <= 12, "{protocol}: {count} crates");
    }
    let all = crates_in_core(&[]);
    println!("all protocols: {all} crates");
    assert!(all <= 20, "{all} crates");
}

/// Every Rust file below folders of the checkout, except below a folder named in `without`.
fn rust_files(folders: &[&str], without: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut places: Vec<PathBuf> =
        folders.iter().map(|folder| Path::new(ROOT).join(folder)).collect();
    while let Some(place) = places.pop() {
        for entry in fs::read_dir(place).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !without.iter().any(|folder| path.ends_with(folder)) {
                places.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Every Rust file of the library crates and the command.
fn sources() -> Vec<PathBuf> {
    rust_files(&["src", "cli", "crates", "ffi", "ground"], &["tests", "target"])
}

#[test]
fn no_test_skips_or_looks_for_shared_data_by_itself() {
    let folders = ["benches", "cli", "crates", "examples", "ffi", "ground", "src", "tests"];
    let files = rust_files(&folders, &["target", "crates/testing"]);
    assert!(files.len() > 300, "{}", files.len());
    for path in files.iter().filter(|path| !path.ends_with("tests/house/main.rs")) {
        let text = fs::read_to_string(path).unwrap();
        let prints_a_skip = text.split("println!(").skip(1).any(|printed| {
            let words = printed.split(");").next().unwrap_or_default();
            words.contains("\"skipped") || words.contains("skipped\"")
        });
        let is_own = prints_a_skip || text.contains("../shared");
        assert!(!is_own, "a skip or ../shared in {}: use crates/testing", path.display());
    }
}

/// Lines that are neither empty nor a comment.
fn code_lines(path: &Path) -> usize {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//")).count()
}

#[test]
fn no_source_file_is_long_and_most_are_short() {
    let mut lengths: Vec<usize> = Vec::new();
    for path in sources() {
        let length = code_lines(&path);
        assert!(length <= 400, "{} has {length} lines of code", path.display());
        lengths.push(length);
    }
    lengths.sort_unstable();
    let median = lengths[lengths.len() / 2];
    println!("{} files, median {median}, longest {}", lengths.len(), lengths[lengths.len() - 1]);
    assert!(median < 150, "{median}");
}
