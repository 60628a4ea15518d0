//! Values in the syntax of Rust and of C.

use serde_json::Value;

/// The language of a literal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    Rust,
    C,
}

/// A comment in either language, on one line even if `remark` contains line breaks.
pub fn comment(remark: &str) -> String {
    format!("// {}", remark.replace(char::is_control, " "))
}

/// A number that parses back to the same bits.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Numbers of any nesting depth, in the brackets of the language.
pub fn literal(language: Language, value: &Value) -> String {
    match value {
        Value::Array(values) => {
            let all: Vec<String> = values.iter().map(|value| literal(language, value)).collect();
            let (open, close) = if language == Language::Rust { ('[', ']') } else { ('{', '}') };
            format!("{open}{}{close}", all.join(", "))
        }
        other => number(other.as_f64().unwrap_or(f64::NAN)),
    }
}

/// One line per number in `value`, assigned to its field below `place`.
pub fn assignments(place: &str, value: &Value) -> String {
    match value {
        Value::Object(fields) => fields
            .iter()
            .map(|(key, value)| assignments(&format!("{place}.{key}"), value))
            .collect(),
        Value::Number(value) => {
            let value = number(value.as_f64().unwrap_or(f64::NAN));
            format!("    {place} = {value};\n")
        }
        _ => String::new(),
    }
}
