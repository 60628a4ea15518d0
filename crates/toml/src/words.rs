//! Errors of values in plain words, without names of Rust types.

use serde::de::{Expected, Unexpected};

use crate::place::Place;

/// Description of the value in the file.
pub(crate) fn found(what: Unexpected<'_>) -> String {
    match what {
        Unexpected::Str(text) => format!("\"{text}\""),
        Unexpected::Signed(number) => number.to_string(),
        Unexpected::Unsigned(number) => number.to_string(),
        // The shortest form: 1e300 instead of 301 digits.
        Unexpected::Float(number) => format!("{number:?}"),
        Unexpected::Bool(is) => is.to_string(),
        Unexpected::Seq => "a list".into(),
        Unexpected::Map => "a table".into(),
        other => other.to_string(),
    }
}

/// Description of the permitted values.
pub(crate) fn expected(what: &dyn Expected) -> String {
    let name = what.to_string();
    let whole = |from: &str, to: &str| format!("a whole number from {from} to {to}");
    match name.as_str() {
        "f64" | "f32" => "a number".into(),
        "u8" => whole("0", &u8::MAX.to_string()),
        "u16" => whole("0", &u16::MAX.to_string()),
        "u32" => whole("0", &u32::MAX.to_string()),
        "u64" | "usize" => "a whole number from 0".into(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".into(),
        "a boolean" => "true or false".into(),
        "a string" | "a borrowed string" => "text in quotes".into(),
        "path string" => "a path in quotes".into(),
        "a map" => "a table".into(),
        "a sequence" => "a list".into(),
        _ => {
            let is = |kind: &str| name.starts_with(kind);
            match name.strip_prefix("an array of length ") {
                Some(length) => format!("a list of {length}"),
                None if is("struct ") => "a table".into(),
                None if is("enum ") || is("variant ") => "a name in quotes".into(),
                None => name,
            }
        }
    }
}

/// One of `names`.
pub(crate) fn one_of(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    match quoted.split_last() {
        None => "none".into(),
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}

/// `message` preceded by the key at the path `place`, which begins with the innermost key. If `message` already begins
/// with a key, that key is further inside.
pub(crate) fn sentence(place: &[Place], message: &str) -> String {
    let keys = place.iter().rev().filter_map(|step| match step {
        Place::Key(key) => Some(key.as_str()),
        Place::Index(_) => None,
    });
    let keys: Vec<&str> = keys.collect();
    let section = |keys: &[&str]| {
        if keys.is_empty() { String::new() } else { format!("[{}] ", keys.join(".")) }
    };
    let is_key =
        |text: &str| text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_.".contains(&byte));
    match (message.split_once(": "), keys.split_last()) {
        (Some((key, _)), _) if is_key(key) => format!("{}{message}", section(&keys)),
        (_, Some((key, rest))) => format!("{}{key}: {message}", section(rest)),
        (_, None) => message.to_owned(),
    }
}
