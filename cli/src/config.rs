//! `hovernav config`: every file, column and key, with defaults and units.

use anyhow::bail;

/// The page that is generated from the configuration types: docs/configuration.md.
pub const PAGE: &str = include_str!("../assets/configuration.md");

#[derive(clap::Args)]
#[command(after_long_help = PAGE)]
pub struct Arguments {
    /// A file, such as fly.toml or imu.csv; a section or key, such as filter.gate or filter.gate.sigmas; or a word in a
    /// key or its description [default: the whole page]
    about: Option<String>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let text = match &arguments.about {
        None => PAGE.to_owned(),
        Some(about) => {
            let found = file(about).or_else(|| columns(about)).or_else(|| section(about));
            found.or_else(|| lines(about)).unwrap_or_default()
        }
    };
    if text.is_empty() {
        let about = arguments.about.as_deref().unwrap_or_default();
        bail!(
            "config: found no file, section or key \"{about}\", expected one of them or a word of a key"
        );
    }
    crate::output::print(text);
    Ok(())
}

/// The part of the page with the heading `name`: a file, or `columns`.
fn file(name: &str) -> Option<String> {
    let parts = PAGE.split("\n## ").skip(1);
    let mut parts = parts
        .filter(|part| part.lines().next().is_some_and(|title| title.eq_ignore_ascii_case(name)));
    parts.next().map(|part| format!("## {}\n", part.trim_end()))
}

/// The columns of the file `name`, such as `imu.csv`.
fn columns(name: &str) -> Option<String> {
    let (_, rest) = PAGE.split_once(&format!("\n`{name}`\n\n"))?;
    let rows = rest.split("\n\n").next()?;
    Some(format!("`{name}`\n\n{rows}\n"))
}

/// The sections with the name `name` or inside that section, such as `filter.gate` or `filter`; otherwise the section
/// that contains the key `name`, with that key alone.
fn section(name: &str) -> Option<String> {
    let name = name.trim_matches(['[', ']']);
    let (group, key) = name.rsplit_once('.').unwrap_or((name, ""));
    let row = format!("- `{key}` = ");
    let mut text = String::new();
    for part in PAGE.split("\n`[").skip(1) {
        let Some((title, rest)) = part.split_once("]`") else { continue };
        let title = title.trim_start_matches('[');
        let body = rest.split("\n## ").next().unwrap_or_default().trim();
        let is_within = title.strip_prefix(name).is_some_and(|more| more.starts_with('.'));
        if title == name || is_within {
            text.push_str(&format!("`[{title}]`\n\n{body}\n\n"));
        } else if let Some(line) =
            body.lines().find(|line| title == group && line.starts_with(&row))
        {
            text.push_str(&format!("`[{title}]`\n\n{line}\n\n"));
        }
    }
    let text = text.trim_end();
    (!text.is_empty()).then(|| format!("{text}\n"))
}

/// The columns and keys that contain `word`, each under the heading of its section.
fn lines(word: &str) -> Option<String> {
    let word = word.to_lowercase();
    let mut found = String::new();
    let (mut section, mut shown) = ("", "");
    for line in PAGE.lines() {
        if ["## ", "`", "Outside"].iter().any(|begin| line.starts_with(begin)) {
            section = line;
        }
        if line.starts_with("- `") && line.to_lowercase().contains(&word) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_or_a_key_is_found_by_its_path() {
        let gate = section("filter.gate").unwrap();
        assert!(gate.starts_with("`[filter.gate]`\n\n- `") && gate.contains("\n- `lockout_s` = "));
        assert!(!gate.contains("##") && gate.matches("`[").count() == 1, "{gate}");
        assert_eq!(section("[filter.gate]"), Some(gate));
        let filter = section("filter").unwrap();
        assert!(filter.contains("`[filter.imu]`") && filter.contains("`[filter.mechanisms]`"));
        let key = section("filter.gate.sigmas").unwrap();
        assert!(key.contains("- `sigmas` = ") && !key.contains("lockout_s"), "{key}");
        let columns = columns("imu.csv").unwrap();
        assert!(columns.contains("- `t_s`") && columns.contains("- `mag_x_gauss`"), "{columns}");
        assert!(!columns.contains("hdop"), "{columns}");
        assert_eq!(section("filter.gate.nothing"), None);
        assert_eq!(section("gate"), None);
    }
}
