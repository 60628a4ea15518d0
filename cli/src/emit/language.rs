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

/// Numbers and switches of any nesting depth, in the brackets of the language.
pub fn literal(language: Language, value: &Value) -> String {
    match value {
        Value::Array(values) => {
            let all: Vec<String> = values.iter().map(|value| literal(language, value)).collect();
            let (open, close) = if language == Language::Rust { ('[', ']') } else { ('{', '}') };
            format!("{open}{}{close}", all.join(", "))
        }
        Value::Bool(on) if language == Language::C => u32::from(*on).to_string(),
        Value::Bool(on) => on.to_string(),
        other => number(other.as_f64().unwrap_or(f64::NAN)),
    }
}

/// One line per number and switch in the structure `value`, assigned to its field. `before` precedes the field's name,
/// as in `config.ekf.` or `config->`.
pub fn assignments(language: Language, before: &str, value: &Value) -> String {
    let Value::Object(fields) = value else { return String::new() };
    fields
        .iter()
        .map(|(key, value)| match value {
            Value::Object(_) => assignments(language, &format!("{before}{key}."), value),
            Value::Number(_) | Value::Bool(_) => {
                format!("    {before}{key} = {};\n", literal(language, value))
            }
            _ => String::new(),
        })
        .collect()
}

/// Name of a constant in C for a variant in Rust: `FixedWing` as `FIXED_WING`.
pub fn upper_snake(variant: &str) -> String {
    let mut name = String::new();
    for (index, letter) in variant.chars().enumerate() {
        if index > 0 && letter.is_uppercase() {
            name.push('_');
        }
        name.extend(letter.to_uppercase());
    }
    name
}
