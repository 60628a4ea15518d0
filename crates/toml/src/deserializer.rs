//! Conversion of a parsed TOML value to a type, with the path of an error and the unknown keys.

use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error as _, Expected, MapAccess, SeqAccess,
    Unexpected, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use toml::Value;
use toml::map::Iter;

use crate::place::Place;
use crate::{ValueError, words};

impl serde::de::Error for ValueError {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        Self { message: message.to_string(), place: Vec::new() }
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let (found, expected) = (words::found(found), words::expected(expected));
        Self::custom(format_args!("found {found}, expected {expected}"))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        let expected = words::expected(expected);
        Self::custom(format_args!("found {length} elements, expected {expected}"))
    }

    fn unknown_variant(found: &str, expected: &'static [&'static str]) -> Self {
        let expected = words::one_of(expected);
        Self::custom(format_args!("found \"{found}\", expected {expected}"))
    }

    /// The caller that reads the key adds the key to the error.
    fn unknown_field(_key: &str, expected: &'static [&'static str]) -> Self {
        Self::custom(format_args!("no such key, expected {}", words::one_of(expected)))
    }

    fn missing_field(key: &'static str) -> Self {
        Self::custom("found none, expected one").inside(Place::Key(key.to_owned()))
    }
}

impl ValueError {
    fn inside(mut self, place: Place) -> Self {
        self.place.push(place);
        self
    }
}

/// Passes a value to a visitor. Only tables become structures and maps, and only arrays become sequences, so that each
/// type is compiled for one kind of access.
pub(crate) struct ValueDeserializer<'a> {
    value: &'a Value,
    /// The keys of the path to the value, joined by dots.
    path: String,
    unknown: &'a mut Vec<String>,
}

impl<'a> ValueDeserializer<'a> {
    pub fn new(value: &'a Value, unknown: &'a mut Vec<String>) -> Self {
        Self { value, path: String::new(), unknown }
    }

    fn invalid_type(&self, visitor: &dyn serde::de::Expected) -> ValueError {
        let date;
        let found = match self.value {
            Value::String(text) => Unexpected::Str(text),
            Value::Integer(number) => Unexpected::Signed(*number),
            Value::Float(number) => Unexpected::Float(*number),
            Value::Boolean(is) => Unexpected::Bool(*is),
            Value::Datetime(at) => {
                date = format!("date {at}");
                Unexpected::Other(&date)
            }
            Value::Array(_) => Unexpected::Seq,
            Value::Table(_) => Unexpected::Map,
        };
        ValueError::invalid_type(found, visitor)
    }

    fn map<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        match self.value {
            Value::Table(table) => visitor.visit_map(Entries {
                rest: table.iter(),
                value: None,
                path: self.path,
                unknown: self.unknown,
            }),
            _ => Err(self.invalid_type(&visitor)),
        }
    }

    fn list<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        match self.value {
            Value::Array(list) => {
                let mut elements =
                    Elements { list, next: 0, path: self.path, unknown: self.unknown };
                let read = visitor.visit_seq(&mut elements)?;
                elements.report_unread();
                Ok(read)
            }
            _ => Err(self.invalid_type(&visitor)),
        }
    }
}

impl<'de> Deserializer<'de> for ValueDeserializer<'_> {
    type Error = ValueError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        match self.value {
            Value::Table(_) => self.map(visitor),
            Value::Array(_) => self.list(visitor),
            Value::String(text) => visitor.visit_str(text),
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Boolean(is) => visitor.visit_bool(*is),
            Value::Datetime(at) => visitor.visit_string(at.to_string()),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        self.map(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        self.map(visitor)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        self.list(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        _length: usize,
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        self.list(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        let (name, content) = match self.value {
            Value::String(name) => (name, None),
            Value::Table(table) if table.len() == 1 => match table.iter().next() {
                Some((name, content)) => (name, Some(content)),
                None => return Err(self.invalid_type(&visitor)),
            },
            _ => return Err(self.invalid_type(&visitor)),
        };
        visitor.visit_enum(Variant { name, content, path: self.path, unknown: self.unknown })
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        self.unknown.push(self.path);
        visitor.visit_unit()
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct tuple_struct identifier
    }
}

/// The entries of a table.
struct Entries<'a> {
    rest: Iter<'a, String, Value>,
    /// The key that was just returned, with its value.
    value: Option<(&'a String, &'a Value)>,
    path: String,
    unknown: &'a mut Vec<String>,
}

impl<'a> Entries<'a> {
    fn next_key(&mut self) -> Option<Key<'a>> {
        self.value = self.rest.next();
        self.value.map(|(key, _)| Key(key))
    }

    fn next_value(&mut self) -> Result<ValueDeserializer<'_>, ValueError> {
        let (key, value) = self.value.ok_or_else(|| ValueError::custom("a value without a key"))?;
        let path = if self.path.is_empty() { key.clone() } else { format!("{}.{key}", self.path) };
        Ok(ValueDeserializer { value, path, unknown: self.unknown })
    }

    /// `error` with the path of the entry that was just returned.
    fn inside(&self, error: ValueError) -> ValueError {
        match self.value {
            Some((key, _)) => error.inside(Place::Key(key.clone())),
            None => error,
        }
    }
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = ValueError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, ValueError> {
        let Some(key) = self.next_key() else { return Ok(None) };
        seed.deserialize(key).map(Some).map_err(|error| self.inside(error))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<S::Value, ValueError> {
        let read = seed.deserialize(self.next_value()?);
        read.map_err(|error| self.inside(error))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// A key, or the name of a variant.
struct Key<'a>(&'a str);

impl<'de> Deserializer<'de> for Key<'_> {
    type Error = ValueError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ValueError> {
        visitor.visit_str(self.0)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option
        unit unit_struct newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

/// The elements of an array.
struct Elements<'a> {
    list: &'a [Value],
    next: usize,
    path: String,
    unknown: &'a mut Vec<String>,
}

impl Elements<'_> {
    fn next_value(&mut self) -> Option<ValueDeserializer<'_>> {
        let index = self.next;
        let value = self.list.get(index)?;
        self.next += 1;
        let path = format!("{}.{index}", self.path);
        Some(ValueDeserializer { value, path, unknown: self.unknown })
    }

    /// Adds the unread elements to the unknown keys.
    fn report_unread(self) {
        let rest = self.next..self.list.len();
        self.unknown.extend(rest.map(|index| format!("{}.{index}", self.path)));
    }
}

impl<'de> SeqAccess<'de> for Elements<'_> {
    type Error = ValueError;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, ValueError> {
        let index = self.next;
        let Some(element) = self.next_value() else { return Ok(None) };
        let read = seed.deserialize(element);
        read.map(Some).map_err(|error| error.inside(Place::Index(index)))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.list.len() - self.next)
    }
}

/// A variant of an enumeration: a string without content, or a table with the variant as its only key.
struct Variant<'a> {
    name: &'a String,
    content: Option<&'a Value>,
    path: String,
    unknown: &'a mut Vec<String>,
}

impl<'a, 'de> EnumAccess<'de> for Variant<'a> {
    type Error = ValueError;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(
        self,
        seed: S,
    ) -> Result<(S::Value, Self), ValueError> {
        Ok((seed.deserialize(Key(self.name))?, self))
    }
}

impl<'a> Variant<'a> {
    /// Passes the content of the variant to `read`.
    fn content<T>(
        self,
        read: impl FnOnce(ValueDeserializer<'a>) -> Result<T, ValueError>,
    ) -> Result<T, ValueError> {
        let Some(value) = self.content else {
            let name = self.name;
            return Err(ValueError::custom(format_args!(
                "found {name} alone, expected a table with its content"
            )));
        };
        let path = format!("{}.{}", self.path, self.name);
        read(ValueDeserializer { value, path, unknown: self.unknown })
            .map_err(|error| error.inside(Place::Key(self.name.clone())))
    }
}

impl<'de> VariantAccess<'de> for Variant<'_> {
    type Error = ValueError;

    fn unit_variant(self) -> Result<(), ValueError> {
        match self.content {
            None => Ok(()),
            Some(_) => {
                let name = self.name;
                Err(ValueError::custom(format_args!("found a table, expected \"{name}\"")))
            }
        }
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(
        self,
        seed: S,
    ) -> Result<S::Value, ValueError> {
        self.content(|content| seed.deserialize(content))
    }

    fn tuple_variant<V: Visitor<'de>>(
        self,
        _length: usize,
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        self.content(|content| content.list(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ValueError> {
        self.content(|content| content.map(visitor))
    }
}
