//! DataFlash logs as text: one message per line, its name first, values separated by commas.

use std::collections::HashMap;
use std::io;

use super::item::Item;
use super::schema::Schema;
use crate::damages::Damages;
use crate::recognise::without_mark;
use crate::window::Window;

/// Longest line that is read, bytes.
const LONGEST: usize = 1 << 14;
/// Largest number of message types: their number is one byte.
const KINDS: usize = 256;

const READ_COMMAS: &str = "found decimal commas, as in 0,5, from here on; read as decimal points";
const LOST_COMMAS: &str = "found more fields than the message has from here on; ignored: decimal commas? Export the log \
                           with decimal points";

/// Passes each item of the log in `window` to `take` and returns the damage.
pub(super) fn each(mut window: Window<'_>, take: &mut dyn FnMut(Item<'_>)) -> io::Result<Damages> {
    let mut schemas: HashMap<String, Schema> = HashMap::new();
    let mut numbers: HashMap<String, String> = HashMap::new();
    let mut multipliers: HashMap<u8, f64> = HashMap::new();
    let mut damages = Damages::default();
    // Line of the first decimal comma, and whether a blank after each separator distinguishes separators from decimal
    // commas.
    let mut commas = None;
    let mut line = 0;
    loop {
        let bytes = window.peek(LONGEST)?;
        if bytes.is_empty() {
            if let Some((line, is_read)) = commas {
                damages.add(line, if is_read { READ_COMMAS } else { LOST_COMMAS });
            }
            return Ok(damages);
        }
        line += 1;
        let end = bytes.iter().take(LONGEST).position(|&byte| byte == b'\n');
        let (length, is_whole) = match end {
            Some(end) => (end + 1, true),
            None if bytes.len() >= LONGEST => {
                damages.add(line, "found a line of more than 16384 bytes; ignored");
                skip_line(&mut window)?;
                continue;
            }
            None => (bytes.len(), false),
        };
        let Ok(text) = std::str::from_utf8(without_mark(&bytes[..length])) else {
            damages.add(line, "found a line that is not text; ignored");
            window.consume(length);
            continue;
        };
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let (name, fields) = (fields[0], &fields[1..]);
        if !is_whole && !name.is_empty() {
            damages.add(line, "the file ends within this line, which is ignored");
            return Ok(damages);
        }
        match (name, fields) {
            ("", _) => {}
            ("FMT", [number, _, name, formats, labels @ ..]) => {
                if schemas.len() < KINDS {
                    let schema = Schema::new(name, 0, formats, &labels.join(","));
                    numbers.insert((*number).to_owned(), (*name).to_owned());
                    schemas.insert((*name).to_owned(), schema);
                }
            }
            ("MULT", [_, id, multiplier, ..]) => {
                let id = id.parse().ok().or_else(|| id.bytes().next());
                multipliers.extend(id.zip(multiplier.parse::<f64>().ok()));
            }
            ("FMTU", [_, number, units, ids, ..]) => {
                let about = numbers.get(*number).and_then(|name| schemas.get_mut(name));
                if let Some(schema) = about {
                    schema.set_multipliers(units, ids, &multipliers);
                }
            }
            (name, fields) => match schemas.get(name) {
                None => damages.add(line, "found a message that no FMT describes; ignored"),
                // Free text may contain commas.
                Some(schema) if schema.ends_in_text() => {
                    let fields: Vec<&str> =
                        text.splitn(1 + schema.width(), ',').skip(1).map(str::trim).collect();
                    give(schema, &fields, line, take);
                }
                // Decimal commas make more fields, but no blank follows them.
                Some(schema) if fields.len() > schema.width() => {
                    let parts: Vec<String> = text
                        .split(", ")
                        .skip(1)
                        .map(|part| part.trim().replace(',', "."))
                        .collect();
                    let is_whole = parts.len() == schema.width();
                    commas.get_or_insert((line, is_whole));
                    if is_whole {
                        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
                        give(schema, &parts, line, take);
                    }
                }
                Some(schema) => give(schema, fields, line, take),
            },
        }
        window.consume(length);
    }
}

/// Moves behind the next line end, or to the end of the file.
fn skip_line(window: &mut Window<'_>) -> io::Result<()> {
    loop {
        let bytes = window.peek(LONGEST)?;
        let end = bytes.iter().position(|&byte| byte == b'\n');
        let length = end.map_or(bytes.len(), |end| end + 1);
        window.consume(length);
        if end.is_some() || length == 0 {
            return Ok(());
        }
    }
}

/// Passes a message to `take` if the reader uses messages of its type.
fn give(schema: &Schema, fields: &[&str], place: u64, take: &mut dyn FnMut(Item<'_>)) {
    if let Some((message, _)) = schema.message {
        let instance = schema.instance_of_text(fields);
        take(Item::Row { message, instance, place, row: schema.row_of_text(fields) });
    } else if schema.name == "PARM" {
        let value = schema.field(fields, "Value").and_then(|value| value.parse().ok());
        if let Some((name, value)) = schema.field(fields, "Name").zip(value) {
            take(Item::Parameter { name, value });
        }
    } else if schema.name == "MSG"
        && let Some(text) = schema.field(fields, "Message")
    {
        take(Item::Text(text));
    }
}
