//! The form of a sentence's fields.
//!
//! The `nmea` crate's parsers take numbers in any form that Rust does (`nan`, `1e9`), latitudes of
//! 99° with 99 minutes, and no more than two letters of mode. So they are shown a copy, in which a
//! field that has not the form of its kind is left empty.

use core::ops::Range;

use nmea::SentenceType;

/// A copy of a sentence's data in which every field is empty or of its kind's form.
pub(super) struct Fields {
    bytes: [u8; 128],
    length: usize,
}

impl Fields {
    /// The copy; `None` when the data is longer than any sentence.
    pub fn of(kind: SentenceType, data: &str) -> Option<Self> {
        let mut copy = Self { bytes: [0; 128], length: 0 };
        let unreadable_place = place(kind).filter(|fields| !has_place(data, fields.start));
        for (index, field) in data.split(',').enumerate() {
            if index > 0 {
                copy.push(b",")?;
            }
            let in_place = unreadable_place.as_ref().is_some_and(|fields| fields.contains(&index));
            if !in_place && !is_unwanted(kind, index) {
                copy.push(well_formed(kind, index, field))?;
            }
        }
        Some(copy)
    }

    pub fn as_str(&self) -> &str {
        self.bytes.get(..self.length).and_then(|text| str::from_utf8(text).ok()).unwrap_or_default()
    }

    fn push(&mut self, bytes: &[u8]) -> Option<()> {
        let end = self.length.checked_add(bytes.len())?;
        self.bytes.get_mut(self.length..end)?.copy_from_slice(bytes);
        self.length = end;
        Some(())
    }
}

/// The field, or as much of it as has the form of its kind.
fn well_formed(kind: SentenceType, index: usize, field: &str) -> &[u8] {
    let bytes = field.as_bytes();
    let time = index == 0 && !matches!(kind, SentenceType::VTG | SentenceType::GSA);
    if bytes.iter().all(u8::is_ascii_alphabetic) {
        match (kind, index) {
            (SentenceType::GNS, 5) => best_mode(bytes),
            _ if bytes.len() > 1 => &[],
            _ => bytes,
        }
    } else if is_number(field) && (!time || whole_digits(field).len() == 6) {
        bytes
    } else {
        &[]
    }
}

/// The letter of the best mode: GNS has one for each satellite system.
fn best_mode(modes: &[u8]) -> &[u8] {
    let best = b"RFPDA".iter().find_map(|good| modes.iter().position(|mode| mode == good));
    modes.get(best.unwrap_or(0)..).and_then(|rest| rest.get(..1)).unwrap_or_default()
}

/// RMC's magnetic variation: not used, and sent in forms that would cost the sentence.
fn is_unwanted(kind: SentenceType, index: usize) -> bool {
    kind == SentenceType::RMC && matches!(index, 9 | 10)
}

/// An optional minus, digits, and a point in or after them.
fn is_number(field: &str) -> bool {
    let digits = field.strip_prefix('-').unwrap_or(field);
    digits.starts_with(|first: char| first.is_ascii_digit() || first == '.')
        && digits.bytes().any(|byte| byte.is_ascii_digit())
        && digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.')
        && digits.bytes().filter(|byte| *byte == b'.').count() <= 1
}

/// Where latitude, its letter, longitude and its letter stand.
fn place(kind: SentenceType) -> Option<Range<usize>> {
    match kind {
        SentenceType::GGA | SentenceType::GNS => Some(1..5),
        SentenceType::RMC => Some(2..6),
        _ => None,
    }
}

/// Whether latitude and longitude are `ddmm` and `dddmm` with minutes below 60.
fn has_place(data: &str, first: usize) -> bool {
    let mut fields = data.split(',').skip(first).step_by(2).map(whole_digits);
    matches!(
        (fields.next(), fields.next()),
        (Some([_, _, b'0'..=b'5', _]), Some([_, _, _, b'0'..=b'5', _]))
    )
}

/// The digits before the point; nothing if there is anything else.
fn whole_digits(field: &str) -> &[u8] {
    let whole = field.split('.').next().unwrap_or_default().as_bytes();
    if whole.iter().all(u8::is_ascii_digit) { whole } else { &[] }
}
