//! Check of every number in `fly.toml`.

use toml::Value;

use super::error::FlyConfigError;
use super::navigation_ranges::NAVIGATION;
use super::range::Range;
use super::ranges::{AUTOPILOT, DEVICES};
use hovernav::ekf::{EstimatorConfig, Setting};
use hovernav::scalar::Readable;

/// Checks every number of `value`, which is below the keys `at` of a `fly.toml`.
pub(super) fn check_numbers(at: &[&str], value: &Value) -> Result<(), FlyConfigError> {
    let mut rejected = None;
    numbers(value, &mut at.to_vec(), &mut |section, key, found| {
        if rejected.is_none()
            && let Some(range) = range_of(section, key)
            && !range.holds(found)
        {
            let why = format!("found {}, expected {range}", Readable(found));
            let section = section.join(".");
            rejected = Some(match section.strip_prefix(FLOWN) {
                // Users have these keys in a separate file.
                Some(own) => {
                    let own = own.trim_start_matches('.');
                    let dot = if own.is_empty() { "" } else { "." };
                    let why = format!("its {own}{dot}{key}: {why}");
                    FlyConfigError::value("autopilot", "file", &why)
                }
                None => FlyConfigError::value(section, key, &why),
            });
        }
    });
    rejected.map_or(Ok(()), Err)
}

/// Section of the autopilot's file in a configuration, once it is loaded.
const FLOWN: &str = "autopilot.flown";

/// Calls `each` with section, key and number of every number below `value`, which is at `path`. Elements of an array
/// have the key of the array.
fn numbers<'a>(
    value: &'a Value,
    path: &mut Vec<&'a str>,
    each: &mut impl FnMut(&[&'a str], &'a str, f64),
) {
    let number = match value {
        Value::Float(number) => *number,
        // An integer that a double cannot represent is out of every range.
        Value::Integer(number) => *number as f64,
        Value::Array(values) => {
            values.iter().for_each(|value| numbers(value, path, each));
            return;
        }
        Value::Table(table) => {
            for (key, value) in table {
                path.push(key);
                numbers(value, path, each);
                path.pop();
            }
            return;
        }
        _ => return,
    };
    if let Some((key, section)) = path.split_last() {
        each(section, key, number);
    }
}

/// Range of the number `key` of `section`.
fn range_of(section: &[&str], key: &str) -> Option<Range> {
    if let Some(settings) = settings_of(section) {
        return settings.iter().find(|setting| setting.name == key).map(Range::of);
    }
    let is = |pattern: &str, key: &str| pattern == "*" || pattern == key;
    let tables = [DEVICES, AUTOPILOT, NAVIGATION];
    let (_, ranges) = tables.into_iter().flatten().find(|(name, _)| {
        let mut keys = section.iter();
        name.split('.')
            .filter(|name| !name.is_empty())
            .all(|name| keys.next().is_some_and(|key| is(name, key)))
            && keys.next().is_none()
    })?;
    ranges.iter().find(|range| is(range.key, key)).copied()
}

/// Settings of the estimator in `section`.
fn settings_of(section: &[&str]) -> Option<&'static [Setting]> {
    let group = match section {
        ["navigation", "filter", group] => (*group).to_owned(),
        ["navigation", aid, "model"] => format!("{aid}.model"),
        _ => return None,
    };
    let mut groups = EstimatorConfig::SETTINGS.iter();
    groups.find(|(name, _)| *name == group).map(|(_, settings)| *settings)
}
