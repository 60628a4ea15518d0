//! NMEA sentences: their grammar, and a generator of valid and damaged ones.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The sentences that both readers know.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Gga,
    Gns,
    Gsa,
    Gst,
    Rmc,
    Vtg,
}

impl Kind {
    pub const ALL: [Self; 6] = [Self::Gga, Self::Gns, Self::Gsa, Self::Gst, Self::Rmc, Self::Vtg];

    pub fn name(self) -> &'static str {
        match self {
            Self::Gga => "GGA",
            Self::Gns => "GNS",
            Self::Gsa => "GSA",
            Self::Gst => "GST",
            Self::Rmc => "RMC",
            Self::Vtg => "VTG",
        }
    }

    /// Index of the first of the four fields of the position.
    pub fn position(self) -> Option<usize> {
        match self {
            Self::Gga | Self::Gns => Some(1),
            Self::Rmc => Some(2),
            Self::Gsa | Self::Gst | Self::Vtg => None,
        }
    }

    /// Whether the first field is the time of day.
    pub fn has_time(self) -> bool {
        !matches!(self, Self::Gsa | Self::Vtg)
    }

    /// Indices of the decimal numbers.
    pub fn numbers(self) -> &'static [usize] {
        match self {
            Self::Gga => &[7, 8, 10],
            Self::Gns => &[7, 8, 9],
            Self::Gsa => &[14, 15, 16],
            Self::Gst => &[1, 2, 3, 4, 5, 6, 7],
            Self::Rmc => &[6, 7],
            Self::Vtg => &[0, 2, 4],
        }
    }
}

/// A sentence from `$` to its line end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sentence {
    pub kind: Kind,
    pub text: String,
}

impl Sentence {
    /// The sentence `text`; `None` unless it begins as one of the kinds, with any talker.
    pub fn new(text: &str) -> Option<Self> {
        let name = text.strip_prefix('$')?.get(2..)?.split(',').next()?;
        let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name)?;
        Some(Self { kind, text: text.to_owned() })
    }

    /// The sentences of a stream: each ends at a line end or at the next `$`.
    pub fn all_of(stream: &[u8]) -> Vec<Self> {
        stream
            .split(|byte| b"\r\n".contains(byte))
            .flat_map(|line| line.split(|byte| *byte == b'$').skip(1))
            .filter_map(|rest| Self::new(&format!("${}", std::str::from_utf8(rest).ok()?)))
            .collect()
    }

    /// Text between `$` and `*`.
    pub fn body(&self) -> &str {
        self.text[1..].split('*').next().unwrap_or_default()
    }

    /// Text after `*`.
    pub fn checksum(&self) -> &str {
        self.text.split_once('*').map_or("", |(_, checksum)| checksum)
    }

    pub fn talker(&self) -> &str {
        &self.text[1..3]
    }

    /// The field with `index`; the first field after the name has index 0. Empty where it is missing.
    pub fn field(&self, index: usize) -> &str {
        self.body().split(',').nth(index + 1).unwrap_or_default()
    }

    pub fn field_count(&self) -> usize {
        self.body().split(',').count() - 1
    }
}

/// A number of NMEA 0183: an optional minus, digits, at most one point.
pub fn decimal(field: &str) -> Option<f64> {
    let digits = field.strip_prefix('-').unwrap_or(field);
    let allowed = digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    field.parse().ok().filter(|_| allowed)
}

/// Number of digits before the point without leading zeros.
pub fn whole_digits(field: &str) -> usize {
    field.trim_start_matches(['-', '+', '0']).bytes().take_while(u8::is_ascii_digit).count()
}

/// Degrees of `ddmm.mm` or `dddmm.mm`, if they are at most `most`.
pub fn angle(field: &str, degree_digits: usize, most: f64) -> Option<f64> {
    let whole = field.split('.').next()?;
    decimal(field)?;
    let (degrees, minutes) = field.split_at_checked(degree_digits)?;
    let (degrees, minutes): (f64, f64) = (degrees.parse().ok()?, minutes.parse().ok()?);
    let value = degrees + minutes / 60.0;
    (whole.len() == degree_digits + 2 && minutes < 60.0 && value <= most).then_some(value)
}

/// A repeatable series of sentences, one half of them damaged.
pub struct Generator(ChaCha8Rng);

impl Generator {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.0.next_u64() % limit.max(1) as u64) as usize
    }

    fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    fn pick<'a>(&mut self, choices: &[&'a str]) -> &'a str {
        choices[self.below(choices.len())]
    }

    /// A text that is empty in one of `rarity` cases.
    fn or_empty(&mut self, rarity: usize, text: String) -> String {
        if self.one_in(rarity) { String::new() } else { text }
    }

    /// `.` and up to `most` digits, or nothing.
    fn fraction(&mut self, most: usize) -> String {
        let digits: String =
            (0..self.below(most + 1)).map(|_| char::from(b'0' + self.below(10) as u8)).collect();
        if digits.is_empty() { digits } else { format!(".{digits}") }
    }

    fn number(&mut self, limit: usize, digits: usize) -> String {
        let text = format!("{}{}", self.below(limit), self.fraction(digits));
        self.or_empty(12, text)
    }

    fn signed(&mut self, limit: usize, digits: usize) -> String {
        let sign = self.pick(&["", "", "-"]);
        let number = self.number(limit, digits);
        if number.is_empty() { number } else { format!("{sign}{number}") }
    }

    fn time(&mut self) -> String {
        let (hours, minutes, seconds) = (self.below(24), self.below(60), self.below(60));
        let digits = if self.one_in(10) { 14 } else { 9 };
        let text = format!("{hours:02}{minutes:02}{seconds:02}{}", self.fraction(digits));
        self.or_empty(30, text)
    }

    /// The four fields of a position.
    fn position(&mut self) -> [String; 4] {
        let digits = if self.one_in(10) { 20 } else { 8 };
        let latitude =
            format!("{:02}{:02}{}", self.below(90), self.below(60), self.fraction(digits));
        let longitude =
            format!("{:03}{:02}{}", self.below(180), self.below(60), self.fraction(digits));
        let (north, east) = (self.pick(&["N", "S"]), self.pick(&["E", "W"]));
        if self.one_in(30) {
            return [const { String::new() }; 4];
        }
        [latitude, north.to_owned(), longitude, east.to_owned()]
    }

    /// Fields of a sentence as a receiver would send it.
    fn fields(&mut self, kind: Kind) -> Vec<String> {
        let mut fields = Vec::new();
        if kind.has_time() {
            fields.push(self.time());
        }
        match kind {
            Kind::Gga => {
                fields.extend(self.position());
                fields.push(self.pick(&["1", "1", "2", "3", "4", "5", "0", "6", "7", "8"]).into());
                fields.push(format!("{:02}", self.below(25)));
                fields.push(self.number(20, 3));
                fields.extend([self.signed(9_000, 6), "M".into()]);
                fields.extend([self.signed(108, 5), "M".into()]);
                fields.extend([self.number(9, 1), self.number(1_023, 0)]);
            }
            Kind::Gns => {
                fields.extend(self.position());
                let most = if self.one_in(3) { 6 } else { 2 };
                let systems = 1 + self.below(most);
                let modes: String =
                    (0..systems).map(|_| self.pick(&["A", "D", "P", "R", "F", "N", "E"])).collect();
                fields.extend([modes, format!("{:02}", self.below(40))]);
                fields.extend([self.number(20, 3), self.signed(9_000, 6), self.signed(108, 5)]);
                fields.extend([self.number(9, 1), self.number(1_023, 0)]);
                if !self.one_in(3) {
                    fields.push(self.pick(&["S", "C", "U", "V", "V"]).into());
                }
            }
            Kind::Gsa => {
                fields.extend(
                    [self.pick(&["A", "A", "M"]), self.pick(&["1", "2", "3", "3"])]
                        .map(String::from),
                );
                let used = self.below(13);
                let mut satellite = |index| {
                    if index < used { format!("{:02}", 1 + self.below(96)) } else { String::new() }
                };
                fields.extend((0..12).map(&mut satellite));
                fields.extend([self.number(20, 3), self.number(20, 3), self.number(20, 3)]);
                if self.one_in(3) {
                    fields.push(self.pick(&["1", "2", "3", "4", "5", "A", ""]).into());
                }
            }
            Kind::Gst => {
                for limit in [50, 50, 50, 360, 30, 30, 60] {
                    fields.push(self.number(limit, 4));
                }
            }
            Kind::Rmc => {
                fields.push(self.pick(&["A", "A", "A", "A", "D", "V"]).into());
                fields.extend(self.position());
                fields.extend([self.number(600, 4), self.number(360, 4)]);
                let (day, month, year) = (1 + self.below(28), 1 + self.below(12), self.below(100));
                let date = format!("{day:02}{month:02}{year:02}");
                fields.push(self.or_empty(10, date));
                let variation = self.pick(&["", "10.5"]);
                let direction = if variation.is_empty() { "" } else { self.pick(&["E", "W"]) };
                fields.extend([variation, direction].map(String::from));
                if !self.one_in(4) {
                    fields
                        .push(self.pick(&["A", "D", "P", "R", "F", "N", "E", "M", "S", ""]).into());
                    if self.one_in(2) {
                        fields.push(self.pick(&["S", "C", "U", "V", "V"]).into());
                    }
                }
            }
            Kind::Vtg => {
                fields.extend([self.number(360, 4), "T".into(), self.number(360, 4), "M".into()]);
                fields.extend([self.number(600, 4), "N".into(), self.number(1_100, 3), "K".into()]);
                if self.one_in(2) {
                    fields.push(self.pick(&["A", "D", "E", "N"]).into());
                }
            }
        }
        fields
    }

    /// A text that most fields should not hold.
    fn oddity(&mut self) -> &'static str {
        self.pick(&[
            "",
            "0",
            "00",
            "-1",
            "-0.5",
            "1",
            "12",
            "A",
            "C",
            "N",
            "X",
            "AX",
            "NX",
            "UX",
            "CA",
            "XA",
            "AV",
            "AE",
            "M",
            "Mx",
            "nan",
            "inf",
            "-inf",
            "+1.5",
            "+12",
            "+50305",
            "1e3",
            "1e99",
            "1.2.3",
            "0x9",
            ".5",
            "5.",
            "-",
            ".",
            "1.5x",
            "99999999999999999999",
            "0.00000000000000000001",
            "0000000000000000001.5",
            "400",
            "70000",
            "0000000012",
            "99999",
            "60000.0",
            "100001.5",
            "361.0",
            "1167.0",
            "240000",
            "096000",
            "094860",
            "09481x",
            "0948+5",
            "094859.9999999999",
            "2303-5",
            "310405",
            "2303055",
            "9000.0",
            "9000.001",
            "0160.0",
            "+120.5",
            "01nan",
            "18000.0",
            "18000.001",
            "10360.0",
        ])
    }

    fn damage_fields(&mut self, fields: &mut Vec<String>) {
        let at = self.below(fields.len());
        match self.below(8) {
            0 => {
                fields.remove(at);
            }
            1 => fields.insert(at, self.oddity().to_owned()),
            2 => fields.truncate(at),
            3 => fields[at].clear(),
            _ => fields[at] = self.oddity().to_owned(),
        }
    }

    fn damage_body(&mut self, body: &mut String) {
        let at = self.below(body.len());
        match self.below(4) {
            0 => body.truncate(at.max(6)),
            1 => body.insert(at.max(6), char::from(b' ' + self.below(95) as u8)),
            2 => body.push(self.pick(&["\t", "\u{1}"]).chars().next().unwrap_or_default()),
            _ => {
                let wrong = char::from(b' ' + self.below(95) as u8).to_string();
                body.replace_range(
                    at.max(6).min(body.len() - 1)..(at.max(6) + 1).min(body.len()),
                    &wrong,
                );
            }
        }
    }

    fn damaged_checksum(&mut self, sum: u8) -> String {
        match self.below(6) {
            0 => format!("*{:02X}", sum ^ (1 << self.below(8))),
            1 => format!("*{sum:02x}"),
            2 if sum < 16 => format!("*+{sum:X}"),
            3 => format!("*{:X}", sum >> 4),
            4 => String::new(),
            _ => format!("*{sum:02X}trailing"),
        }
    }

    /// The next sentence.
    pub fn sentence(&mut self) -> Sentence {
        let kind = Kind::ALL[self.below(Kind::ALL.len())];
        let mut fields = self.fields(kind);
        let damage = if self.one_in(2) { self.below(8) } else { usize::MAX };
        if damage < 5 {
            self.damage_fields(&mut fields);
        }
        if damage == 0 && !fields.is_empty() {
            self.damage_fields(&mut fields);
        }
        let talker = if damage == 5 {
            self.pick(&["PG", "PQ", "QZ", "GI", "XX", "IN"])
        } else {
            self.pick(&["GP", "GP", "GN", "GL", "GA", "GB", "BD"])
        };
        let mut body = format!("{talker}{},{}", kind.name(), fields.join(","));
        if damage == 6 {
            self.damage_body(&mut body);
        }
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        let checksum = if damage == 7 { self.damaged_checksum(sum) } else { format!("*{sum:02X}") };
        Sentence { kind, text: format!("${body}{checksum}") }
    }
}
