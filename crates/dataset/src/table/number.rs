//! Numbers from text: times exact to the nanosecond, everything else as f64.

use hovernav::time::Time;

/// The number in `field`; NaN for an empty field, `None` if it is not a number.
pub(crate) fn parse_number(field: &[u8]) -> Option<f64> {
    let field = field.trim_ascii();
    if field.is_empty() {
        return Some(f64::NAN);
    }
    match parse_plain(field) {
        Some(number) => Some(number),
        None => std::str::from_utf8(field).ok()?.parse().ok(),
    }
}

/// The number in a field of digits with at most one decimal point; `None` for longer or other fields. The digits and
/// the power of ten are both exact, so their quotient is the nearest number.
///
/// # Source
/// W. D. Clinger (1990), How to read floating point numbers accurately, *ACM SIGPLAN Notices* 25 (6),
/// 92–101: the case that needs no more than one operation.
fn parse_plain(field: &[u8]) -> Option<f64> {
    /// Largest number of decimal digits whose value is always below 2⁵³, so exact as `f64`.
    const MAX_DIGITS: usize = 15;
    const TENS: [f64; MAX_DIGITS + 1] =
        [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
    let (negative, digits) = match field {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, field),
    };
    if digits.len() > MAX_DIGITS + 1 {
        return None;
    }
    let (mut whole, mut count, mut point) = (0u64, 0, None);
    for &byte in digits {
        if byte == b'.' && point.is_none() {
            point = Some(count);
            continue;
        }
        whole = 10 * whole + u64::from(byte.is_ascii_digit().then(|| byte - b'0')?);
        count += 1;
    }
    if count == 0 || count > MAX_DIGITS {
        return None;
    }
    let number = whole as f64 / TENS[point.map_or(0, |point| count - point)];
    Some(if negative { -number } else { number })
}

/// The time in `field`, in seconds. `Some(None)` if the field is empty, not finite or out of the range of a [`Time`];
/// `None` if it is not a number.
///
/// Plain decimals are converted directly to nanoseconds, further digits rounded half away from zero. So a clock that
/// counts seconds since 1970 loses nothing to floating point.
pub(crate) fn parse_time(field: &[u8]) -> Option<Option<Time>> {
    let field = field.trim_ascii();
    match parse_decimal_nanoseconds(field) {
        Some(nanoseconds) => Some(Some(Time::from_nanoseconds(nanoseconds))),
        None => parse_number(field).map(Time::try_from_seconds),
    }
}

fn parse_decimal_nanoseconds(field: &[u8]) -> Option<i64> {
    let (negative, digits) = match field {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, field),
    };
    let point = digits.iter().position(|&byte| byte == b'.').unwrap_or(digits.len());
    let (whole, fraction) = (&digits[..point], digits.get(point + 1..).unwrap_or_default());
    // Ten digits of seconds exceed the ±9.2e9 s of a time, and cannot overflow below.
    if whole.is_empty() || whole.len() > 10 {
        return None;
    }
    let mut seconds = 0i64;
    for &byte in whole {
        seconds = 10 * seconds + digit(byte)?;
    }
    let mut nanoseconds = 0i64;
    let mut weight = 100_000_000;
    for (place, &byte) in fraction.iter().enumerate() {
        let digit = digit(byte)?;
        nanoseconds += digit * weight;
        weight /= 10;
        if place == 9 && digit >= 5 {
            nanoseconds += 1;
        }
    }
    let total = seconds.checked_mul(1_000_000_000)?.checked_add(nanoseconds)?;
    Some(if negative { -total } else { total })
}

fn digit(byte: u8) -> Option<i64> {
    byte.is_ascii_digit().then(|| i64::from(byte - b'0'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn nanoseconds(text: &str) -> Option<i64> {
        parse_time(text.as_bytes()).flatten().map(Time::nanoseconds)
    }

    #[test]
    fn decimal_seconds_reach_the_nanosecond_without_rounding() {
        assert_eq!(nanoseconds("1752000000.123456789"), Some(1_752_000_000_123_456_789));
        assert_eq!(nanoseconds("0.08030"), Some(80_300_000));
        assert_eq!(nanoseconds(" -3.5 "), Some(-3_500_000_000));
        assert_eq!(nanoseconds("-0.5"), Some(-500_000_000));
        assert_eq!(nanoseconds("7"), Some(7_000_000_000));
        assert_eq!(nanoseconds("7."), Some(7_000_000_000));
        assert_eq!(nanoseconds("0.0000000015"), Some(2));
        assert_eq!(nanoseconds("0.99999999999"), Some(1_000_000_000));
        assert_eq!(nanoseconds("1e-05"), Some(10_000));
        assert_eq!(nanoseconds(".25"), Some(250_000_000));
    }

    #[test]
    fn what_no_clock_shows_is_unknown_and_what_is_no_number_is_refused() {
        for unknown in ["", "  ", "nan", "-NaN", "inf", "1e30", "9999999999", "123456789012345"] {
            assert_eq!(parse_time(unknown.as_bytes()), Some(None), "{unknown}");
        }
        for text in ["abc", "1.2.3", "--1", "-", "+", ".", "1,5", "0x10", "12:30:05"] {
            assert_eq!(parse_time(text.as_bytes()), None, "{text}");
        }
        assert_eq!(parse_number(b"\xff\xfe"), None);
    }

    proptest! {
        #[test]
        fn plain_numbers_are_the_nearest_to_what_is_written(
            text in "-?[0-9]{0,9}(\\.[0-9]{0,9})?|-?[0-9.]{0,20}|-?[0-9]{1,3}e-?[0-9]{1,2}",
        ) {
            let expected: Option<f64> = if text.is_empty() { Some(f64::NAN) } else { text.parse().ok() };
            let found = parse_number(text.as_bytes());
            prop_assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits), "{}", text);
        }

        #[test]
        fn times_written_with_nine_decimals_come_back_exactly(ns in -9_200_000_000_000_000_000i64..9_200_000_000_000_000_000) {
            let text = format!("{}{}.{:09}", if ns < 0 { "-" } else { "" },
                ns.unsigned_abs() / 1_000_000_000, ns.unsigned_abs() % 1_000_000_000);
            prop_assert_eq!(nanoseconds(&text), Some(ns));
        }
    }
}
