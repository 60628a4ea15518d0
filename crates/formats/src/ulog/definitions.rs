//! Definitions of the messages of a ULog file: fields with name, type and offset.

use std::collections::HashMap;

use crate::primitive::Primitive;

/// Offset and type of a number within a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    offset: usize,
    kind: Primitive,
}

/// The type of this name.
fn primitive(name: &str) -> Option<Primitive> {
    Some(match name {
        "int8_t" => Primitive::I8,
        "uint8_t" | "bool" | "char" => Primitive::U8,
        "int16_t" => Primitive::I16,
        "uint16_t" => Primitive::U16,
        "int32_t" => Primitive::I32,
        "uint32_t" => Primitive::U32,
        "int64_t" => Primitive::I64,
        "uint64_t" => Primitive::U64,
        "float" => Primitive::F32,
        "double" => Primitive::F64,
        _ => return None,
    })
}

impl Cell {
    /// The number in `body`; NaN if `body` is too short.
    pub fn number(self, body: &[u8]) -> f64 {
        self.kind.number(body, self.offset)
    }

    /// The name in `key`, which is a type and a name, and the number in `bytes`. For parameters and information.
    pub fn keyed<'a>(key: &'a str, bytes: &[u8]) -> Option<(&'a str, f64)> {
        let (kind, name) = key.split_once(' ')?;
        let kind = primitive(kind)?;
        let number = Self { offset: 0, kind }.number(bytes);
        number.is_finite().then_some((name, number))
    }
}

/// The message definitions of the file, by name.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    /// Fields in the file's notation: `type name;type[count] name;…`.
    fields: HashMap<String, String>,
    bytes: usize,
}

/// Largest total length of definitions, bytes; PX4 has about 60 kB.
const LONGEST: usize = 8 << 20;
/// Largest depth of nested messages.
const DEEPEST: usize = 8;
/// Largest length of a message, bytes: its size field has 16 bits.
const LONGEST_MESSAGE: usize = 65_535;

impl Definitions {
    /// Adds the definition `name:fields`; false if it is invalid or exceeds [`LONGEST`].
    pub fn add(&mut self, body: &[u8]) -> bool {
        let Some((name, fields)) =
            std::str::from_utf8(body).ok().and_then(|text| text.split_once(':'))
        else {
            return false;
        };
        self.bytes += body.len();
        if self.bytes > LONGEST {
            return false;
        }
        self.fields.insert(name.to_owned(), fields.to_owned());
        true
    }

    /// Offset and type of each `wanted` field of the message `name`. An element of an array is written `field[2]`. The
    /// inner value is `None` for a missing field, the outer value for an undefined message.
    pub fn cells(&self, name: &str, wanted: &[&str]) -> Option<Vec<Option<Cell>>> {
        let mut cells = vec![None; wanted.len()];
        let mut offset = 0;
        for (type_name, count, field) in fields(self.fields.get(name)?) {
            let size = match primitive(type_name) {
                Some(kind) => {
                    for (cell, wanted) in cells.iter_mut().zip(wanted) {
                        let element = element(wanted, field).filter(|&at| at < count.max(1));
                        if let Some(at) = element {
                            *cell = Some(Cell { offset: offset + at * kind.size(), kind });
                        }
                    }
                    kind.size()
                }
                None => self.size(type_name, DEEPEST)?,
            };
            offset += size.checked_mul(count)?;
            if offset > LONGEST_MESSAGE {
                return None;
            }
        }
        Some(cells)
    }

    /// Length of a message, bytes, with nested messages down to `depth`.
    fn size(&self, name: &str, depth: usize) -> Option<usize> {
        let mut total = 0_usize;
        for (type_name, count, _) in fields(self.fields.get(name)?) {
            let size = match primitive(type_name) {
                Some(kind) => kind.size(),
                None => self.size(type_name, depth.checked_sub(1)?)?,
            };
            total = total.checked_add(size.checked_mul(count)?)?;
            if total > LONGEST_MESSAGE {
                return None;
            }
        }
        Some(total)
    }
}

/// Type, count and name of each field.
fn fields(text: &str) -> impl Iterator<Item = (&str, usize, &str)> {
    text.split(';').filter_map(|field| {
        let (kind, name) = field.trim().split_once(' ')?;
        let (kind, count) = match kind.split_once('[') {
            Some((kind, count)) => (kind, count.strip_suffix(']')?.parse().ok()?),
            None => (kind, 1),
        };
        Some((kind, count, name))
    })
}

/// The index of the element of `field` that `wanted` denotes, if any.
fn element(wanted: &str, field: &str) -> Option<usize> {
    let rest = wanted.strip_prefix(field)?;
    if rest.is_empty() {
        return Some(0);
    }
    rest.strip_prefix('[')?.strip_suffix(']')?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_found_after_arrays_and_nested_messages() {
        let mut definitions = Definitions::default();
        assert!(definitions.add(b"inner:uint8_t a;uint16_t[2] b;"));
        assert!(definitions.add(b"outer:uint64_t timestamp;inner[2] i;float[3] q;int8_t s;"));
        let cells = definitions.cells("outer", &["q[1]", "s", "none", "timestamp"]).unwrap();
        let mut body = vec![0; 8 + 10];
        for value in [1.5_f32, -2.5, 3.5] {
            body.extend(value.to_le_bytes());
        }
        body.push(-7_i8 as u8);
        let numbers: Vec<Option<f64>> =
            cells.iter().map(|cell| cell.map(|cell| cell.number(&body))).collect();
        assert_eq!(numbers, [Some(-2.5), Some(-7.0), None, Some(0.0)]);
        assert!(cells[0].unwrap().number(&body[..20]).is_nan());
    }

    #[test]
    fn recursive_definitions_are_rejected() {
        let mut definitions = Definitions::default();
        definitions.add(b"loop:loop[2] again;float x;");
        definitions.add(b"wide:float[99999999999] x;");
        assert_eq!(definitions.cells("loop", &["x"]), None);
        assert_eq!(definitions.cells("wide", &["x"]), None);
    }
}
