//! Conversion between the log's clock and calendar time.

use chrono::{DateTime, NaiveDate, SecondsFormat};
use toml::value::{Datetime, Offset};

use crate::manifest::Manifest;

/// Time `unix_ns`, ns of UTC since the start of 1970, in the form of `date` in `dataset.toml`, to the millisecond.
/// `None` outside the years 1990 to 2100.
#[must_use]
pub fn moment(unix_ns: i64) -> Option<Datetime> {
    let text = DateTime::from_timestamp_nanos(unix_ns).to_rfc3339_opts(SecondsFormat::Millis, true);
    let is_plausible = ("1990".."2100").contains(&text.as_str());
    if is_plausible { text.parse().ok() } else { None }
}

impl Manifest {
    /// Time at which the log's clock reads zero, ns of UTC since the start of 1970, from a `date` with a time of day;
    /// UTC is assumed without an offset. `None` for a date alone.
    ///
    /// ```
    /// # use hovernav_dataset::Manifest;
    /// let (manifest, _) = Manifest::parse("date = 1970-01-02T01:00:00+01:00", "".as_ref()).unwrap();
    /// assert_eq!(manifest.utc_at_zero_ns(), Some(86_400_000_000_000));
    /// ```
    #[must_use]
    pub fn utc_at_zero_ns(&self) -> Option<i64> {
        let Datetime { date: Some(date), time: Some(time), offset } = self.date? else {
            return None;
        };
        let day = NaiveDate::from_ymd_opt(date.year.into(), date.month.into(), date.day.into())?;
        let moment = day.and_hms_nano_opt(
            time.hour.into(),
            time.minute.into(),
            time.second.unwrap_or_default().into(),
            time.nanosecond.unwrap_or_default(),
        )?;
        let ahead_min = match offset {
            Some(Offset::Custom { minutes }) => i64::from(minutes),
            Some(Offset::Z) | None => 0,
        };
        moment.and_utc().timestamp_nanos_opt()?.checked_sub(ahead_min * 60_000_000_000)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_comes_back_to_the_millisecond() {
        let unix_ns = 1_739_195_790_204_000_000;
        let date = moment(unix_ns);
        assert_eq!(date.map(|date| date.to_string()).as_deref(), Some("2025-02-10T13:56:30.204Z"));
        assert_eq!(Manifest { date, ..Manifest::default() }.utc_at_zero_ns(), Some(unix_ns));
    }

    #[test]
    fn no_log_was_made_before_1990_or_after_2100() {
        assert_eq!(moment(0), None);
        assert_eq!(moment(i64::MIN), None);
        assert_eq!(moment(i64::MAX), None);
        let date = "2025-02-10".parse().ok();
        assert_eq!(Manifest { date, ..Manifest::default() }.utc_at_zero_ns(), None);
    }
}
