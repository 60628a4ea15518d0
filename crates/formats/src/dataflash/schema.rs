//! What the messages of a DataFlash log are made of, as the log itself describes them.
//!
//! # Source
//! ArduPilot, `libraries/AP_Logger`: format characters, and the messages FMT, FMTU and MULT.

use std::collections::HashMap;

use super::message::Message;

/// A kind of message of a log.
#[derive(Debug)]
pub(super) struct Schema {
    /// Its name in the log.
    pub name: String,
    /// Bytes of a message with its head.
    pub length: usize,
    /// What it is, and which instance by its name, where it is read.
    pub message: Option<(Message, usize)>,
    /// Names of the fields, with the format of each.
    labels: Vec<(String, u8)>,
    /// What the log says the fields are multiplied by.
    multipliers: Vec<Option<f64>>,
    /// Where each column of the message stands.
    columns: Vec<Option<Column>>,
    /// Which field counts instances.
    instance: Option<usize>,
    /// Where each field of a message in bytes begins, past its head.
    offsets: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Column {
    field: usize,
    factor: f64,
}

/// Two marks and the number of the message.
pub(super) const HEAD: usize = 3;
/// The number of the message that describes messages.
pub(super) const FMT: u8 = 128;
/// Its length.
pub(super) const FMT_LENGTH: usize = 89;

/// Bytes of a field, and what its integers are multiplied by; `None` where the format is not known.
fn layout(format: u8) -> Option<(usize, f64)> {
    Some(match format {
        b'b' | b'B' | b'M' => (1, 1.0),
        b'h' | b'H' | b'g' => (2, 1.0),
        b'c' | b'C' => (2, 0.01),
        b'i' | b'I' | b'f' => (4, 1.0),
        b'n' => (4, 1.0),
        b'e' | b'E' => (4, 0.01),
        b'L' => (4, 1e-7),
        b'd' | b'q' | b'Q' => (8, 1.0),
        b'N' => (16, 1.0),
        b'a' | b'Z' => (64, 1.0),
        _ => return None,
    })
}

impl Schema {
    /// Of a message `name` with the field formats and the names of the fields, separated by commas.
    pub fn new(name: &str, length: usize, formats: &str, labels: &str) -> Self {
        let labels: Vec<(String, u8)> = labels
            .split(',')
            .zip(formats.bytes())
            .map(|(label, format)| (label.trim().to_owned(), format))
            .collect();
        let mut offset = 0;
        let offsets = labels
            .iter()
            .map(|&(_, format)| {
                let at = offset;
                // Past an unknown field nothing has a place.
                let size = layout(format).map_or(usize::MAX, |(size, _)| size);
                offset = usize::saturating_add(offset, size);
                at
            })
            .collect();
        let instance = labels.iter().position(|(label, _)| label == "I" || label == "C");
        let mut schema = Self {
            name: name.to_owned(),
            length,
            message: Message::named(name),
            multipliers: vec![None; labels.len()],
            labels,
            columns: Vec::new(),
            instance,
            offsets,
        };
        schema.resolve();
        schema
    }

    /// Takes in the units and multipliers of the fields, a character each.
    pub fn set_multipliers(&mut self, units: &str, ids: &str, known: &HashMap<u8, f64>) {
        let counts = units.bytes().take(self.labels.len()).position(|unit| unit == b'#');
        self.instance = counts.or(self.instance);
        for (multiplier, id) in self.multipliers.iter_mut().zip(ids.bytes()) {
            // Zero stands for "none".
            let known = known.get(&id).copied();
            *multiplier = known.filter(|value| value.is_finite() && *value != 0.0);
        }
        self.resolve();
    }

    fn resolve(&mut self) {
        let Some((message, _)) = self.message else { return };
        let column = |&(wanted, factor): &(&str, f64)| {
            let field = self.labels.iter().position(|(label, _)| label == wanted)?;
            let has_factor = layout(self.labels[field].1).is_some_and(|(_, scale)| scale != 1.0);
            // A format that scales by itself is multiplied already.
            let own = self.multipliers[field].map(|own| if has_factor { 1.0 } else { own });
            Some(Column { field, factor: own.unwrap_or(factor) })
        };
        self.columns = message.columns().iter().map(column).collect();
    }

    /// The message's columns, read by `number` from field number and format; NaN where it has none.
    fn row(&self, number: impl Fn(usize, u8) -> f64) -> [f64; Message::WIDTH] {
        let mut row = [f64::NAN; Message::WIDTH];
        for (cell, column) in row.iter_mut().zip(&self.columns) {
            if let Some(Column { field, factor }) = *column {
                *cell = number(field, self.labels[field].1) * factor;
            }
        }
        row
    }

    /// The columns of a message in bytes, its head left off.
    pub fn row_of_bytes(&self, body: &[u8]) -> [f64; Message::WIDTH] {
        self.row(|field, format| self.number(body, field, format))
    }

    /// The columns of a message in text, its name left off. Text is scaled already.
    pub fn row_of_text(&self, fields: &[&str]) -> [f64; Message::WIDTH] {
        self.row(|field, _| number_in(fields, field))
    }

    /// The instance by the name, or by the field that counts them.
    fn instance(&self, number: impl Fn(usize, u8) -> f64) -> usize {
        let by_name = self.message.map_or(0, |(_, instance)| instance);
        let by_field = self.instance.map(|field| number(field, self.labels[field].1));
        by_field.filter(|number| (0.0..=255.0).contains(number)).map_or(by_name, |n| n as usize)
    }

    /// The instance of a message in bytes.
    pub fn instance_of_bytes(&self, body: &[u8]) -> usize {
        self.instance(|field, format| self.number(body, field, format))
    }

    /// The instance of a message in text.
    pub fn instance_of_text(&self, fields: &[&str]) -> usize {
        self.instance(|field, _| number_in(fields, field))
    }

    #[allow(clippy::cast_lossless, reason = "one way for all types, of which some lose")]
    fn number(&self, body: &[u8], field: usize, format: u8) -> f64 {
        let bytes = body.get(self.offsets[field]..).unwrap_or_default();
        let scale = layout(format).map_or(1.0, |(_, scale)| scale);
        macro_rules! number {
            ($kind:ty) => {
                bytes.first_chunk().map(|bytes| <$kind>::from_le_bytes(*bytes) as f64)
            };
        }
        let number = match format {
            b'b' => number!(i8),
            b'B' | b'M' => number!(u8),
            b'h' | b'c' => number!(i16),
            b'H' | b'C' => number!(u16),
            b'i' | b'e' | b'L' => number!(i32),
            b'I' | b'E' => number!(u32),
            b'q' => number!(i64),
            b'Q' => number!(u64),
            b'f' => number!(f32),
            b'd' => number!(f64),
            _ => None,
        };
        number.map_or(f64::NAN, |number| number * scale)
    }

    /// The text of the field `label` of a message in bytes, up to its first zero.
    pub fn text<'a>(&self, body: &'a [u8], label: &str) -> Option<&'a str> {
        let field = self.labels.iter().position(|(name, _)| name == label)?;
        let (size, _) = layout(self.labels[field].1)?;
        let bytes = body.get(self.offsets[field]..)?.get(..size)?;
        text(bytes)
    }

    /// The number of the field `label` of a message in bytes.
    pub fn number_named(&self, body: &[u8], label: &str) -> Option<f64> {
        let field = self.labels.iter().position(|(name, _)| name == label)?;
        let number = self.number(body, field, self.labels[field].1);
        number.is_finite().then_some(number)
    }

    /// The field `label` of a message in text.
    pub fn field<'a>(&self, fields: &[&'a str], label: &str) -> Option<&'a str> {
        let field = self.labels.iter().position(|(name, _)| name == label)?;
        fields.get(field).copied()
    }
}

fn number_in(fields: &[&str], field: usize) -> f64 {
    fields.get(field).and_then(|text| text.parse().ok()).unwrap_or(f64::NAN)
}

/// Text up to its first zero.
pub(super) fn text(bytes: &[u8]) -> Option<&str> {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    std::str::from_utf8(&bytes[..end]).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn fields_have_the_size_and_scale_of_their_format() {
        let schema = Schema::new("GPS", 0, "QBcLe", "TimeUS,Status,HDop,Lat,Alt");
        let mut body = 2_500_000_u64.to_le_bytes().to_vec();
        body.push(3);
        body.extend(150_i16.to_le_bytes());
        body.extend((-353_626_277_i32).to_le_bytes());
        body.extend(58_882_i32.to_le_bytes());
        let row = schema.row_of_bytes(&body);
        assert_eq!((row[0], row[3]), (2.5, 3.0));
        assert_abs_diff_eq!(row[5], -35.362_627_7, epsilon = 1e-9);
        assert_abs_diff_eq!(row[8], 588.82, epsilon = 1e-9);
        assert!(row[1].is_nan());
        assert!(schema.row_of_bytes(&body[..12])[5].is_nan());
    }

    #[test]
    fn units_of_fields_that_are_not_there_count_nothing() {
        let mut schema = Schema::new("IMU", 0, "Qf", "TimeUS,GyrX");
        schema.set_multipliers("s------#", "F-------", &HashMap::new());
        assert_eq!(schema.instance_of_text(&["1000000", "0.5"]), 0);
        assert_eq!(schema.instance_of_bytes(&[0; 12]), 0);
    }

    #[test]
    fn the_log_says_what_integers_are_multiplied_by() {
        let mut schema = Schema::new("MAG", 0, "Qhc", "TimeUS,MagX,MagY");
        let mut body = vec![0; 8];
        body.extend(219_i16.to_le_bytes());
        body.extend(219_i16.to_le_bytes());
        assert_abs_diff_eq!(schema.row_of_bytes(&body)[2], 0.219, epsilon = 1e-12);
        let known = HashMap::from([(b'F', 1e-6), (b'B', 1e-2)]);
        schema.set_multipliers("sGG", "FBB", &known);
        assert_abs_diff_eq!(schema.row_of_bytes(&body)[2], 2.19, epsilon = 1e-12);
        // Centi by its format and by its multiplier is centi once.
        assert_abs_diff_eq!(schema.row_of_bytes(&body)[3], 2.19, epsilon = 1e-12);
    }
}
