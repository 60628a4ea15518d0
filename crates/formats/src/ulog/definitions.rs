//! Definitions of the messages of a ULog file: fields with name, type and offset.

use std::collections::HashMap;

/// Offset and type of a number within a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    offset: usize,
    kind: Primitive,
}

/// A primitive type.
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
    /// The number in `body`; NaN if `body` is too short.
    #[allow(clippy::cast_lossless, reason = "one conversion for all types, some of them lossy")]
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

    /// The name in `key`, which is a type and a name, and the number in `bytes`. For parameters and information.
    pub fn keyed<'a>(key: &'a str, bytes: &[u8]) -> Option<(&'a str, f64)> {
        let (kind, name) = key.split_once(' ')?;
        let kind = Primitive::named(kind)?;
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

    /// Length of a message, bytes, with nested messages down to `depth`.
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
