//! Parses the source code of the types into which settings are read.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// A field of a structure: a key of a file.
#[derive(Clone, Debug)]
pub struct Field {
    pub key: String,
    pub kind: String,
    pub doc: String,
}

/// A value of an enumeration.
#[derive(Clone, Debug)]
pub struct Value {
    pub name: String,
    pub is_default: bool,
}

/// A parsed type.
#[derive(Clone, Debug)]
pub enum Type {
    Structure(Vec<Field>),
    Enumeration(Vec<Value>),
}

/// Macros that declare types.
const MACROS: [&str; 3] = ["settings", "switches", "units"];

/// Types by name.
pub type Types = BTreeMap<String, Type>;

/// Source files of the types. If two types have the same name, the first is used.
const PLACES: &[&str] = &[
    "crates/dataset/src/manifest",
    "crates/record/src/setup",
    "crates/formats/src/text",
    "src/ekf/settings",
    "src/ins",
    "src/imu/notch.rs",
    "src/gps/quality.rs",
    "src/controls",
    "src/servo",
    "src/autopilot",
    "src/flight_control",
];

/// All structures and enumerations of those files.
pub fn types() -> Types {
    let mut types = Types::new();
    for place in PLACES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(place);
        let mut files = vec![path.clone()];
        if path.is_dir() {
            let entries = fs::read_dir(&path).unwrap_or_else(|error| panic!("{place}: {error}"));
            files = entries.map(|entry| entry.unwrap().path()).collect();
            files.retain(|file| file.extension().is_some_and(|ending| ending == "rs"));
            files.sort();
        }
        for file in files {
            let text = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{place}: {error}"));
            read(&text, &mut types);
        }
    }
    types
}

/// Documentation and attributes above an item.
#[derive(Default)]
struct Above {
    doc: String,
    attributes: String,
}

impl Above {
    /// Reads a line above an item.
    fn takes(&mut self, line: &str) -> bool {
        if let Some(doc) = line.strip_prefix("///") {
            // Examples and sources are for programmers; the page omits them.
            if !doc.trim().is_empty() {
                // Links to other items do not work on the page.
                let doc = doc.trim().replace("[`", "`").replace("`]", "`");
                self.doc = format!("{} {doc}", self.doc).trim().to_owned();
            }
            return true;
        }
        if line.starts_with("#[") || !self.attributes.is_empty() && !self.attributes.ends_with(']')
        {
            self.attributes.push_str(line);
            return true;
        }
        false
    }
}

fn read(text: &str, types: &mut Types) {
    let mut lines = text.split("#[cfg(test)]").next().unwrap_or_default().lines().map(str::trim);
    let (mut above, mut in_macro) = (Above::default(), "");
    while let Some(line) = lines.next() {
        if above.takes(line) {
            continue;
        }
        let kind = line.strip_prefix("pub struct ").map(|rest| (rest, "struct"));
        let kind = kind.or_else(|| line.strip_prefix("pub enum ").map(|rest| (rest, "enum")));
        if let Some(name) = line.strip_suffix("! {").filter(|name| MACROS.contains(name)) {
            in_macro = name;
        } else if let Some((rest, kind)) = kind.filter(|(rest, _)| rest.ends_with('{')) {
            let name = rest.split(['<', ' ']).next().unwrap_or_default().to_owned();
            let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "}").collect();
            let found = match kind {
                "struct" => Type::Structure(fields(&body)),
                _ => Type::Enumeration(values(&body, &above.attributes)),
            };
            // Types defined by a macro have the macro's placeholders as names.
            if !name.starts_with('$') {
                types.entry(name).or_insert(found);
            }
        } else if !in_macro.is_empty() && line.ends_with('{') {
            let name = line.trim_end_matches([' ', '{']).to_owned();
            let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "}").collect();
            let found = match in_macro {
                "settings" => Type::Structure(settings(&body)),
                "switches" => Type::Structure(switches(&body)),
                _ => Type::Enumeration(units(&body)),
            };
            types.entry(name).or_insert(found);
            in_macro = "";
        }
        above = Above::default();
    }
}

fn fields(body: &[&str]) -> Vec<Field> {
    let (mut fields, mut above) = (Vec::new(), Above::default());
    for line in body {
        if above.takes(line) {
            continue;
        }
        if let Some((key, kind)) = line.strip_prefix("pub ").and_then(|rest| rest.split_once(": "))
            && !above.attributes.contains("serde(skip)")
        {
            let kind = kind.trim_end_matches(',').to_owned();
            fields.push(Field { key: key.to_owned(), kind, doc: above.doc });
        }
        above = Above::default();
    }
    fields
}

fn settings(body: &[&str]) -> Vec<Field> {
    let (mut fields, mut above) = (Vec::new(), Above::default());
    for line in body {
        if above.takes(line) {
            continue;
        }
        if let Some((key, _)) = line.split_once(" = ") {
            fields.push(Field { key: key.to_owned(), kind: "f64".into(), doc: above.doc });
        }
        above = Above::default();
    }
    fields
}

fn switches(body: &[&str]) -> Vec<Field> {
    let (mut fields, mut above) = (Vec::new(), Above::default());
    for line in body {
        if above.takes(line) {
            continue;
        }
        if let Some(key) = line.strip_suffix(',') {
            fields.push(Field { key: key.to_owned(), kind: "bool".into(), doc: above.doc });
        }
        above = Above::default();
    }
    fields
}

fn values(body: &[&str], attributes: &str) -> Vec<Value> {
    let (mut values, mut above) = (Vec::new(), Above::default());
    for line in body {
        if above.takes(line) {
            continue;
        }
        let name: String = line.chars().take_while(|letter| letter.is_alphanumeric()).collect();
        if !name.is_empty() && name.starts_with(char::is_uppercase) {
            let renamed = above.attributes.split("rename = \"").nth(1);
            let renamed = renamed.and_then(|rest| rest.split('"').next()).map(str::to_owned);
            let name = renamed.unwrap_or_else(|| written(&name, attributes));
            let is_default = above.attributes.contains("#[default]");
            values.push(Value { name, is_default });
        }
        above = Above::default();
    }
    values
}

/// The name of a value as serde writes it, by the attributes of its type.
fn written(name: &str, attributes: &str) -> String {
    if attributes.contains("rename_all = \"lowercase\"") {
        return name.to_lowercase();
    }
    if !attributes.contains("rename_all = \"kebab-case\"") {
        return name.to_owned();
    }
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push('-');
        }
        words.extend(letter.to_lowercase());
    }
    words
}

fn units(body: &[&str]) -> Vec<Value> {
    let (mut values, mut above) = (Vec::new(), Above::default());
    for line in body {
        if above.takes(line) {
            continue;
        }
        if let Some((_, rest)) = line.split_once(" = \"") {
            let name = rest.split('"').next().unwrap_or_default().to_owned();
            let is_default = above.attributes.contains("#[default]");
            values.push(Value { name, is_default });
        }
        above = Above::default();
    }
    values
}
