//! Numbers, times and dates in text files.

use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime, Timelike as _};
use hovernav::time::Time;

/// The number in `field`, with a decimal comma if `comma`. A unit after the number is ignored, but the letters S and W
/// make the number negative. NaN for an empty field or an unknown value, `None` for other text.
pub(crate) fn number(field: &[u8], comma: bool) -> Option<f64> {
    const UNKNOWN: [&[u8]; 6] = [b"null", b"none", b"na", b"n/a", b"#n/a", b"nil"];
    // C libraries write values that are not finite as `-nan(ind)`, `1.#QNAN` and `-1.#IND`.
    const NOT_FINITE: [&[u8]; 2] = [b"nan(", b"1.#"];
    let field = field.trim_ascii();
    let is_unknown = |word: &&[u8]| field.eq_ignore_ascii_case(word);
    let unsigned = field.strip_prefix(b"-").unwrap_or(field);
    let begins = |with: &&[u8]| {
        unsigned.get(..with.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(with))
    };
    if field.iter().all(|byte| *byte == b'-')
        || UNKNOWN.iter().any(is_unknown)
        || NOT_FINITE.iter().any(begins)
    {
        return Some(f64::NAN);
    }
    let text = std::str::from_utf8(field).ok()?;
    let (text, unit) = match sexagesimal(text) {
        Some(degrees) => return Some(degrees),
        None => with_unit(text).unwrap_or((text, "")),
    };
    let value: f64 = match comma {
        false => text.parse().ok()?,
        true if text.contains('.') || text.ends_with(',') => return None,
        true => text.replacen(',', ".", 1).parse().ok()?,
    };
    Some(if matches!(unit, "S" | "W") { -value } else { value })
}

/// Degrees, minutes and seconds in degrees: `1°21'07.5"N`.
fn sexagesimal(text: &str) -> Option<f64> {
    let (degrees, rest) = text.split_once('°')?;
    let (minutes, rest) = rest.split_once(['\'', '′', '’'])?;
    let (seconds, side) = rest.split_once(['"', '″', '”']).unwrap_or(("0", rest));
    let parse = |text: &str| text.trim().parse::<f64>().ok();
    let part = |text: &str| parse(text).filter(|part| (0.0..=60.0).contains(part));
    let size = parse(degrees)?.abs() + part(minutes)? / 60.0 + part(seconds)? / 3600.0;
    let is_negative = degrees.trim().starts_with('-') || matches!(side.trim(), "S" | "W");
    Some(if is_negative { -size } else { size })
}

/// A number and the unit after it: `374.812 m`, `49.73m`, `0121.1259N`.
pub(crate) fn with_unit(text: &str) -> Option<(&str, &str)> {
    let is_part = |letter: char| letter.is_ascii_digit() || matches!(letter, '.' | ',' | '+' | '-');
    let mut end = text.find(|letter| !is_part(letter))?;
    if let Some(power) =
        text[end..].strip_prefix(['e', 'E']).filter(|power| power.starts_with(is_part))
    {
        end = text.len() - power.len() + power.find(|letter| !is_part(letter))?;
    }
    let (number, unit) = text.split_at(end);
    // Without a blank before the first word, a digit in it belongs to a number such as 0x1F, or to a time.
    let word = unit.split(['/', '^']).next().unwrap_or_default();
    let is_apart = unit.starts_with(' ') || !word.contains(|letter: char| letter.is_ascii_digit());
    let unit = unit.trim();
    let is_unit = unit.starts_with(|first: char| first.is_alphabetic() || first == '°');
    let is_number = number.ends_with(|last: char| last.is_ascii_digit());
    (is_unit && is_apart && is_number).then_some((number, unit))
}

/// Whether `field` is text without a digit, such as `No Fix` or `?`.
pub(crate) fn is_word(field: &[u8]) -> bool {
    !field.is_empty() && !field.iter().any(u8::is_ascii_digit)
}

/// The type of the fix in `field`: a number, also as in `3D`, or words. Words that mean no fix give 0, other words 3.
/// NaN for other text.
pub(crate) fn fix_type(field: &[u8]) -> f64 {
    const NO_FIX: [&str; 7] = ["no", "none", "invalid", "void", "false", "lost", "v"];
    let words = String::from_utf8_lossy(field).to_lowercase();
    let is_no = |word: &str| NO_FIX.contains(&word) || word.starts_with("search");
    match is_word(field) && field.iter().any(u8::is_ascii_alphabetic) {
        true if words.split(|letter: char| !letter.is_alphanumeric()).any(is_no) => 0.0,
        true if number(field, false).is_none() => 3.0,
        _ => number(field, false).unwrap_or(f64::NAN),
    }
}

/// The unit of a column of times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
pub enum TimeUnit {
    /// Seconds.
    #[default]
    #[serde(rename = "s")]
    Seconds,
    /// Milliseconds.
    #[serde(rename = "ms")]
    Milliseconds,
    /// Microseconds.
    #[serde(rename = "us")]
    Microseconds,
    /// Nanoseconds.
    #[serde(rename = "ns")]
    Nanoseconds,
    /// Ticks of 10 kHz.
    #[serde(rename = "0.1ms")]
    TenthMilliseconds,
    /// Ticks of 100 ns since 1601, as `FILETIME` of Windows, converted to UTC since 1970.
    #[serde(rename = "filetime")]
    FileTime,
    /// Ticks of 100 ns since the year 1, as `DateTime` of .NET, converted to UTC since 1970.
    #[serde(rename = "ticks")]
    Ticks,
    /// Days, or fractions of a day.
    #[serde(rename = "days")]
    Days,
    /// Days since 30 December 1899, as spreadsheets count, converted to UTC since 1970.
    #[serde(rename = "excel")]
    SpreadsheetDays,
    /// Days since the year 0, as `datenum` of MATLAB, converted to UTC since 1970.
    #[serde(rename = "datenum")]
    Datenum,
    /// Days since 17 November 1858, converted to UTC since 1970.
    #[serde(rename = "mjd")]
    ModifiedJulianDays,
    /// Numbers of samples, `rate_hz` of them in a second.
    #[serde(rename = "count")]
    Count,
    /// Dates and times of day, such as `2025-07-08T12:34:56.789Z` or `12:34:56.789`.
    #[serde(rename = "clock")]
    Clock,
    /// Times of day as one number, hhmmss.sss, as in NMEA 0183.
    #[serde(rename = "hhmmss")]
    HoursMinutesSeconds,
}

impl TimeUnit {
    /// Nanoseconds per unit; for clock times and counts, those of a second.
    const fn nanoseconds(self) -> i64 {
        match self {
            Self::Nanoseconds => 1,
            Self::FileTime | Self::Ticks => 100,
            Self::Microseconds => 1_000,
            Self::TenthMilliseconds => 100_000,
            Self::Milliseconds => 1_000_000,
            Self::Seconds | Self::Clock | Self::HoursMinutesSeconds | Self::Count => 1_000_000_000,
            Self::Days | Self::SpreadsheetDays | Self::Datenum | Self::ModifiedJulianDays => {
                86_400_000_000_000
            }
        }
    }

    /// Seconds per unit.
    pub(crate) fn seconds(self) -> f64 {
        self.nanoseconds() as f64 * 1e-9
    }

    /// Seconds from the zero of this unit to 1970; 0 for times on the logger's own clock.
    const fn before_1970_s(self) -> i64 {
        match self {
            Self::FileTime => 11_644_473_600,
            Self::Ticks => 62_135_596_800,
            Self::SpreadsheetDays => 2_209_161_600,
            Self::Datenum => 62_167_305_600,
            Self::ModifiedJulianDays => 3_506_716_800,
            _ => 0,
        }
    }

    /// The name in a mapping.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::TenthMilliseconds => "0.1ms",
            Self::FileTime => "filetime",
            Self::Ticks => "ticks",
            Self::Nanoseconds => "ns",
            Self::Microseconds => "us",
            Self::Milliseconds => "ms",
            Self::Seconds => "s",
            Self::Days => "days",
            Self::SpreadsheetDays => "excel",
            Self::Datenum => "datenum",
            Self::ModifiedJulianDays => "mjd",
            Self::Count => "count",
            Self::Clock => "clock",
            Self::HoursMinutesSeconds => "hhmmss",
        }
    }

    /// Whether the unit is a time of day, possibly with a date.
    pub(crate) const fn is_of_day(self) -> bool {
        matches!(self, Self::Clock | Self::HoursMinutesSeconds | Self::Days)
    }
}

/// The time in `field` in `unit`: `Some(None)` for an empty field or an unknown time, `None` for text that is not a
/// time.
pub(crate) fn time(field: &[u8], unit: TimeUnit, comma: bool) -> Option<Option<Time>> {
    let field = field.trim_ascii();
    if unit == TimeUnit::Clock {
        return if field.is_empty() { Some(None) } else { clock_time(field).map(Some) };
    }
    if let Some(nanoseconds) = scaled_nanoseconds(field, unit, comma) {
        return match unit {
            TimeUnit::HoursMinutesSeconds => time_of_day(nanoseconds).map(Some),
            _ => Some(Some(Time::from_nanoseconds(nanoseconds))),
        };
    }
    if unit == TimeUnit::HoursMinutesSeconds {
        return number(field, comma).filter(|value| value.is_nan()).map(|_| None);
    }
    let seconds = |value: f64| value * unit.seconds() - unit.before_1970_s() as f64;
    number(field, comma).map(|value| Time::try_from_seconds(seconds(value)))
}

/// A decimal number in `unit`, rounded to the nearest nanosecond, without floating-point error.
fn scaled_nanoseconds(field: &[u8], unit: TimeUnit, comma: bool) -> Option<i64> {
    let (negative, digits) = match field {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, field),
    };
    // Twenty-six digits stay below the limit of an i128, 1.7e38.
    if digits.is_empty() || digits.len() > 26 {
        return None;
    }
    let point = if comma { b',' } else { b'.' };
    let (mut sum, mut decimals, mut divisor) = (0i128, false, 1i128);
    for &byte in digits {
        if byte == point && !decimals {
            decimals = true;
            continue;
        }
        if !byte.is_ascii_digit() {
            return None;
        }
        sum = sum * 10 + i128::from(byte - b'0');
        divisor *= if decimals { 10 } else { 1 };
    }
    if digits.len() == usize::from(decimals) {
        return None;
    }
    let scaled = (sum.checked_mul(i128::from(unit.nanoseconds()))? + divisor / 2) / divisor;
    let scaled = if negative { -scaled } else { scaled };
    i64::try_from(scaled - i128::from(unit.before_1970_s()) * 1_000_000_000).ok()
}

/// A date and time, in UTC if it names no zone, or a time of day alone.
fn clock_time(field: &[u8]) -> Option<Time> {
    const OFFSETS: [&str; 2] = ["%Y-%m-%dT%H:%M:%S%.f%#z", "%Y-%m-%d %H:%M:%S%.f%#z"];
    let text = std::str::from_utf8(field).ok()?.replace(',', ".");
    if let Some(at) = OFFSETS.iter().find_map(|format| DateTime::parse_from_str(&text, format).ok())
    {
        return at.timestamp_nanos_opt().map(Time::from_nanoseconds);
    }
    let text = text.trim_end_matches('Z').trim_end_matches("UTC").trim_end();
    // The day precedes the month only with points as separators; the month precedes the day only with a.m. or p.m.
    // Other orders are ambiguous.
    let formats = [
        "%Y-%m-%dT%H:%M:%S%.f",
        "%Y-%m-%d %H:%M:%S%.f",
        "%Y/%m/%d %H:%M:%S%.f",
        "%d.%m.%Y %H:%M:%S%.f",
        "%m/%d/%Y %I:%M:%S%.f %p",
    ];
    if let Some(at) =
        formats.iter().find_map(|format| NaiveDateTime::parse_from_str(text, format).ok())
    {
        return at.and_utc().timestamp_nanos_opt().map(Time::from_nanoseconds);
    }
    let formats = ["%H:%M:%S%.f", "%I:%M:%S%.f %p"];
    let at = formats.iter().find_map(|format| NaiveTime::parse_from_str(text, format).ok())?;
    let seconds = i64::from(at.num_seconds_from_midnight());
    Some(Time::from_nanoseconds(seconds * 1_000_000_000 + i64::from(at.nanosecond())))
}

/// The time of day from hhmmss.sss in units of 1e-9; `None` if it is impossible.
fn time_of_day(hhmmss: i64) -> Option<Time> {
    const SECOND: i64 = 1_000_000_000;
    let whole = hhmmss.div_euclid(SECOND);
    let (hours, minutes, seconds) = (whole / 10_000, whole / 100 % 100, whole % 100);
    // Second 60 occurs in a leap second.
    (hhmmss >= 0 && hours < 24 && minutes < 60 && seconds <= 60).then(|| {
        let seconds = 3600 * hours + 60 * minutes + seconds;
        Time::from_nanoseconds(seconds * SECOND + hhmmss.rem_euclid(SECOND))
    })
}

/// The UTC midnight at which the date in `field` began: ddmmyy as in NMEA 0183, yyyymmdd, or with separators. Any other
/// number is read as the days since 30 December 1899 of spreadsheets. `Some(None)` for an empty field, `None` for text
/// that is not a date.
pub(crate) fn midnight(field: &[u8]) -> Option<Option<Time>> {
    /// Days from 2000 to 2073, as spreadsheets count.
    const SPREADSHEET_DAYS: std::ops::Range<u32> = 36_526..63_500;
    let text = std::str::from_utf8(field.trim_ascii()).ok()?;
    if text.is_empty() {
        return Some(None);
    }
    let number = text.parse::<u32>();
    let date = match number {
        Ok(date) if text.len() == 8 => {
            NaiveDate::from_ymd_opt((date / 10_000) as i32, date / 100 % 100, date % 100)
        }
        // The leading zero of the first nine days may be missing.
        Ok(date) if matches!(text.len(), 5 | 6) => {
            NaiveDate::from_ymd_opt(2000 + (date % 100) as i32, date / 100 % 100, date / 10_000)
        }
        _ => ["%Y-%m-%d", "%Y/%m/%d", "%d.%m.%Y"]
            .iter()
            .find_map(|format| NaiveDate::parse_from_str(text, format).ok()),
    };
    let Some(date) = date else {
        let is_day = number.is_ok_and(|days| SPREADSHEET_DAYS.contains(&days));
        return if is_day { time(text.as_bytes(), TimeUnit::SpreadsheetDays, false) } else { None };
    };
    let began = date.and_time(NaiveTime::MIN).and_utc();
    began.timestamp_nanos_opt().map(|nanoseconds| Some(Time::from_nanoseconds(nanoseconds)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nanoseconds(text: &str, unit: TimeUnit, comma: bool) -> Option<i64> {
        time(text.as_bytes(), unit, comma).flatten().map(Time::nanoseconds)
    }

    #[test]
    fn times_are_exact_in_every_unit() {
        use TimeUnit::{
            Clock, Datenum, Days, FileTime, HoursMinutesSeconds, Microseconds, Milliseconds,
            ModifiedJulianDays, Nanoseconds, Seconds, SpreadsheetDays, TenthMilliseconds, Ticks,
        };
        for (text, unit, comma, expected) in [
            ("1752000000.123456789", Seconds, false, 1_752_000_000_123_456_789),
            ("80.3", Milliseconds, false, 80_300_000),
            ("80,3", Milliseconds, true, 80_300_000),
            ("-5", Microseconds, false, -5_000),
            ("1752000000123456789", Nanoseconds, false, 1_752_000_000_123_456_789),
            ("303", TenthMilliseconds, false, 30_300_000),
            ("116444736015000000", FileTime, false, 1_500_000_000),
            ("621355968015000001", Ticks, false, 1_500_000_100),
            ("1e-3", Seconds, false, 1_000_000),
            ("0.5", Days, false, 43_200_000_000_000),
            ("40587.5", ModifiedJulianDays, false, 43_200_000_000_000),
            ("719529.5", Datenum, false, 43_200_000_000_000),
            ("25569.0000115740", SpreadsheetDays, false, 999_993_600),
            ("45416.417246874998", SpreadsheetDays, false, 1_714_816_850_129_999_827),
            ("1970-01-01T00:00:01.5Z", Clock, false, 1_500_000_000),
            ("1970-01-01T01:00:01+01:00", Clock, false, 1_000_000_000),
            ("1970-01-01T05:30:01+0530", Clock, false, 1_000_000_000),
            ("1970-01-01 00:00:02 UTC", Clock, false, 2_000_000_000),
            ("1970-01-01 00:00:02", Clock, false, 2_000_000_000),
            ("30.3ms", Milliseconds, false, 30_300_000),
            ("02.01.1970 00:00:02,5", Clock, true, 86_402_500_000_000),
            ("1/2/1970 1:00:02 PM", Clock, false, 133_202_000_000_000),
            ("00:01:00.25", Clock, false, 60_250_000_000),
            ("11:00:00.5 PM", Clock, false, 82_800_500_000_000),
            ("235959.999", HoursMinutesSeconds, false, 86_399_999_000_000),
            ("000100,5", HoursMinutesSeconds, true, 60_500_000_000),
            ("130.25", HoursMinutesSeconds, false, 90_250_000_000),
        ] {
            assert_eq!(nanoseconds(text, unit, comma), Some(expected), "{text}");
        }
        for (text, unit) in [
            ("abc", Seconds),
            (".", Seconds),
            ("-", Clock),
            ("25:00:00", Clock),
            ("240000", HoursMinutesSeconds),
            ("006000", HoursMinutesSeconds),
            ("000061", HoursMinutesSeconds),
            ("-1", HoursMinutesSeconds),
            ("", HoursMinutesSeconds),
        ] {
            assert_eq!(time(text.as_bytes(), unit, false).flatten(), None, "{text}");
        }
    }

    #[test]
    fn dates_without_separators_begin_with_the_day() {
        for text in ["020170", "20170", "19700102", "1970-01-02", "1970/01/02", "02.01.1970"] {
            // Two-digit years are in this century.
            let days = if text.len() < 8 { 36_526.0 } else { 1.0 };
            let began = midnight(text.as_bytes()).flatten().unwrap().seconds();
            assert_eq!(began, 86_400.0 * days, "{text}");
        }
        assert_eq!(midnight(b"45416").flatten().unwrap().seconds(), 1_714_780_800.0);
        assert_eq!(midnight(b""), Some(None));
        for text in ["320170", "021370", "1.5", "-20170", "today"] {
            assert_eq!(midnight(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn units_and_hemispheres_follow_numbers_with_or_without_a_blank() {
        for (text, value) in [
            ("374.812 m", 374.812),
            ("49.73m", 49.73),
            ("-0.07g", -0.07),
            ("1.352°", 1.352),
            ("9.81m/s2", 9.81),
            ("-9.81 m/s²", -9.81),
            ("1e-3rad/s", 1e-3),
            ("0121.1259N", 121.1259),
            ("15112.5W", -15112.5),
            ("33.8568 S", -33.8568),
            ("33°51'24.5\"S", -(33.0 + 51.0 / 60.0 + 24.5 / 3600.0)),
            ("1° 21.125' N", 1.0 + 21.125 / 60.0),
        ] {
            assert_eq!(number(text.as_bytes(), false), Some(value), "{text}");
        }
        for text in ["0x1F", "12:34:56", "2025-07-08T12:00:00Z", "5 / 20", "m", "1.2.3"] {
            assert_eq!(number(text.as_bytes(), false), None, "{text}");
        }
    }

    #[test]
    fn values_that_are_not_finite_are_unknown() {
        for text in ["1.#QNAN", "-1.#IND", "-nan(ind)", "1.#INF", "NaN", "NULL", "--"] {
            assert!(number(text.as_bytes(), false).unwrap().is_nan(), "{text}");
        }
        assert!(number(b"?", false).is_none() && is_word(b"?"));
    }

    #[test]
    fn words_state_whether_there_is_a_fix() {
        for (text, expected) in
            [("3D", 3.0), ("2", 2.0), ("none", 0.0), ("NO FIX", 0.0), ("SPS", 3.0), ("V", 0.0)]
        {
            assert_eq!(fix_type(text.as_bytes()), expected, "{text}");
        }
        assert!(["", "?", "11(11)", "nan"].iter().all(|text| fix_type(text.as_bytes()).is_nan()));
    }

    #[test]
    fn a_decimal_comma_is_read_where_it_is_one() {
        assert_eq!(number(b"-1,25", true), Some(-1.25));
        assert_eq!(number(b"-1,25", false), None);
        assert_eq!(number(b"1.25", true), None);
        assert!(number(b" ", true).unwrap().is_nan());
    }
}
