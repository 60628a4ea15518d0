//! Lists the keys of a file's type.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json, json};

use super::source::{Field, Type, Types};

/// One key of a file.
#[derive(Clone, Debug)]
pub struct Key {
    /// Name with its sections, as in `imu.lever_arm_m`.
    pub path: String,
    /// Description of the type of the key's value.
    pub kind: String,
    /// Default in TOML; empty without a default.
    pub default: String,
    pub doc: String,
}

/// Fields that are plain tables in their structure, with the type of their keys.
const TABLES: &[(&str, &str)] = &[
    ("Manifest.alignment", "AlignmentConfig"),
    ("Manifest.aiding", "Aiding"),
    ("Manifest.filter", "EkfConfig"),
];
/// Fields that are not on the page.
const NOT_COMPARED: &[&str] = &["AutopilotSection.flown"];

/// Default values of types, by name.
pub type Defaults = BTreeMap<&'static str, toml::Value>;

pub struct Walk<'a> {
    pub types: &'a Types,
    pub defaults: &'a Defaults,
    pub keys: Vec<Key>,
}

impl Walk<'_> {
    /// Adds the keys of the structure `name` below `prefix` and returns its schema.
    pub fn structure(&mut self, name: &str, prefix: &str, parameter: &str) -> Json {
        let Some(Type::Structure(fields)) = self.types.get(name) else {
            panic!("no structure {name}");
        };
        let mut properties = Map::new();
        for field in fields {
            let place = format!("{name}.{}", field.key);
            if NOT_COMPARED.contains(&place.as_str()) {
                continue;
            }
            let path = format!("{prefix}{}", field.key);
            let table = TABLES.iter().find(|(table, _)| *table == place).map(|(_, name)| *name);
            let kind = table.unwrap_or(if field.kind == "U" { parameter } else { &field.kind });
            let schema = self.value(kind, &path, name, field);
            properties.insert(field.key.clone(), schema);
        }
        json!({"type": "object", "additionalProperties": false, "properties": properties})
    }

    fn value(&mut self, kind: &str, path: &str, owner: &str, field: &Field) -> Json {
        let plain = stripped(kind);
        let (name, parameter) = plain.split_once('<').unwrap_or((plain, ""));
        let parameter = parameter.trim_end_matches('>');
        if name == "Channels" {
            return self.channels(parameter, path, owner, field);
        }
        if name == "CaptureSection" {
            return self.capture(path, field);
        }
        if kind.starts_with("Vec<")
            && let Some(Type::Structure(_)) = self.types.get(plain)
        {
            let items = self.structure(plain, &format!("{path}."), "");
            return json!({"type": "array", "description": field.doc, "items": items});
        }
        match self.types.get(name) {
            Some(Type::Structure(_)) => {
                let mut schema = self.structure(name, &format!("{path}."), parameter);
                schema["description"] = json!(field.doc);
                schema
            }
            Some(Type::Enumeration(values)) => {
                let names: Vec<&str> = values.iter().map(|value| value.name.as_str()).collect();
                let of = names.iter().map(|name| format!("`\"{name}\"`")).collect::<Vec<_>>();
                let own =
                    values.iter().find(|value| value.is_default && !kind.starts_with("Option"));
                let own = own.map_or(String::new(), |value| format!("\"{}\"", value.name));
                let (words, item) = (of.join(", "), json!({"enum": names}));
                self.put(path, owner, field, repeated(kind, &words), own);
                listed(kind, item, &field.doc)
            }
            None => {
                let (words, item) = primitive(plain, path);
                let own = if kind == "bool" { "false" } else { "" };
                self.put(path, owner, field, repeated(kind, words), own.to_owned());
                listed(kind, item, &field.doc)
            }
        }
    }

    /// Schema of a structure with one value per channel.
    fn channels(&mut self, of: &str, path: &str, owner: &str, field: &Field) -> Json {
        let inner = Field { kind: of.to_owned(), ..field.clone() };
        let path = format!("{path}.‹channel›");
        let schema = self.value(of, &path, owner, &inner);
        let names = ["throttle", "collective", "longitudinal", "lateral", "pedal"];
        let properties: Map<String, Json> =
            names.iter().map(|name| ((*name).to_owned(), schema.clone())).collect();
        json!({"type": "object", "description": field.doc, "additionalProperties": false,
            "properties": properties})
    }

    /// Schema of the pilot's pulses: one of two alternative sections.
    fn capture(&mut self, path: &str, field: &Field) -> Json {
        let serial = self.structure("LineSection", &format!("{path}.serial."), "");
        let chip = Field {
            key: "chip".into(),
            kind: "PathBuf".into(),
            doc: "The GPIO chip, `/dev/gpiochip0` say.".into(),
        };
        let lines = Field {
            key: "lines".into(),
            kind: "Channels<u32>".into(),
            doc: "Number of each channel's line.".into(),
        };
        let gpio = json!({
            "chip": self.value("PathBuf", &format!("{path}.gpio.chip"), "", &chip),
            "lines": self.value("Channels<u32>", &format!("{path}.gpio.lines"), "", &lines),
        });
        json!({"type": "object", "description": field.doc,
            "properties": {"serial": serial, "gpio": {"type": "object", "properties": gpio}}})
    }

    fn put(&mut self, path: &str, owner: &str, field: &Field, kind: String, own: String) {
        let default = self.defaults.get(owner).and_then(|value| value.get(&field.key));
        let default = default.map_or(own, toml::Value::to_string);
        self.keys.push(Key { path: path.into(), kind, default, doc: field.doc.clone() });
    }
}

/// A type without `Option` or `Vec` around it.
fn stripped(kind: &str) -> &str {
    for wrapper in ["Option<", "Vec<"] {
        if let Some(inner) = kind.strip_prefix(wrapper) {
            return stripped(inner.strip_suffix('>').unwrap_or(inner));
        }
    }
    match kind.strip_prefix('[') {
        Some(inner) => inner.split(';').next().unwrap_or(inner),
        None => kind,
    }
}

/// Number of elements of an array type.
fn count(kind: &str) -> Option<&str> {
    if kind.starts_with("Vec<") {
        return Some("");
    }
    kind.strip_prefix('[')?.trim_end_matches(']').split_once("; ").map(|(_, count)| count)
}

fn repeated(kind: &str, words: &str) -> String {
    match count(kind) {
        Some("") => format!("list of: {words}"),
        Some(count) => format!("{count} of: {words}"),
        None => words.to_owned(),
    }
}

fn listed(kind: &str, item: Json, doc: &str) -> Json {
    let mut schema = match count(kind) {
        Some(count) => {
            let mut list = json!({"type": "array", "items": item});
            if let Ok(count) = count.parse::<usize>() {
                list["minItems"] = json!(count);
                list["maxItems"] = json!(count);
            }
            list
        }
        None => item,
    };
    schema["description"] = json!(doc);
    schema
}

fn primitive(name: &str, path: &str) -> (&'static str, Json) {
    match name {
        // The core's settings are generic over the number type `T`, which is `f64` for files.
        "f64" | "T" => ("number", json!({"type": "number"})),
        "u8" | "u16" | "u32" | "u64" => ("whole number", json!({"type": "integer", "minimum": 0})),
        "bool" => ("`true`, `false`", json!({"type": "boolean"})),
        "String" => ("text", json!({"type": "string"})),
        "PathBuf" => ("path", json!({"type": "string"})),
        "Datetime" => ("date", json!({"type": "string", "format": "date"})),
        "Vector<Body>" | "Vector" => {
            let numbers =
                json!({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3});
            ("forward, right, down", numbers)
        }
        "Axes" if !path.starts_with("table.") => (
            "three letters of `f`, `b`, `r`, `l`, `u`, `d`",
            json!({"type": "string", "pattern": "^[fbrlud]{3}$"}),
        ),
        "Axes" => {
            let axis = json!({"enum": ["x", "y", "z", "-x", "-y", "-z"]});
            let axes = json!({"type": "array", "items": axis, "minItems": 3, "maxItems": 3});
            ("3 of: `\"x\"`, `\"y\"`, `\"z\"`, each with `-` or without", axes)
        }
        "Sticks" => {
            let names = ["lateral", "longitudinal", "collective", "pedal"];
            let properties: Map<String, Json> =
                names.iter().map(|name| ((*name).to_owned(), json!({"type": "number"}))).collect();
            (
                "`{ lateral, longitudinal, collective, pedal }`",
                json!({"type": "object", "properties": properties}),
            )
        }
        other => panic!("{path}: unknown type {other}"),
    }
}
