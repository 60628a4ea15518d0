//! Ranges of the numbers in `fly.toml`, and the check of every number.

use toml::Value;

use super::error::FlyConfigError;
use super::fly_config::FlyConfig;
use super::navigation_ranges::NAVIGATION;
use super::ranges::{AUTOPILOT, DEVICES};
use hovernav::ekf::{EstimatorConfig, Setting};
use hovernav::scalar::Readable;

/// Permitted range of a number.
#[derive(Clone, Copy)]
pub(super) struct Range {
    key: &'static str,
    from: f64,
    to: f64,
    unit: &'static str,
    /// Whether 0, in the sense of "none", is permitted too.
    or_zero: bool,
}

/// A section and its numbers. `*` matches any section or number key that has no earlier entry.
pub(super) type Section = (&'static str, &'static [Range]);

/// Unit and remark for bias times: the filter would stop estimating a bias that never changes.
const BIAS_TIME: &str = "s; write 10000000 for a bias that hardly changes";

/// Range of `key` from `from` to `to`.
pub(super) const fn range(key: &'static str, from: f64, to: f64, unit: &'static str) -> Range {
    Range { key, from, to, unit, or_zero: false }
}

impl Range {
    /// The same range, or 0.
    pub const fn or_zero(self) -> Self {
        Self { or_zero: true, ..self }
    }

    /// The range in flight of a setting of the estimator.
    fn of(setting: &Setting) -> Self {
        let Setting { name: key, unit, in_flight: [from, to], or_zero, .. } = *setting;
        let unit = if key.ends_with("bias_time_s") { BIAS_TIME } else { unit };
        Self { key, from, to, unit, or_zero }
    }

    /// Whether the range contains `found`; false for NaN.
    fn holds(&self, found: f64) -> bool {
        (self.from..=self.to).contains(&found) || (self.or_zero && found == 0.0)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { from, to, unit, .. } = self;
        if self.or_zero {
            f.write_str("0, or ")?;
        }
        write!(f, "{} to {}", Readable(*from), Readable(*to))?;
        if unit.is_empty() { Ok(()) } else { write!(f, " {unit}") }
    }
}

impl FlyConfig {
    /// Checks that every number permits a flight. NaN, which would disable a check, never does. The autopilot's own
    /// numbers are included once its file is loaded.
    pub(super) fn check_ranges(&self) -> Result<(), FlyConfigError> {
        let spelled = hovernav_toml::to_value(self)
            .map_err(|error| FlyConfigError::value("", "settings", &error))?;
        check_numbers(&[], &spelled)
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_would_switch_a_check_off_are_refused_with_their_key() {
        let good = "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n";
        FlyConfig::parse(good, "fly.toml".as_ref()).unwrap();
        for (text, key) in [
            ("[receiver.limits]\nmax_jump_m = nan\n", "max_jump_m"),
            ("[receiver.limits]\nmax_ground_speed_mps = inf\n", "max_ground_speed_mps"),
            ("[servo.signal]\nstale_after_s = 1e9\n", "stale_after_s"),
            ("[servo]\nhold_s = nan\n", "hold_s"),
            ("[navigation.imu]\ngyro_range_degps = 1e9\n", "gyro_range_degps"),
            ("[mavlink]\nport = 'c'\nspeaker = { system_id = 0 }\n", "system_id"),
            ("[mavlink]\nport = 'c'\nspeaker = { gate_sigmas = 0 }\n", "gate_sigmas"),
            ("[mavlink]\nport = 'c'\nspeaker = { rates = { attitude_hz = nan } }\n", "attitude_hz"),
            ("[site]\nlatitude_deg = 91\nlongitude_deg = 0\n", "latitude_deg"),
            ("[telemetry]\nport = 'd'\nbaud = 5\n", "baud"),
            ("[servo.capture]\nserial = { port = 'c', baud = 5 }\n", "baud"),
            ("[mavlink]\nport = 'c'\nspeaker = { component_id = 0 }\n", "component_id"),
            (
                "[servo.capture]\nserial = { port = 'c' }\n[autopilot]\nfile = 'a'\n\
                 fence = { radius_m = 50, height_m = 50 }\n\
                 [site]\nlatitude_deg = 1\nlongitude_deg = 2\n",
                "[site] height_m",
            ),
            ("[telemetry]\nport = 'd'\nudp = 'ground:14551'\n", "udp"),
            ("[telemetry]\nudp = 'ground'\n", "udp"),
            ("[telemetry]\nudp = 'ground:0'\n", "udp"),
            ("[mavlink]\nbaud = 9600\n", "port"),
        ] {
            let error = FlyConfig::parse(&format!("{good}{text}"), "fly.toml".as_ref())
                .expect_err(text)
                .to_string();
            assert!(error.contains(key) && error.contains("expected"), "{text}: {error}");
        }
    }
}
