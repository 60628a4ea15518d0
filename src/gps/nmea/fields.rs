//! The comma-separated fields of a sentence, read in order.
//!
//! Receivers leave a field empty if they have no value. An invalid number, such as `0x9` or `nan`, counts as an empty
//! field: only this field is lost. A letter in place of a number, or a missing field, means that the sentence does
//! not match its name.

use crate::gps::receiver_time::days_since_1970;

/// The sentence does not match its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Malformed;

/// Latitude north and longitude east, degrees, before the range check.
pub(super) type Degrees = (f64, f64);

/// The fields that have not been read yet.
#[derive(Clone, Debug)]
pub(super) struct Fields<'a>(Option<&'a [u8]>);

impl<'a> Fields<'a> {
    /// The fields of `data`, the text after the first comma of a sentence.
    pub fn new(data: &'a [u8]) -> Self {
        Self(Some(data))
    }

    /// Whether all fields have been read.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    /// The next field, as the receiver sent it.
    pub fn text(&mut self) -> Result<&'a [u8], Malformed> {
        let rest = self.0.ok_or(Malformed)?;
        let (field, rest) = split_at(rest, b',').map_or((rest, None), |(a, b)| (a, Some(b)));
        self.0 = rest;
        Ok(field)
    }

    /// The next field; a field of one letter is an error.
    fn numeral(&mut self) -> Result<&'a [u8], Malformed> {
        let field = self.text()?;
        let is_letter = single(field).is_some_and(|byte| byte.is_ascii_alphabetic());
        if is_letter { Err(Malformed) } else { Ok(field) }
    }

    /// Skips `count` fields, which must be present.
    pub fn skip(&mut self, count: usize) -> Result<(), Malformed> {
        // Iterations: at most one per field, because reading beyond the last field is an error.
        for _ in 0..count {
            self.text()?;
        }
        Ok(())
    }

    /// The next field if it is a single letter.
    pub fn letter(&mut self) -> Result<Option<u8>, Malformed> {
        Ok(single(self.text()?).filter(u8::is_ascii_alphabetic))
    }

    /// The next field, a single letter; `None` where it is empty or missing.
    pub fn optional_letter(&mut self) -> Result<Option<u8>, Malformed> {
        match self.text().unwrap_or_default() {
            [] => Ok(None),
            [letter] if letter.is_ascii_alphabetic() => Ok(Some(*letter)),
            _ => Err(Malformed),
        }
    }

    /// The next field if it is a single digit.
    pub fn digit(&mut self) -> Result<Option<u8>, Malformed> {
        Ok(single(self.text()?).filter(u8::is_ascii_digit))
    }

    /// Checks that the next field is the unit `letter`, or empty.
    pub fn unit(&mut self, letter: u8) -> Result<(), Malformed> {
        match self.text()? {
            [] => Ok(()),
            [found] if *found == letter => Ok(()),
            _ => Err(Malformed),
        }
    }

    /// The next field as a decimal number.
    pub fn number(&mut self) -> Result<Option<f64>, Malformed> {
        Ok(decimal(self.numeral()?))
    }

    /// The next field as a number without sign and fraction.
    pub fn count(&mut self) -> Result<Option<u32>, Malformed> {
        match self.text()? {
            [] => Ok(None),
            field => whole(field).map(Some).ok_or(Malformed),
        }
    }

    /// The next field, `hhmmss.sss`, as nanoseconds since midnight. A leap second, 23:59:60, follows the day's last.
    pub fn time_of_day_ns(&mut self) -> Result<Option<u64>, Malformed> {
        let field = self.numeral()?;
        let (digits, fraction) = split_at(field, b'.').unwrap_or((field, &[]));
        let [h1, h0, m1, m0, s1, s0] = digits else {
            return Ok(None);
        };
        let (Some(hours), Some(minutes), Some(seconds)) =
            (whole(&[*h1, *h0]), whole(&[*m1, *m0]), whole(&[*s1, *s0]))
        else {
            return Ok(None);
        };
        let Some(fraction_ns) = nanoseconds(fraction) else {
            return Ok(None);
        };
        let is_leap = (hours, minutes, seconds) == (23, 59, 60);
        if hours >= 24 || minutes >= 60 || (seconds >= 60 && !is_leap) {
            return Err(Malformed);
        }
        let whole_s = u64::from(hours * 3_600 + minutes * 60 + seconds);
        Ok(Some(whole_s * 1_000_000_000 + fraction_ns))
    }

    /// The next field, `ddmmyy`, as days since 1 January 1970; the years are 1983 to 2082.
    pub fn day(&mut self) -> Result<Option<i32>, Malformed> {
        let field = self.numeral()?;
        let [d1, d0, m1, m0, y1, y0] = field else {
            return if decimal(field).is_some() { Err(Malformed) } else { Ok(None) };
        };
        let (Some(day), Some(month), Some(year)) =
            (whole(&[*d1, *d0]), whole(&[*m1, *m0]), whole(&[*y1, *y0]))
        else {
            return Ok(None);
        };
        let century = if year >= 83 { 1_900 } else { 2_000 };
        days_since_1970(century + year, month, day).map(Some).ok_or(Malformed)
    }

    /// The next four fields: latitude `ddmm.mmm`, its letter, longitude `dddmm.mmm`, its letter. `None` for another
    /// number of digits, or for 60 minutes or more.
    pub fn place(&mut self) -> Result<Option<Degrees>, Malformed> {
        let (latitude, south) = (self.text()?, self.text()?);
        let (longitude, west) = (self.text()?, self.text()?);
        let Some((latitude, longitude)) = angle(latitude, 2).zip(angle(longitude, 3)) else {
            return Ok(None);
        };
        let latitude = match south {
            b"N" => latitude,
            b"S" => -latitude,
            _ => return Err(Malformed),
        };
        match west {
            b"E" => Ok(Some((latitude, longitude))),
            b"W" => Ok(Some((latitude, -longitude))),
            _ => Err(Malformed),
        }
    }
}

/// The parts before and after the first `separator`.
fn split_at(bytes: &[u8], separator: u8) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|byte| *byte == separator)?;
    let (before, rest) = bytes.split_at_checked(end)?;
    Some((before, rest.get(1..)?))
}

fn single(field: &[u8]) -> Option<u8> {
    match field {
        [byte] => Some(*byte),
        _ => None,
    }
}

/// Degrees from digits; the last two digits before the point are whole minutes.
fn angle(field: &[u8], degree_digits: usize) -> Option<f64> {
    let whole_digits = split_at(field, b'.').map_or(field, |(before, _)| before);
    let (degrees, minutes) = field.split_at_checked(degree_digits)?;
    if whole_digits.len() != degree_digits + 2 || minutes.first().is_none_or(|tens| *tens > b'5') {
        return None;
    }
    Some(f64::from(whole(degrees)?) + decimal(minutes).filter(|minutes| *minutes >= 0.0)? / 60.0)
}

/// A number of one to nine digits, without any other character.
fn whole(field: &[u8]) -> Option<u32> {
    if field.is_empty() || field.len() > 9 {
        return None;
    }
    field.iter().try_fold(0u32, |value, byte| {
        let digit = byte.is_ascii_digit().then(|| u32::from(byte & 0x0F))?;
        Some(value.wrapping_mul(10).wrapping_add(digit))
    })
}

/// Nanoseconds from the digits after the point of a second; digits beyond the ninth are ignored.
fn nanoseconds(fraction: &[u8]) -> Option<u64> {
    let mut unit_ns = 1_000_000_000;
    fraction.iter().try_fold(0u64, |value, byte| {
        unit_ns /= 10;
        let digit = byte.is_ascii_digit().then(|| u64::from(byte & 0x0F))?;
        Some(value.wrapping_add(digit * unit_ns))
    })
}

/// A decimal number: an optional minus, digits, and at most one point before, between or after them.
///
/// Numbers of up to 15 digits are correctly rounded. Their digits and the power of ten that divides them are exact,
/// and the division rounds once. Further digits after the point are ignored, an error below one part in 10¹⁴. More
/// than 15 digits before the point are invalid: no receiver sends them.
///
/// # Source
/// W. D. Clinger, *How to read floating point numbers accurately*, PLDI 1990, section 3.
fn decimal(field: &[u8]) -> Option<f64> {
    const FULL: u64 = 100_000_000_000_000;
    let (negative, digits) = match field {
        [b'-', digits @ ..] => (true, digits),
        digits => (false, digits),
    };
    let (mut mantissa, mut divisor) = (0u64, 1u64);
    let (mut has_digit, mut has_point) = (false, false);
    for byte in digits {
        match byte {
            b'0'..=b'9' => {
                has_digit = true;
                if mantissa < FULL && divisor <= FULL {
                    mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(byte & 0x0F));
                    divisor = if has_point { divisor.wrapping_mul(10) } else { divisor };
                } else if !has_point {
                    return None;
                }
            }
            b'.' if !has_point => has_point = true,
            _ => return None,
        }
    }
    let value = mantissa as f64 / divisor as f64;
    has_digit.then_some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn time(field: &str) -> Result<Option<u64>, Malformed> {
        Fields::new(field.as_bytes()).time_of_day_ns()
    }

    fn day(field: &str) -> Result<Option<i32>, Malformed> {
        Fields::new(field.as_bytes()).day()
    }

    #[test]
    fn a_number_is_an_optional_minus_digits_and_one_point() {
        for (field, value) in [
            ("0", 0.0),
            ("-4.25", -4.25),
            (".5", 0.5),
            ("5.", 5.0),
            ("0010.50", 10.5),
            ("0.000000000000000000009", 0.0),
            ("123456789012345", 123_456_789_012_345.0),
        ] {
            assert_eq!(decimal(field.as_bytes()), Some(value), "{field}");
        }
        for field in ["", "-", ".", "-.", "+1", "1e3", "nan", "inf", "0x9", "1.2.3", "1-", "--1"] {
            assert_eq!(decimal(field.as_bytes()), None, "{field}");
        }
        assert_eq!(decimal(b"1234567890123456"), None);
    }

    #[test]
    fn a_missing_field_is_an_error_and_an_empty_one_is_not() {
        let mut fields = Fields::new(b"1.5,,7");
        assert_eq!(fields.number(), Ok(Some(1.5)));
        assert_eq!(fields.number(), Ok(None));
        assert_eq!(fields.count(), Ok(Some(7)));
        assert_eq!(fields.number(), Err(Malformed));
    }

    #[test]
    fn times_are_whole_nanoseconds_of_a_day_and_its_leap_second() {
        assert_eq!(time("000000"), Ok(Some(0)));
        assert_eq!(time("094812.25"), Ok(Some(35_292_250_000_000)));
        assert_eq!(time("235959.9999999999"), Ok(Some(86_399_999_999_999)));
        for field in ["", "94812.00", "-94812", "0948a2", "094812.x"] {
            assert_eq!(time(field), Ok(None), "{field}");
        }
        assert_eq!(time("235960.50"), Ok(Some(86_400_500_000_000)));
        for field in ["240000", "096000", "094860", "225960", "A"] {
            assert_eq!(time(field), Err(Malformed), "{field}");
        }
    }

    #[test]
    fn years_of_two_digits_reach_from_1983_to_2082() {
        assert_eq!(day("010183"), Ok(Some(4_748)));
        assert_eq!(day("311282"), Ok(Some(41_272)));
        assert_eq!(day("230305"), Ok(Some(12_865)));
        assert_eq!(day("2303-5"), Ok(None));
        for field in ["310405", "290205", "000105", "011305", "2303055", "A"] {
            assert_eq!(day(field), Err(Malformed), "{field}");
        }
    }

    proptest! {
        #[test]
        fn numbers_of_fifteen_digits_are_rounded_as_the_standard_library_rounds(
            whole in 0u64..1_000_000_000,
            fraction in "[0-9]{0,6}",
            negative: bool,
        ) {
            let text = format!("{}{whole}.{fraction}", if negative { "-" } else { "" });
            prop_assert_eq!(decimal(text.as_bytes()), Some(text.parse::<f64>().unwrap()));
        }

        #[test]
        fn longer_numbers_are_right_to_a_part_in_1e14(
            whole in 0u64..1_000_000_000,
            fraction in "[0-9]{7,30}",
        ) {
            let text = format!("{whole}.{fraction}");
            let (found, exact) = (decimal(text.as_bytes()).unwrap(), text.parse::<f64>().unwrap());
            prop_assert!((found - exact).abs() <= exact.max(1.0) * 1e-14, "{} {}", found, exact);
        }
    }
}
