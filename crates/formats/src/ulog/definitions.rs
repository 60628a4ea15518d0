//! What the messages of a ULog file are made of: fields by name, with type and place.

use std::collections::HashMap;

/// A number within a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    offset: usize,
    kind: Primitive,
}

/// A type that is no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Primitive {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Primitive {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "int8_t" => Self::I8,
            "uint8_t" | "bool" | "char" => Self::U8,
            "int16_t" => Self::I16,
            "uint16_t" => Self::U16,
            "int32_t" => Self::I32,
            "uint32_t" => Self::U32,
            "int64_t" => Self::I64,
            "uint64_t" => Self::U64,
            "float" => Self::F32,
            "double" => Self::F64,
            _ => return None,
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

impl Cell {
    /// The number in `body`; NaN where it ends before.
    #[allow(clippy::cast_lossless, reason = "one way for all types, of which some lose")]
    pub fn number(self, body: &[u8]) -> f64 {
        let bytes = body.get(self.offset..).unwrap_or_default();
        macro_rules! number {
            ($kind:ty) => {
                bytes.first_chunk().map(|bytes| <$kind>::from_le_bytes(*bytes) as f64)
            };
        }
        let number = match self.kind {
            Primitive::I8 => number!(i8),
            Primitive::U8 => number!(u8),
            Primitive::I16 => number!(i16),
            Primitive::U16 => number!(u16),
            Primitive::I32 => number!(i32),
            Primitive::U32 => number!(u32),
            Primitive::I64 => number!(i64),
            Primitive::U64 => number!(u64),
            Primitive::F32 => number!(f32),
            Primitive::F64 => number!(f64),
        };
        number.unwrap_or(f64::NAN)
    }

    /// The number that `bytes`, the value of a parameter or a piece of information, spell in the type
    /// that `key`, a type and a name, gives; and the name.
    pub fn keyed<'a>(key: &'a str, bytes: &[u8]) -> Option<(&'a str, f64)> {
        let (kind, name) = key.split_once(' ')?;
        let kind = Primitive::named(kind)?;
        let number = Self { offset: 0, kind }.number(bytes);
        number.is_finite().then_some((name, number))
    }
}

/// Messages by name, as the file defines them.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    /// Fields as the file spells them: `type name;type[count] name;…`.
    fields: HashMap<String, String>,
    bytes: usize,
}

/// No set of definitions is longer, bytes: PX4 has some 60 kB of them.
const LONGEST: usize = 8 << 20;
/// Messages within messages, at most.
const DEEPEST: usize = 8;
/// No message is longer, by the size in its head.
const LONGEST_MESSAGE: usize = 65_535;

impl Definitions {
    /// Takes in `name:fields`; whether it is a definition, and room for it.
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

    /// Where each of `wanted` stands in a message `name`, an element of an array as `field[2]`, and
    /// none where it has no such field. `None` where the message is not defined.
    pub fn cells(&self, name: &str, wanted: &[&str]) -> Option<Vec<Option<Cell>>> {
        let mut cells = vec![None; wanted.len()];
        let mut offset = 0;
        for (type_name, count, field) in fields(self.fields.get(name)?) {
            let size = match Primitive::named(type_name) {
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

    /// Bytes of a message, those of messages in it down to `depth`.
    fn size(&self, name: &str, depth: usize) -> Option<usize> {
        let mut total = 0_usize;
        for (type_name, count, _) in fields(self.fields.get(name)?) {
            let size = match Primitive::named(type_name) {
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

/// Which element of `field` is `wanted`, if any.
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
    fn a_field_is_found_behind_arrays_and_messages() {
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
    fn definitions_that_hold_themselves_end() {
        let mut definitions = Definitions::default();
        definitions.add(b"loop:loop[2] again;float x;");
        definitions.add(b"wide:float[99999999999] x;");
        assert_eq!(definitions.cells("loop", &["x"]), None);
        assert_eq!(definitions.cells("wide", &["x"]), None);
    }
}
