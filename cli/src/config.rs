//! `hovernav config`: every file, column and key, with defaults and units.

use anyhow::bail;

/// The page that is generated from the configuration types: docs/configuration.md.
pub const PAGE: &str = include_str!("../assets/configuration.md");

#[derive(clap::Args)]
#[command(after_long_help = PAGE)]
pub struct Arguments {
    /// A file, such as fly.toml or imu.csv, or a word in a key or its description [default: the whole page]
    about: Option<String>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let text = match &arguments.about {
        None => PAGE.to_owned(),
        Some(about) => section(about).or_else(|| lines(about)).unwrap_or_default(),
    };
    if text.is_empty() {
        let about = arguments.about.as_deref().unwrap_or_default();
        bail!(
            "config: found no file \"{about}\" and no key with that word, expected a file or a word of a key"
        );
    }
    crate::output::print(text);
    Ok(())
}

/// The section of the page with the heading `name`: a file, or `columns`.
fn section(name: &str) -> Option<String> {
    let parts = PAGE.split("\n## ").skip(1);
    let mut parts = parts
        .filter(|part| part.lines().next().is_some_and(|title| title.eq_ignore_ascii_case(name)));
    parts.next().map(|part| format!("## {}\n", part.trim_end()))
}

/// The rows that contain `word`, each under the heading of its section.
fn lines(word: &str) -> Option<String> {
    let word = word.to_lowercase();
    let mut found = String::new();
    let (mut section, mut shown) = ("", "");
    for line in PAGE.lines() {
        if line.starts_with("## ") || line.starts_with("`[") || line.starts_with("Outside") {
            section = line;
        }
        if line.starts_with("| `") && line.to_lowercase().contains(&word) {
            if section != shown {
                found.push_str(&format!("\n{section}\n"));
                shown = section;
            }
            found.push_str(line);
            found.push('\n');
        }
    }
    (!found.is_empty()).then_some(found)
}
