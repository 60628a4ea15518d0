//! The data of a value in serde's own terms. Each type is compiled for one serializer, the recorder; the several
//! serializers of `toml` are compiled for one type, the recording.

use serde::ser::{
    Serialize, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};
use toml::ser::Error;

/// The calls to a serializer for one value. A variant with content is a map whose only key is the variant's name.
#[derive(Debug)]
pub(crate) enum Recording {
    Absent,
    Unit,
    UnitStruct(&'static str),
    Boolean(bool),
    Signed(i64),
    Unsigned(u64),
    Single(f32),
    Double(f64),
    Text(String),
    List(Vec<Recording>),
    Map(Vec<[Recording; 2]>),
    /// A structure with its name: `toml` recognises a date by the name of its structure.
    Struct(&'static str, Vec<(&'static str, Recording)>),
}

impl Recording {
    /// The calls that `value` makes.
    pub fn of<T: Serialize + ?Sized>(value: &T) -> Result<Self, Error> {
        value.serialize(Recorder)
    }

    fn variant(name: &'static str, content: Self) -> Self {
        Self::Map(vec![[Self::Text(name.to_owned()), content]])
    }
}

/// Makes the recorded calls again.
impl Serialize for Recording {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Absent => serializer.serialize_none(),
            Self::Unit => serializer.serialize_unit(),
            Self::UnitStruct(name) => serializer.serialize_unit_struct(name),
            Self::Boolean(value) => serializer.serialize_bool(*value),
            Self::Signed(value) => serializer.serialize_i64(*value),
            Self::Unsigned(value) => serializer.serialize_u64(*value),
            Self::Single(value) => serializer.serialize_f32(*value),
            Self::Double(value) => serializer.serialize_f64(*value),
            Self::Text(text) => serializer.serialize_str(text),
            Self::List(list) => serializer.collect_seq(list),
            Self::Map(entries) => {
                serializer.collect_map(entries.iter().map(|[key, value]| (key, value)))
            }
            Self::Struct(name, fields) => {
                let mut structure = serializer.serialize_struct(name, fields.len())?;
                for (key, value) in fields {
                    structure.serialize_field(key, value)?;
                }
                structure.end()
            }
        }
    }
}

/// Records the calls.
struct Recorder;

impl Serializer for Recorder {
    type Ok = Recording;
    type Error = Error;
    type SerializeSeq = List;
    type SerializeTuple = List;
    type SerializeTupleStruct = List;
    type SerializeTupleVariant = List;
    type SerializeMap = Map;
    type SerializeStruct = Struct;
    type SerializeStructVariant = Struct;

    fn serialize_bool(self, value: bool) -> Result<Recording, Error> {
        Ok(Recording::Boolean(value))
    }

    fn serialize_i8(self, value: i8) -> Result<Recording, Error> {
        Ok(Recording::Signed(value.into()))
    }

    fn serialize_i16(self, value: i16) -> Result<Recording, Error> {
        Ok(Recording::Signed(value.into()))
    }

    fn serialize_i32(self, value: i32) -> Result<Recording, Error> {
        Ok(Recording::Signed(value.into()))
    }

    fn serialize_i64(self, value: i64) -> Result<Recording, Error> {
        Ok(Recording::Signed(value))
    }

    fn serialize_u8(self, value: u8) -> Result<Recording, Error> {
        Ok(Recording::Unsigned(value.into()))
    }

    fn serialize_u16(self, value: u16) -> Result<Recording, Error> {
        Ok(Recording::Unsigned(value.into()))
    }

    fn serialize_u32(self, value: u32) -> Result<Recording, Error> {
        Ok(Recording::Unsigned(value.into()))
    }

    fn serialize_u64(self, value: u64) -> Result<Recording, Error> {
        Ok(Recording::Unsigned(value))
    }

    fn serialize_f32(self, value: f32) -> Result<Recording, Error> {
        Ok(Recording::Single(value))
    }

    fn serialize_f64(self, value: f64) -> Result<Recording, Error> {
        Ok(Recording::Double(value))
    }

    fn serialize_char(self, value: char) -> Result<Recording, Error> {
        Ok(Recording::Text(value.into()))
    }

    fn serialize_str(self, text: &str) -> Result<Recording, Error> {
        Ok(Recording::Text(text.to_owned()))
    }

    fn serialize_bytes(self, bytes: &[u8]) -> Result<Recording, Error> {
        Recording::of(bytes)
    }

    fn serialize_none(self) -> Result<Recording, Error> {
        Ok(Recording::Absent)
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<Recording, Error> {
        Recording::of(value)
    }

    fn serialize_unit(self) -> Result<Recording, Error> {
        Ok(Recording::Unit)
    }

    fn serialize_unit_struct(self, name: &'static str) -> Result<Recording, Error> {
        Ok(Recording::UnitStruct(name))
    }

    fn serialize_unit_variant(
        self,
        _name: &'static str,
        _index: u32,
        variant: &'static str,
    ) -> Result<Recording, Error> {
        self.serialize_str(variant)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _name: &'static str,
        value: &T,
    ) -> Result<Recording, Error> {
        Recording::of(value)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _name: &'static str,
        _index: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<Recording, Error> {
        Ok(Recording::variant(variant, Recording::of(value)?))
    }

    fn serialize_seq(self, length: Option<usize>) -> Result<List, Error> {
        Ok(List { variant: None, list: Vec::with_capacity(length.unwrap_or(0)) })
    }

    fn serialize_tuple(self, length: usize) -> Result<List, Error> {
        self.serialize_seq(Some(length))
    }

    fn serialize_tuple_struct(self, _name: &'static str, length: usize) -> Result<List, Error> {
        self.serialize_seq(Some(length))
    }

    fn serialize_tuple_variant(
        self,
        _name: &'static str,
        _index: u32,
        variant: &'static str,
        length: usize,
    ) -> Result<List, Error> {
        Ok(List { variant: Some(variant), list: Vec::with_capacity(length) })
    }

    fn serialize_map(self, length: Option<usize>) -> Result<Map, Error> {
        Ok(Map { key: Recording::Unit, entries: Vec::with_capacity(length.unwrap_or(0)) })
    }

    fn serialize_struct(self, name: &'static str, length: usize) -> Result<Struct, Error> {
        Ok(Struct { variant: None, name, fields: Vec::with_capacity(length) })
    }

    fn serialize_struct_variant(
        self,
        name: &'static str,
        _index: u32,
        variant: &'static str,
        length: usize,
    ) -> Result<Struct, Error> {
        Ok(Struct { variant: Some(variant), name, fields: Vec::with_capacity(length) })
    }
}

/// A list being recorded.
struct List {
    /// The variant whose content is the list, if any.
    variant: Option<&'static str>,
    list: Vec<Recording>,
}

impl List {
    fn put(&mut self, element: Recording) {
        self.list.push(element);
    }

    fn whole(self) -> Recording {
        let list = Recording::List(self.list);
        match self.variant {
            Some(name) => Recording::variant(name, list),
            None => list,
        }
    }
}

/// The traits for elements of a list differ only in their names.
macro_rules! list {
    ($($elements:ident: $element:ident),+) => {$(
        impl $elements for List {
            type Ok = Recording;
            type Error = Error;

            fn $element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Error> {
                self.put(Recording::of(value)?);
                Ok(())
            }

            fn end(self) -> Result<Recording, Error> {
                Ok(self.whole())
            }
        }
    )+};
}

list!(
    SerializeSeq: serialize_element,
    SerializeTuple: serialize_element,
    SerializeTupleStruct: serialize_field,
    SerializeTupleVariant: serialize_field
);

/// A map being recorded.
struct Map {
    /// The last key, whose value comes next.
    key: Recording,
    entries: Vec<[Recording; 2]>,
}

impl Map {
    fn put(&mut self, value: Recording) {
        let key = std::mem::replace(&mut self.key, Recording::Unit);
        self.entries.push([key, value]);
    }
}

impl SerializeMap for Map {
    type Ok = Recording;
    type Error = Error;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Error> {
        self.key = Recording::of(key)?;
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Error> {
        self.put(Recording::of(value)?);
        Ok(())
    }

    fn end(self) -> Result<Recording, Error> {
        Ok(Recording::Map(self.entries))
    }
}

/// A structure being recorded.
struct Struct {
    /// The variant whose content is the structure, if any.
    variant: Option<&'static str>,
    name: &'static str,
    fields: Vec<(&'static str, Recording)>,
}

impl Struct {
    fn put(&mut self, key: &'static str, value: Recording) {
        self.fields.push((key, value));
    }

    fn whole(self) -> Recording {
        let structure = Recording::Struct(self.name, self.fields);
        match self.variant {
            Some(name) => Recording::variant(name, structure),
            None => structure,
        }
    }
}

/// The traits for fields of a structure differ only in their names.
macro_rules! structure {
    ($($structure:ident),+) => {$(
        impl $structure for Struct {
            type Ok = Recording;
            type Error = Error;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                key: &'static str,
                value: &T,
            ) -> Result<(), Error> {
                self.put(key, Recording::of(value)?);
                Ok(())
            }

            fn end(self) -> Result<Recording, Error> {
                Ok(self.whole())
            }
        }
    )+};
}

structure!(SerializeStruct, SerializeStructVariant);

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use toml::value::Datetime;

    use super::*;

    #[derive(serde::Serialize)]
    enum Kind {
        Bare,
        One(f32),
        Two(u8, i64),
        Named { height_m: f64, at: Option<Datetime> },
    }

    #[derive(serde::Serialize)]
    struct Inner {
        kind: Kind,
        name: Option<&'static str>,
    }

    #[derive(serde::Serialize)]
    struct Outer {
        tables: Vec<Inner>,
        single: f32,
        double: f64,
        date: Datetime,
        kinds: [Kind; 3],
        by_letter: BTreeMap<char, Inner>,
        by_name: BTreeMap<&'static str, [f64; 2]>,
        absent: Option<u64>,
        settings: toml::Table,
        letter: char,
        large: u64,
        empty: BTreeMap<u8, u8>,
    }

    fn outer(large: u64) -> Outer {
        let date: Datetime = "2026-02-03T04:05:06Z".parse().unwrap();
        let inner = |kind, name| Inner { kind, name };
        Outer {
            tables: vec![inner(Kind::Bare, Some("é \"x\"")), inner(Kind::One(0.1), None)],
            single: 0.1,
            double: 0.1 + 0.2,
            date,
            kinds: [Kind::Bare, Kind::Two(3, -4), Kind::Named { height_m: -0.0, at: Some(date) }],
            by_letter: [('x', inner(Kind::Named { height_m: 1e300, at: None }, Some("a")))].into(),
            by_name: [("a key", [f64::NAN, f64::INFINITY]), ("b", [1.0, 1e-7])].into(),
            absent: None,
            settings: "[a.b]\nc = [1, 2.5]\nd = 2026-02-03\n".parse().unwrap(),
            letter: 'ß',
            large,
            empty: BTreeMap::new(),
        }
    }

    #[test]
    fn a_recording_is_written_as_what_was_recorded() {
        for large in [i64::MAX as u64, u64::MAX] {
            let value = outer(large);
            let written = toml::to_string(&Recording::of(&value).unwrap()).unwrap();
            assert_eq!(written, toml::to_string(&value).unwrap());
            assert!(written.contains("single = 0.1\n"), "{written}");
        }
        let numbered = BTreeMap::from([(7u16, BTreeMap::from([(true, -1i8)]))]);
        let written = toml::to_string(&Recording::of(&numbered).unwrap()).unwrap();
        assert_eq!(written, toml::to_string(&numbered).unwrap());
    }

    #[test]
    fn a_recording_is_the_value_of_what_was_recorded() {
        let value = outer(7);
        let recorded = toml::Value::try_from(Recording::of(&value).unwrap()).unwrap();
        // As text, because NaN equals no number.
        assert_eq!(recorded.to_string(), toml::Value::try_from(&value).unwrap().to_string());
    }

    #[test]
    fn a_recording_is_refused_as_what_was_recorded() {
        #[derive(serde::Serialize)]
        struct Nothing;

        fn assert_same<T: Serialize>(value: &T) {
            let recording = Recording::of(value).unwrap();
            assert_eq!(toml::Value::try_from(&recording), toml::Value::try_from(value));
            assert_eq!(toml::to_string(&recording), toml::to_string(value));
            assert!(toml::Value::try_from(value).and(toml::to_string(value)).is_err());
        }
        assert_same(&BTreeMap::from([("a", u64::MAX)]));
        assert_same(&BTreeMap::from([("a", [Some(1), None])]));
        assert_same(&BTreeMap::from([("a", ())]));
        assert_same(&BTreeMap::from([("a", Nothing)]));
        assert_same(&BTreeMap::from([([1], 2)]));
        assert_same(&BTreeMap::from([(7, 2)]));
    }
}
