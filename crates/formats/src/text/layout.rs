//! Layout of a text file: delimiter, line of the names, first row.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::decimal::{TimeUnit, number, time};
use super::lines::Lines;
use hovernav_dataset::LogError;

/// Separator of the fields of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Delimiter {
    /// `,`
    #[default]
    Comma,
    /// `;`
    Semicolon,
    /// A tab.
    Tab,
    /// One or more blanks or tabs.
    Spaces,
}

impl Delimiter {
    /// The name in a mapping.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Comma => "comma",
            Self::Semicolon => "semicolon",
            Self::Tab => "tab",
            Self::Spaces => "spaces",
        }
    }

    /// Splits `line` into fields, without surrounding blanks and quotes. A quoted field may contain the delimiter.
    pub(crate) fn split<'a>(self, line: &'a [u8], fields: &mut Vec<&'a [u8]>) {
        fields.clear();
        let byte = match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
            Self::Spaces => {
                let parts = line.split(u8::is_ascii_whitespace).filter(|part| !part.is_empty());
                return fields.extend(parts.map(unquoted));
            }
        };
        let (mut start, mut quoted) = (0, false);
        for (at, &found) in line.iter().enumerate() {
            // A quote inside a field means seconds of arc.
            quoted ^= found == b'"' && line[start..=at].trim_ascii_start().starts_with(b"\"");
            if found == byte && !quoted {
                fields.push(unquoted(&line[start..at]));
                start = at + 1;
            }
        }
        fields.push(unquoted(&line[start..]));
    }
}

fn unquoted(field: &[u8]) -> &[u8] {
    let field = field.trim_ascii();
    let inside = field.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\""));
    inside.map_or(field, <[u8]>::trim_ascii)
}

/// The layout of a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub delimiter: Delimiter,
    pub decimal_comma: bool,
    /// Line number of the names, from 1; 0 in a file without names.
    pub header_line: u64,
    /// Names of the columns; without names, their numbers from 1.
    pub names: Vec<String>,
    /// Text in each column between the names and the first row, such as units.
    pub below_names: Vec<String>,
    /// Rate of the rows that a line above them states, as in `Update Rate: 100.0Hz`, in thousandths of a hertz.
    pub rate_mhz: Option<u64>,
    /// Counts of the accelerometer per g that a line above them states as `acc_1G`, as Betaflight does.
    pub acc_counts_per_g: Option<u32>,
    /// Counts of the gyro per degree per second, by `gyro_scale` above them.
    pub gyro_counts_per_degps: Scale,
}

/// A positive number, by its bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Scale(u32);

impl Scale {
    const ONE: Self = Self(1f32.to_bits());

    /// Counts per unit from units per count, which are hexadecimal bits of a float; 1 for other text.
    fn of(text: &str) -> Self {
        let bits = text.strip_prefix("0x").and_then(|bits| u32::from_str_radix(bits, 16).ok());
        let scale = bits.map(f32::from_bits).filter(|scale| scale.is_normal() && *scale > 0.0);
        scale.map_or(Self::ONE, |scale| Self(scale.recip().to_bits()))
    }

    /// The number.
    pub fn get(self) -> f64 {
        f64::from(f32::from_bits(self.0))
    }
}

/// Number of lines that determine a file's layout.
const LINES_LOOKED_AT: usize = 400;

/// Whether `line` is a comment.
pub(crate) fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    matches!(line.first(), Some(b'#' | b'%' | b'!')) || line.starts_with(b"//")
}

/// `line` without its comment marks.
pub(crate) fn without_comment(line: &[u8]) -> &[u8] {
    let text = line.trim_ascii_start();
    let marks = text.iter().take_while(|byte| matches!(byte, b'#' | b'%' | b'!' | b'/'));
    let marks = marks.count();
    text[marks..].trim_ascii_start()
}

/// Whether `field` can be part of a row: a number, a time, or an empty field.
fn is_value(field: &[u8], comma: bool) -> bool {
    number(field, comma).is_some()
        || field.first().is_some_and(u8::is_ascii_digit)
            && time(field, TimeUnit::Clock, false).is_some()
}

/// Whether `field` is the letter of a hemisphere.
fn is_hemisphere(field: &[u8]) -> bool {
    matches!(field, [b'N' | b'S' | b'E' | b'W'])
}

impl Layout {
    /// Determines the layout of `path` from its first lines.
    ///
    /// # Errors
    /// [`LogError`] if the file cannot be read or contains no columns of numbers.
    pub fn of(path: &Path) -> Result<Self, LogError> {
        let mut lines = Lines::open(path)?;
        let mut head: Vec<Vec<u8>> = Vec::new();
        while head.len() < LINES_LOOKED_AT
            && let Some(line) = lines.next()?
        {
            head.push(line.to_vec());
        }
        let candidates = [
            (Delimiter::Semicolon, true),
            (Delimiter::Semicolon, false),
            (Delimiter::Tab, true),
            (Delimiter::Tab, false),
            (Delimiter::Comma, false),
            // A decimal comma with the delimiter comma is only for numbers in quotes; otherwise it would separate
            // fields.
            (Delimiter::Comma, true),
            (Delimiter::Spaces, true),
            (Delimiter::Spaces, false),
        ];
        let mut best: Option<(usize, Self)> = None;
        for (delimiter, comma) in candidates {
            if let Some((score, layout)) = Self::tried(&head, delimiter, comma)
                && best.as_ref().is_none_or(|(highest, _)| score > *highest)
            {
                best = Some((score, layout));
            }
        }
        best.map(|(_, layout)| layout).ok_or_else(|| LogError::Unusable {
            path: path.to_path_buf(),
            reason: "found fewer than two columns of numbers in the first lines, expected rows \
                     separated by commas, semicolons, tabs or blanks"
                .into(),
        })
    }

    /// The layout with `delimiter`, and the number of fields that it explains.
    fn tried(head: &[Vec<u8>], delimiter: Delimiter, comma: bool) -> Option<(usize, Self)> {
        let mut fields = Vec::new();
        // Index and number of fields of each row of values, and whether its last field is empty.
        let mut rows: Vec<(usize, usize, bool)> = Vec::new();
        for (index, line) in head.iter().enumerate() {
            delimiter.split(line, &mut fields);
            let filled = fields.iter().filter(|field| !field.is_empty()).count();
            let values = fields.iter().filter(|field| is_value(field, comma)).count();
            // Letters of hemispheres count as values in a row that also has numbers; alone they may be names.
            let letters = fields.iter().filter(|field| is_hemisphere(field)).count();
            let is_row = !is_comment(line)
                && filled >= 2
                && 2 * values >= fields.len()
                && 10 * (values + letters) >= 7 * fields.len();
            if is_row {
                rows.push((index, fields.len(), fields.last().is_some_and(|last| last.is_empty())));
            }
        }
        let width = most_common(rows.iter().map(|(_, width, _)| *width))?;
        rows.retain(|(_, found, _)| *found == width);
        let first = rows.first()?.0;
        let mut layout = Self {
            delimiter,
            decimal_comma: comma,
            header_line: 0,
            names: (1..=width).map(|number| number.to_string()).collect(),
            below_names: Vec::new(),
            rate_mhz: head[..first].iter().find_map(|line| stated_rate_mhz(line)),
            acc_counts_per_g: stated(&head[..first], "acc_1g").and_then(|text| text.parse().ok()),
            gyro_counts_per_degps: stated(&head[..first], "gyro_scale")
                .map_or(Scale::ONE, Scale::of),
        };
        let is_open = rows.iter().all(|(.., is_open)| *is_open);
        layout.find_names(&head[..first], width, is_open);
        let commas = head.iter().flatten().filter(|byte| **byte == b',').count();
        let score = rows.len() * width;
        // Without a comma in the file, the assumption of a decimal comma explains nothing.
        (!comma || commas > 0).then_some((score, layout))
    }

    /// Looks for names above the rows: the first line with the same number of fields that is not a row. It may be a
    /// comment if no other line has names. `is_open` means that every row ends with a delimiter, which the line of
    /// names may lack.
    fn find_names(&mut self, above: &[Vec<u8>], width: usize, is_open: bool) {
        let mut found: Vec<(u64, bool, Vec<String>)> = Vec::new();
        for (number, line) in (1..).zip(above) {
            let mut names = header_names(line, self.delimiter);
            // A trailing delimiter adds an empty name.
            if names.len() == width + 1 && names.last().is_some_and(String::is_empty) {
                names.pop();
            } else if names.len() + 1 == width && is_open {
                names.push(String::new());
            }
            let is_row = names.iter().all(|name| is_value(name.as_bytes(), false));
            if names.len() == width && !is_row {
                found.push((number, is_comment(line), names));
            }
        }
        let first = found.iter().position(|(_, is_comment, _)| !is_comment).unwrap_or(0);
        if first < found.len() {
            (self.header_line, _, self.names) = found.remove(first);
            self.below_names = found.pop().map(|(_, _, names)| names).unwrap_or_default();
        }
    }
}

/// The value of `key`, in small letters, in the lines above the names: `"acc_1G","2048"`, `H acc_1G:2048`.
fn stated<'a>(above: &'a [Vec<u8>], key: &str) -> Option<&'a str> {
    let is_part = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '.');
    above.iter().find_map(|line| {
        let mut words = std::str::from_utf8(line).ok()?.split(|letter| !is_part(letter));
        words.find(|word| word.eq_ignore_ascii_case(key))?;
        words.find(|word| !word.is_empty())
    })
}

/// The rate, 1e-3 Hz, that a line without other numbers states.
fn stated_rate_mhz(line: &[u8]) -> Option<u64> {
    let text = String::from_utf8_lossy(line).to_lowercase();
    let is_rate = ["rate", "freq", "odr"].iter().any(|word| text.contains(word));
    if !is_rate || !text.contains("hz") {
        return None;
    }
    let is_part = |letter: char| letter.is_ascii_digit() || letter == '.';
    let numbers = text.split(|letter| !is_part(letter)).filter_map(|part| part.parse::<f64>().ok());
    let mut numbers = numbers.filter(|rate_hz| *rate_hz > 0.0);
    let rate_hz = numbers.next().filter(|_| numbers.next().is_none())?;
    Some((rate_hz * 1e3).round() as u64)
}

/// The names in a line, which may be a comment. RTKLIB has one name for a date and a time of day.
pub(crate) fn header_names(line: &[u8], delimiter: Delimiter) -> Vec<String> {
    const OF_TWO: [&[u8]; 3] = [b"UTC", b"GPST", b"JST"];
    let mut fields = Vec::new();
    delimiter.split(without_comment(line), &mut fields);
    let mut names: Vec<String> =
        fields.iter().map(|field| String::from_utf8_lossy(field).into_owned()).collect();
    // A column needs a name to be found by, except behind a delimiter at the end.
    let last = names.len().saturating_sub(1);
    for (number, name) in names[..last].iter_mut().enumerate().filter(|(_, name)| name.is_empty()) {
        *name = format!("column {}", number + 1);
    }
    let is_of_two = fields.first().is_some_and(|first| OF_TWO.contains(first));
    if is_of_two && delimiter == Delimiter::Spaces && is_comment(line) {
        names.insert(0, "date".into());
    }
    names
}

/// The most frequent value; the larger of two equally frequent ones.
fn most_common(values: impl Iterator<Item = usize>) -> Option<usize> {
    let mut counts = std::collections::BTreeMap::new();
    values.for_each(|value| *counts.entry(value).or_insert(0usize) += 1);
    counts.into_iter().max_by_key(|(_, count)| *count).map(|(value, _)| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> Layout {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        Layout::of(file.path()).unwrap()
    }

    #[test]
    fn every_usual_layout_is_recognised() {
        for (text, delimiter, comma, header_line, names) in [
            ("t,x\n0.1,2\n0.2,3\n", Delimiter::Comma, false, 1, ["t", "x"]),
            ("t;x\n0,1;2,5\n0,2;3,5\n", Delimiter::Semicolon, true, 1, ["t", "x"]),
            ("t;x\n0.1;2\n0.2;3\n", Delimiter::Semicolon, false, 1, ["t", "x"]),
            ("t\tx\n0.1\t2\n0.2\t3\n", Delimiter::Tab, false, 1, ["t", "x"]),
            ("0.1  2\n0.2  3\n", Delimiter::Spaces, false, 0, ["1", "2"]),
            ("# made by a logger\n# t x\n0.1 2\n0.2 3\n", Delimiter::Spaces, false, 2, ["t", "x"]),
            (
                "made by, a logger, of ours\nt,x\n0.1,2\n0.2,3\n",
                Delimiter::Comma,
                false,
                2,
                ["t", "x"],
            ),
            ("t,x\n[s],[g]\n0.1,2\n0.2,3\n", Delimiter::Comma, false, 1, ["t", "x"]),
            ("t,x,\n0.1,2\n0.2,3\n", Delimiter::Comma, false, 1, ["t", "x"]),
        ] {
            let found = layout(text);
            assert_eq!((found.delimiter, found.decimal_comma), (delimiter, comma), "{text}");
            assert_eq!(found.header_line, header_line, "{text}");
            assert_eq!(found.names, names, "{text}");
        }
        assert_eq!(layout("t,x\n[s],[g]\n0.1,2\n").below_names, ["[s]", "[g]"]);
        let only_rows_end_with_a_comma = layout("t,x\n0.1,2,\n0.2,3,\n");
        assert_eq!(only_rows_end_with_a_comma.header_line, 1);
        assert_eq!(only_rows_end_with_a_comma.names, ["t", "x", ""]);
    }
}
