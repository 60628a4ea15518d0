//! Fields of the messages of a DataFlash log, as described in the log.
//!
//! # Source
//! ArduPilot, `libraries/AP_Logger`: format characters, and the messages FMT, FMTU and MULT.

use std::collections::HashMap;

use super::message::Message;
use crate::primitive::Primitive::{self, F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};

/// A message type of a log.
#[derive(Debug)]
pub(super) struct Schema {
    /// Name in the log.
    pub name: String,
    /// Length of a message with its header, bytes.
    pub length: usize,
    /// The message and the instance in its name, if messages of this type are read.
    pub message: Option<(Message, usize)>,
    /// Name and format character of each field.
    labels: Vec<(String, u8)>,
    /// Multipliers of the fields, if the log has them.
    multipliers: Vec<Option<f64>>,
    /// Field of each column of the message.
    columns: Vec<Option<Column>>,
    /// Field with the instance.
    instance: Option<usize>,
    /// Offset of each field of a binary message, after its header.
    offsets: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Column {
    field: usize,
    factor: f64,
}

/// Length of a header, bytes: two sync bytes and the type of the message.
pub(super) const HEAD: usize = 3;
/// The type of the message that describes messages.
pub(super) const FMT: u8 = 128;
/// Length of an FMT message, bytes.
pub(super) const FMT_LENGTH: usize = 89;

/// Type of a field.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Number(Primitive),
    /// Bytes that are not read as a number, and their count.
    Bytes(usize),
}

impl Kind {
    const fn size(self) -> usize {
        match self {
            Self::Number(primitive) => primitive.size(),
            Self::Bytes(count) => count,
        }
    }
}

/// Type of a field, and factor of its integers; `None` for an unknown format.
fn layout(format: u8) -> Option<(Kind, f64)> {
    let (primitive, factor) = match format {
        b'b' => (I8, 1.0),
        b'B' | b'M' => (U8, 1.0),
        b'h' => (I16, 1.0),
        b'H' => (U16, 1.0),
        b'c' => (I16, 0.01),
        b'C' => (U16, 0.01),
        b'i' => (I32, 1.0),
        b'I' => (U32, 1.0),
        b'e' => (I32, 0.01),
        b'E' => (U32, 0.01),
        b'L' => (I32, 1e-7),
        b'q' => (I64, 1.0),
        b'Q' => (U64, 1.0),
        b'f' => (F32, 1.0),
        b'd' => (F64, 1.0),
        b'g' => return Some((Kind::Bytes(2), 1.0)),
        b'n' => return Some((Kind::Bytes(4), 1.0)),
        b'N' => return Some((Kind::Bytes(16), 1.0)),
        b'a' | b'Z' => return Some((Kind::Bytes(64), 1.0)),
        _ => return None,
    };
    Some((Kind::Number(primitive), factor))
}

impl Schema {
    /// The schema of the message `name`; `formats` has one character per field, `labels` are separated by commas.
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
                // After a field of unknown length, no offset is known.
                let size = layout(format).map_or(usize::MAX, |(kind, _)| kind.size());
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

    /// Number of fields of a message.
    pub fn width(&self) -> usize {
        self.labels.len()
    }

    /// Whether the last field is a text.
    pub fn ends_in_text(&self) -> bool {
        self.labels.last().is_some_and(|(_, format)| matches!(format, b'n' | b'N' | b'Z'))
    }

    /// Sets the units and multipliers of the fields, one character each.
    pub fn set_multipliers(&mut self, units: &str, ids: &str, known: &HashMap<u8, f64>) {
        let counts = units.bytes().take(self.labels.len()).position(|unit| unit == b'#');
        self.instance = counts.or(self.instance);
        for (multiplier, id) in self.multipliers.iter_mut().zip(ids.bytes()) {
            // Zero means that the field has no multiplier.
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
            // A format with its own factor is already scaled.
            let own = self.multipliers[field].map(|own| if has_factor { 1.0 } else { own });
            Some(Column { field, factor: own.unwrap_or(factor) })
        };
        self.columns = message.columns().map(column).collect();
    }

    /// The columns of the message; `number` reads a field from its index and format. NaN for missing fields.
    fn row(&self, number: impl Fn(usize, u8) -> f64) -> [f64; Message::WIDTH] {
        let mut row = [f64::NAN; Message::WIDTH];
        for (cell, column) in row.iter_mut().zip(&self.columns) {
            if let Some(Column { field, factor }) = *column {
                *cell = number(field, self.labels[field].1) * factor;
            }
        }
        row
    }

    /// The columns of a binary message without its header.
    pub fn row_of_bytes(&self, body: &[u8]) -> [f64; Message::WIDTH] {
        self.row(|field, format| self.number(body, field, format))
    }

    /// The columns of a text message without its name. Text values are already scaled.
    pub fn row_of_text(&self, fields: &[&str]) -> [f64; Message::WIDTH] {
        self.row(|field, _| number_in(fields, field))
    }

    /// The instance from the name, or from the instance field.
    fn instance(&self, number: impl Fn(usize, u8) -> f64) -> usize {
        let by_name = self.message.map_or(0, |(_, instance)| instance);
        let by_field = self.instance.map(|field| number(field, self.labels[field].1));
        by_field.filter(|number| (0.0..=255.0).contains(number)).map_or(by_name, |n| n as usize)
    }

    /// The instance of a binary message.
    pub fn instance_of_bytes(&self, body: &[u8]) -> usize {
        self.instance(|field, format| self.number(body, field, format))
    }

    /// The instance of a text message.
    pub fn instance_of_text(&self, fields: &[&str]) -> usize {
        self.instance(|field, _| number_in(fields, field))
    }

    fn number(&self, body: &[u8], field: usize, format: u8) -> f64 {
        match layout(format) {
            Some((Kind::Number(kind), factor)) => kind.number(body, self.offsets[field]) * factor,
            _ => f64::NAN,
        }
    }

    /// The text of the field `label` of a binary message, up to its first zero.
    pub fn text<'a>(&self, body: &'a [u8], label: &str) -> Option<&'a str> {
        let field = self.labels.iter().position(|(name, _)| name == label)?;
        let (kind, _) = layout(self.labels[field].1)?;
        let bytes = body.get(self.offsets[field]..)?.get(..kind.size())?;
        text(bytes)
    }

    /// The number of the field `label` of a binary message.
    pub fn number_named(&self, body: &[u8], label: &str) -> Option<f64> {
        let field = self.labels.iter().position(|(name, _)| name == label)?;
        let number = self.number(body, field, self.labels[field].1);
        number.is_finite().then_some(number)
    }

    /// The field `label` of a text message.
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
    fn units_of_missing_fields_are_ignored() {
        let mut schema = Schema::new("IMU", 0, "Qf", "TimeUS,GyrX");
        schema.set_multipliers("s------#", "F-------", &HashMap::new());
        assert_eq!(schema.instance_of_text(&["1000000", "0.5"]), 0);
        assert_eq!(schema.instance_of_bytes(&[0; 12]), 0);
    }

    #[test]
    fn multipliers_of_the_log_scale_integers() {
        let mut schema = Schema::new("MAG", 0, "Qhc", "TimeUS,MagX,MagY");
        let mut body = vec![0; 8];
        body.extend(219_i16.to_le_bytes());
        body.extend(219_i16.to_le_bytes());
        assert_abs_diff_eq!(schema.row_of_bytes(&body)[2], 0.219, epsilon = 1e-12);
        let known = HashMap::from([(b'F', 1e-6), (b'B', 1e-2)]);
        schema.set_multipliers("sGG", "FBB", &known);
        assert_abs_diff_eq!(schema.row_of_bytes(&body)[2], 2.19, epsilon = 1e-12);
        // A factor of 0.01 in both format and multiplier applies once.
        assert_abs_diff_eq!(schema.row_of_bytes(&body)[3], 2.19, epsilon = 1e-12);
    }
}
