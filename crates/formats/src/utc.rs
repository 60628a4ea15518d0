//! Calendar dates.

use chrono::DateTime;

/// The date at `utc_s`, s since 1970, as TOML writes it. `None` outside the years 1990 to 2099, which no log can
/// have.
pub(crate) fn date(utc_s: f64) -> Option<String> {
    let day = DateTime::from_timestamp(utc_s as i64, 0)?.date_naive();
    let text = day.to_string();
    (text.as_str() >= "1990" && text.as_str() < "2100").then_some(text)
}

/// UTC, s since 1970, of a GPS week and the seconds in it. Leap seconds are ignored; a date does not need them.
pub(crate) fn of_gps(week: f64, in_week_s: f64) -> f64 {
    // GPS time began on 6 January 1980.
    315_964_800.0 + 604_800.0 * week + in_week_s
}

#[cfg(test)]
mod tests {
    use super::date;

    #[test]
    fn days_are_those_of_the_calendar() {
        assert_eq!(date(1_739_195_790.2).as_deref(), Some("2025-02-10"));
        assert_eq!(date(0.0), None);
        assert_eq!(date(f64::NAN), None);
        assert_eq!(date(1e300), None);
    }
}
