//! Binary DataFlash logs.

use std::collections::HashMap;
use std::io;

use super::item::Item;
use super::schema::{FMT, FMT_LENGTH, HEAD, Schema, text};
use crate::damages::Damages;
use crate::window::Window;

/// The sync bytes of every message.
const MARKS: [u8; 2] = [0xA3, 0x95];
/// Largest length of a message, bytes: the length is one byte.
const LONGEST: usize = 255;
/// Bytes searched at a time for a message after damage.
const LOOKAHEAD: usize = 1 << 14;

/// The message types of a log, by number.
struct Schemas {
    by_number: Vec<Option<Schema>>,
    multipliers: HashMap<u8, f64>,
}

/// Passes each item of the log in `window` to `take` and returns the damage.
pub(super) fn each(mut window: Window<'_>, take: &mut dyn FnMut(Item<'_>)) -> io::Result<Damages> {
    let mut schemas =
        Schemas { by_number: (0..=u8::MAX).map(|_| None).collect(), multipliers: HashMap::new() };
    schemas.by_number[usize::from(FMT)] =
        Some(Schema::new("FMT", FMT_LENGTH, "BBnNZ", "Type,Length,Name,Format,Columns"));
    let mut damages = Damages::default();
    loop {
        let place = window.offset();
        let bytes = window.peek(LONGEST)?;
        if bytes.is_empty() {
            return Ok(damages);
        }
        let Some(schema) = schemas.of(bytes) else {
            let reason = match bytes {
                [0xA3, 0x95, number, ..] => {
                    format!("found a message of unknown type {number}; ignored")
                }
                _ if bytes.len() < HEAD => {
                    "the file ends within a message, which is ignored".to_owned()
                }
                _ => "found no message; ignored".to_owned(),
            };
            // Storage that was reserved but not written follows.
            if bytes.iter().all(is_empty) && ends_empty(&mut window)? {
                return Ok(damages);
            }
            damages.add(place, reason);
            if window.offset() == place {
                window.consume(1);
            }
            resynchronise(&mut window, &schemas)?;
            continue;
        };
        let length = schema.length;
        let Some(body) = bytes.get(HEAD..length) else {
            damages.add(place, "the file ends within a message, which is ignored");
            return Ok(damages);
        };
        if let Some((message, _)) = schema.message {
            let instance = schema.instance_of_bytes(body);
            take(Item::Row { message, instance, place, row: schema.row_of_bytes(body) });
        } else {
            match schema.name.as_str() {
                "PARM" => {
                    let found = schema.text(body, "Name").zip(schema.number_named(body, "Value"));
                    if let Some((name, value)) = found {
                        take(Item::Parameter { name, value });
                    }
                }
                "MSG" => {
                    if let Some(text) = schema.text(body, "Message") {
                        take(Item::Text(text));
                    }
                }
                "FMT" | "MULT" | "FMTU" => {
                    let body = body.to_vec();
                    schemas.learn(&body, bytes[2], place, &mut damages);
                }
                _ => {}
            }
        }
        window.consume(length);
    }
}

/// Whether a byte has the value of unwritten storage.
fn is_empty(byte: &u8) -> bool {
    matches!(byte, 0 | 0xFF)
}

/// Whether only unwritten storage follows.
fn ends_empty(window: &mut Window<'_>) -> io::Result<bool> {
    loop {
        let bytes = window.peek(LOOKAHEAD)?;
        if !bytes.iter().all(is_empty) {
            return Ok(false);
        }
        let length = bytes.len();
        if length == 0 {
            return Ok(true);
        }
        window.consume(length);
    }
}

/// Moves to the next message that another message follows directly, or that ends at the end of the file.
fn resynchronise(window: &mut Window<'_>, schemas: &Schemas) -> io::Result<()> {
    loop {
        let bytes = window.peek(LOOKAHEAD)?;
        let length = bytes.len();
        let searched = if length < LOOKAHEAD { length } else { length - 2 * LONGEST };
        let found = (0..searched).find(|&place| {
            let rest = &bytes[place..];
            schemas.of(rest).is_some_and(|schema| match rest.get(schema.length..) {
                Some([]) => true,
                Some(next) => schemas.of(next).is_some(),
                None => false,
            })
        });
        window.consume(found.unwrap_or(searched));
        if found.is_some() || searched == 0 || length < LOOKAHEAD {
            return Ok(());
        }
    }
}

impl Schemas {
    /// The type of the message at the start of `bytes`.
    fn of(&self, bytes: &[u8]) -> Option<&Schema> {
        let [first, second, number] = *bytes.first_chunk()?;
        if [first, second] != MARKS {
            return None;
        }
        self.by_number[usize::from(number)].as_ref()
    }

    /// Reads a message of type `number` that describes messages, units or multipliers.
    fn learn(&mut self, body: &[u8], number: u8, place: u64, damages: &mut Damages) {
        if number == FMT {
            return match described(body) {
                Some((number, schema)) if number != FMT => {
                    self.by_number[usize::from(number)] = Some(schema);
                }
                Some(_) => {}
                None => damages.add(place, "found an invalid FMT message; ignored"),
            };
        }
        let Some(schema) = &self.by_number[usize::from(number)] else { return };
        if schema.name == "MULT" {
            let found = schema.number_named(body, "Id").zip(schema.number_named(body, "Mult"));
            self.multipliers.extend(found.map(|(id, multiplier)| (id as u8, multiplier)));
            return;
        }
        let units = schema.text(body, "UnitIds").unwrap_or_default().to_owned();
        let multipliers = schema.text(body, "MultIds").unwrap_or_default().to_owned();
        let about = schema.number_named(body, "FmtType").unwrap_or(f64::from(FMT));
        if let Some(schema) = &mut self.by_number[usize::from(about as u8)] {
            schema.set_multipliers(&units, &multipliers, &self.multipliers);
        }
    }
}

/// The number and schema in the body of an FMT message.
fn described(body: &[u8]) -> Option<(u8, Schema)> {
    let (&[number, length], rest) = body.split_first_chunk()?;
    let (name, rest) = rest.split_at_checked(4)?;
    let (formats, labels) = rest.split_at_checked(16)?;
    let length = usize::from(length);
    // A length below that of the header is invalid.
    (length >= HEAD)
        .then(|| Some((number, Schema::new(text(name)?, length, text(formats)?, text(labels)?))))
        .flatten()
}
