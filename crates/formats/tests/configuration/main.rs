//! The page and the schemas of `dataset.toml`, `fly.toml` and `mapping.toml` match the types that read these files.
//!
//! If `HOVERNAV_WRITE_CONFIGURATION` is set, the test writes the files instead of comparing them.

mod source;
mod walk;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use hovernav_dataset::{Manifest, RangefinderSection, SecondAntennaSection};
use hovernav_record::FlyConfig;
use serde::Serialize;
use serde_json::{Value as Json, json};
use walk::{Defaults, Key, Walk};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Name, type and description of each file.
const FILES: [(&str, &str, &str); 3] = [
    (
        "dataset.toml",
        "Manifest",
        "The vehicle, the mounting and quality of its sensors, and the settings of the filter. The \
         file is in the dataset directory, or is given to `hovernav estimate --config`. An unknown \
         key causes a warning; in `[alignment]`, `[aiding]` and `[filter]` an error.",
    ),
    (
        "fly.toml",
        "FlyConfig",
        "Devices, their serial lines, and the setup of the vehicle, for `hovernav fly --config`. \
         The file may have any name (`play.toml` is an example for played sensors). An unknown key \
         is an error. `[navigation]` has the keys of `dataset.toml`.",
    ),
    (
        "mapping.toml",
        "Mapping",
        "The columns of foreign text files, written by `hovernav init` and read by every command \
         that takes a log: a `[[table]]` per file, then the sections of its sensors.",
    ),
];

fn toml_of(value: &impl Serialize) -> toml::Value {
    hovernav_toml::to_value(value).unwrap()
}

/// Default values of the types.
fn defaults() -> Defaults {
    use hovernav::ekf::{
        Aiding, AntennaHeadingModel, AttitudeModel, BaroModel, GateConfig, GpsModel, ImuModel,
        MagnetometerModel, Mechanisms, RangeModel,
    };
    let manifest = toml_of(&Manifest::default());
    let fly = toml_of(&FlyConfig::default());
    let mut defaults = Defaults::from([
        ("AlignmentConfig", toml_of(&hovernav::ins::AlignmentConfig::default())),
        ("Aiding", toml_of(&Aiding::default())),
        ("Mechanisms", toml_of(&Mechanisms::default())),
        ("ImuModel", toml_of(&ImuModel::default())),
        ("GpsModel", toml_of(&GpsModel::default())),
        ("AttitudeModel", toml_of(&AttitudeModel::default())),
        ("MagnetometerModel", toml_of(&MagnetometerModel::default())),
        ("BaroModel", toml_of(&BaroModel::default())),
        ("GateConfig", toml_of(&GateConfig::default())),
        ("RangeModel", toml_of(&RangeModel::default())),
        ("AntennaHeadingModel", toml_of(&AntennaHeadingModel::default())),
        ("NotchConfig", toml_of(&hovernav::imu::NotchConfig::default())),
        ("RangefinderSection", toml_of(&RangefinderSection::default())),
        ("SecondAntennaSection", toml_of(&SecondAntennaSection::default())),
        ("Limits", toml_of(&hovernav::gps::quality::Limits::default())),
        ("SwitchConfig", toml_of(&hovernav::servo::SwitchConfig::default())),
        ("SignalConfig", toml_of(&hovernav::servo::SignalConfig::default())),
        ("Swashplate", toml_of(&hovernav::servo::Swashplate::default())),
        ("ReadinessLimits", toml_of(&hovernav::autopilot::ReadinessLimits::default())),
        ("SteeringConfig", toml_of(&hovernav::autopilot::SteeringConfig::default())),
        ("FailsafeConfig", toml_of(&hovernav::flight_control::FailsafeConfig::default())),
        ("ExcitationSection", toml_of(&hovernav_record::ExcitationSection::default())),
        ("MavlinkConfig", toml_of(&hovernav_record::MavlinkConfig::default())),
        ("MavlinkRates", toml_of(&hovernav_record::MavlinkRates::default())),
    ]);
    let section = |table: &toml::Value, path: &[&str]| {
        path.iter().try_fold(table, |table, key| table.get(key)).cloned()
    };
    for (name, table, path) in [
        ("ImuSection", &manifest, &["imu"][..]),
        ("GpsSection", &manifest, &["gps"]),
        ("ReferenceSection", &manifest, &["reference"]),
        ("SolutionSection", &manifest, &["solution"]),
        ("DmuSection", &fly, &["dmu"]),
        ("ReceiverSection", &fly, &["receiver"]),
        ("RecordSection", &fly, &["record"]),
        ("ServoSection", &fly, &["servo"]),
        ("ChannelConfig", &fly, &["servo", "channels", "lateral"]),
    ] {
        defaults.insert(name, section(table, path).unwrap_or_else(|| panic!("no {name}")));
    }
    defaults
}

/// The keys of a file, and its schema.
fn keys_of(name: &str) -> (Vec<Key>, Json) {
    let (types, defaults) = (source::types(), defaults());
    let mut walk = Walk { types: &types, defaults: &defaults, keys: Vec::new() };
    let schema = walk.structure(name, "", "");
    (walk.keys, schema)
}

fn page() -> String {
    let mut page = String::from(
        "# Configuration\n\nAll files, columns and keys, generated from the types that read them. \
         `hovernav config` prints this page. [`schemas`](schemas) has JSON schemas for \
         editors. After `=` is the default, in bold among several values; without a default \
         it is the type of the value, and the key is not set.\n\n",
    );
    page.push_str(include_str!("columns.md"));
    for (file, name, about) in FILES {
        let _ = write!(page, "\n## {file}\n\n{about}\n");
        let mut keys = keys_of(name).0;
        keys.retain(|key| file != "fly.toml" || !key.path.starts_with("navigation."));
        let section_of = |key: &Key| key.path.rsplit_once('.').map_or("", |(of, _)| of).to_owned();
        let mut sections: Vec<String> = Vec::new();
        for key in &keys {
            let section = section_of(key);
            if !sections.contains(&section) {
                sections.push(section);
            }
        }
        keys.sort_by_key(|key| sections.iter().position(|section| *section == section_of(key)));
        let mut section = None;
        for key in &keys {
            let (of, last) = key.path.rsplit_once('.').unwrap_or(("", &key.path));
            if section.as_deref() != Some(of) {
                section = Some(of.to_owned());
                let title = match (file, of) {
                    (_, "") => "Outside all sections".to_owned(),
                    ("mapping.toml", "table") => "`[[table]]`".to_owned(),
                    (_, "autopilot.excitation.inputs") => format!("`[[{of}]]`"),
                    _ => format!("`[{of}]`"),
                };
                let _ = write!(page, "\n{title}\n\n");
            }
            let _ = writeln!(page, "- `{last}` = {}: {}", value_of(key), key.doc);
        }
    }
    page
}

/// The default, if it also shows the type; otherwise the type, and the default with it.
fn value_of(key: &Key) -> String {
    let Key { kind, default, .. } = key;
    match (kind.as_str(), default.as_str()) {
        (_, "" | "\"\"") => kind.clone(),
        ("number" | "whole number" | "text" | "`true`, `false`", _) => format!("`{default}`"),
        (words, _) if words.starts_with("`\"") => {
            words.replace(&format!("`{default}`"), &format!("**`{default}`**"))
        }
        _ => format!("{kind}; `{default}`"),
    }
}

fn schema(file: &str, name: &str, about: &str) -> String {
    let mut schema = keys_of(name).1;
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!(file);
    schema["description"] = json!(about);
    serde_json::to_string_pretty(&schema).unwrap() + "\n"
}

#[test]
fn the_page_and_the_schemas_match_the_types() {
    let page = page();
    let mut files = vec![
        ("docs/configuration.md".to_owned(), page.clone()),
        ("cli/assets/configuration.md".to_owned(), page),
    ];
    for (file, name, about) in FILES {
        let stem = file.trim_end_matches(".toml");
        files.push((format!("docs/schemas/{stem}.json"), schema(file, name, about)));
    }
    for (file, text) in files {
        let path = Path::new(ROOT).join(&file);
        if std::env::var_os("HOVERNAV_WRITE_CONFIGURATION").is_some() {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, text).unwrap();
            continue;
        }
        let found = fs::read_to_string(&path).unwrap_or_default();
        let differs = found.lines().zip(text.lines()).position(|(a, b)| a != b);
        assert!(
            found == text,
            "{file} differs from the types from line {:?} on: set HOVERNAV_WRITE_CONFIGURATION=1 \
             and run this test to write it",
            differs.map(|line| line + 1)
        );
    }
}

/// The keys that serde writes for `value`, with their sections.
fn written(value: &toml::Value, prefix: &str, keys: &mut BTreeSet<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, value) in table {
                written(value, &format!("{prefix}.{key}"), keys);
            }
        }
        _ => drop(keys.insert(prefix.trim_start_matches('.').to_owned())),
    }
}

#[test]
fn every_key_is_on_the_page() {
    for (name, value) in
        [("Manifest", toml_of(&Manifest::default())), ("FlyConfig", toml_of(&FlyConfig::default()))]
    {
        let channels = ["throttle", "collective", "longitudinal", "lateral", "pedal"];
        let listed: BTreeSet<String> = keys_of(name).0.into_iter().map(|key| key.path).collect();
        let mut keys = BTreeSet::new();
        written(&value, "", &mut keys);
        for key in keys {
            let parts = key.split('.').map(|p| if channels.contains(&p) { "‹channel›" } else { p });
            let general = parts.collect::<Vec<_>>().join(".");
            // A name of a channel may also be the name of a control.
            let is_listed = listed.contains(&key)
                || listed.contains(&general)
                || listed.iter().any(|known| general.starts_with(&format!("{known}.")))
                || key.starts_with("servo.swashplate.");
            assert!(is_listed, "{name}: {key} is not on the page");
        }
    }
    for (_, table) in defaults() {
        assert!(table.is_table());
    }
}

#[test]
fn every_word_on_the_page_is_accepted_in_a_dataset() {
    let mut count = 0;
    for key in keys_of("Manifest").0.iter().filter(|key| key.kind.starts_with("`\"")) {
        for word in key.kind.split('`').skip(1).step_by(2) {
            let text = format!("{} = {word}", key.path);
            let read = hovernav_toml::parse::<Manifest>(&text, Path::new("dataset.toml"));
            assert!(read.is_ok(), "{text}: {}", read.unwrap_err());
            count += 1;
        }
    }
    assert!(count > 15, "{count}");
}

#[test]
fn every_key_has_a_description() {
    for (_, name, _) in FILES {
        let (keys, _) = keys_of(name);
        assert!(keys.len() > 30, "{name}: {}", keys.len());
        for key in keys {
            assert!(key.doc.len() > 3, "{name}: {} has no doc", key.path);
        }
    }
}

#[test]
fn every_column_of_the_example_is_on_the_page() {
    let page = page();
    for file in ["imu.csv", "gps.csv", "controls.csv", "reference.csv"] {
        let path = Path::new(ROOT).join("datasets/heli-hover").join(file);
        let text = fs::read_to_string(path).unwrap();
        for column in text.lines().next().unwrap().split(',') {
            assert!(page.contains(&format!("`{column}`")), "{file}: {column}");
        }
    }
}
