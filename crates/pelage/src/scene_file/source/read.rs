//! A tree as serde's data, and what does not fit in it: where it stands, what it is, and what should be there.

use std::fmt;
use std::ops::Range;

use serde::de::value::StrDeserializer;
use serde::de::{
    self, DeserializeSeed, Deserializer, EnumAccess, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;

use super::{Entry, Node, Step, Value};
use crate::names;

/// Something that is not what it should be.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Misread {
    /// From the root to it.
    pub(super) steps: Vec<Step>,
    /// Whether there should be nothing of the last one's name.
    pub(super) unknown: bool,
    pub(super) at: Option<Range<usize>>,
    /// Which field is not there.
    pub(super) missing: Option<&'static str>,
    pub(super) reason: String,
    pub(super) hint: Option<String>,
}

impl Misread {
    fn new(reason: String, hint: Option<String>) -> Self {
        Self { reason, hint, ..Self::default() }
    }

    fn in_step(mut self, step: Step, at: &Range<usize>) -> Self {
        self.at.get_or_insert_with(|| at.clone());
        self.steps.insert(0, step);
        self
    }
}

impl fmt::Display for Misread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)?;
        self.hint.as_ref().map_or(Ok(()), |hint| write!(f, ": {hint}"))
    }
}

impl std::error::Error for Misread {}

impl de::Error for Misread {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(message.to_string(), None)
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::new(format!("found {}", named(found)), Some(format!("expected {}", plain(expected))))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let expected = match expected.to_string().as_str() {
            "u32" | "u64" | "usize" => "a whole number, not negative and not too large".to_owned(),
            _ => plain(expected),
        };
        Self::new(format!("found {}", named(found)), Some(format!("expected {expected}")))
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        Self::new(format!("found a list of {length}"), Some(format!("expected {}", plain(expected))))
    }

    fn unknown_variant(name: &str, known: &'static [&'static str]) -> Self {
        Self::new(names::missing("kind", name), Some(names::nearest(name, known.iter().copied())))
    }

    fn unknown_field(name: &str, known: &'static [&'static str]) -> Self {
        Self::new(names::missing("field", name), Some(names::nearest(name, known.iter().copied())))
    }

    fn missing_field(name: &'static str) -> Self {
        Self { missing: Some(name), ..Self::new(format!("the field `{name}` is missing"), None) }
    }

    fn duplicate_field(name: &'static str) -> Self {
        Self::new(format!("`{name}` is there twice"), None)
    }
}

/// What was found, in the words of the file.
fn named(found: Unexpected<'_>) -> String {
    match found {
        Unexpected::Bool(truth) => truth.to_string(),
        Unexpected::Unsigned(n) => n.to_string(),
        Unexpected::Signed(n) => n.to_string(),
        Unexpected::Float(x) => x.to_string(),
        Unexpected::Str(text) => format!("{text:?}"),
        Unexpected::Seq => "a list".into(),
        Unexpected::Map => "a table".into(),
        Unexpected::Unit => "nothing".into(),
        Unexpected::StructVariant | Unexpected::NewtypeVariant => "a table".into(),
        Unexpected::UnitVariant => "a name without a table".into(),
        other => other.to_string(),
    }
}

/// What was expected, with the types of the file instead of those of this program.
fn plain(expected: &dyn Expected) -> String {
    let expected = expected.to_string();
    match expected.as_str() {
        "f32" | "f64" => "a number".into(),
        "u32" | "u64" | "usize" => "a whole number".into(),
        "a sequence" => "a list".into(),
        "a boolean" => "true or false".into(),
        "a sequence of 2 f32 values" => "a list of 2 numbers".into(),
        "a sequence of 3 f32 values" => "a list of 3 numbers".into(),
        _ if expected.starts_with("struct ") || expected.starts_with("enum ") || expected == "a map" => {
            "a table".into()
        }
        _ => expected.replace("an array of length ", "a list of "),
    }
}

impl<'de> Deserializer<'de> for &'de Node {
    type Error = Misread;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misread> {
        match &self.value {
            Value::Table(entries) => visitor.visit_map(Entries { rest: entries, current: None }),
            Value::List(nodes) => {
                let mut elements = Elements { nodes, next: 0 };
                let list = visitor.visit_seq(&mut elements)?;
                match elements.left() {
                    0 => Ok(list),
                    // What took as many as it wanted did not look whether there were more.
                    more => {
                        let read = elements.nodes.iter().filter(|node| !node.removed).count();
                        let hint = format!("expected a list of {}", read - more);
                        Err(Misread::new(format!("found a list of {read}"), Some(hint)))
                    }
                }
            }
            Value::Text(text) => visitor.visit_borrowed_str(text),
            &Value::Whole(whole) => match (i64::try_from(whole), u64::try_from(whole)) {
                (Ok(n), _) => visitor.visit_i64(n),
                (_, Ok(n)) => visitor.visit_u64(n),
                _ => visitor.visit_i128(whole),
            },
            &Value::Number(number) => visitor.visit_f64(number),
            &Value::Truth(truth) => visitor.visit_bool(truth),
            Value::Date => Err(de::Error::invalid_type(Unexpected::Other("a date"), &visitor)),
            Value::Nothing => visitor.visit_unit(),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misread> {
        if self.value == Value::Nothing { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &str, visitor: V) -> Result<V::Value, Misread> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misread> {
        visitor.visit_unit()
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misread> {
        let one_of = || {
            let list: Vec<String> = variants.iter().map(|name| format!("`{name}`")).collect();
            Some(format!("expected one of {}", list.join(", ")))
        };
        match &self.value {
            Value::Text(name) => visitor.visit_enum(name.as_str().into_deserializer()),
            Value::Table(entries) => {
                let mut there = entries.iter().filter(|entry| !entry.node.removed);
                match (there.next(), there.count()) {
                    (Some(entry), 0) => visitor.visit_enum(entry),
                    (Some(_), more) => Err(Misread::new(format!("found {} fields", more + 1), one_of())),
                    (None, _) => Err(Misread::new("found an empty table".into(), one_of())),
                }
            }
            _ => Err(Misread { hint: one_of(), ..de::Error::invalid_type(self.unexpected(), &visitor) }),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq
        tuple tuple_struct map struct identifier
    }
}

impl Node {
    fn unexpected(&self) -> Unexpected<'_> {
        match &self.value {
            Value::Table(_) => Unexpected::Map,
            Value::List(_) => Unexpected::Seq,
            Value::Text(text) => Unexpected::Str(text),
            Value::Whole(whole) => {
                i64::try_from(*whole).map_or(Unexpected::Other("a number"), Unexpected::Signed)
            }
            Value::Number(number) => Unexpected::Float(*number),
            Value::Truth(truth) => Unexpected::Bool(*truth),
            Value::Date => Unexpected::Other("a date"),
            Value::Nothing => Unexpected::Unit,
        }
    }
}

struct Elements<'de> {
    nodes: &'de [Node],
    next: usize,
}

impl Elements<'_> {
    fn left(&self) -> usize {
        self.nodes.iter().skip(self.next).filter(|node| !node.removed).count()
    }
}

impl<'de> SeqAccess<'de> for &mut Elements<'de> {
    type Error = Misread;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Misread> {
        while let Some(node) = self.nodes.get(self.next) {
            let index = self.next;
            self.next += 1;
            if !node.removed {
                let read = seed.deserialize(node);
                return read.map(Some).map_err(|e| e.in_step(Step::Index(index), &node.at));
            }
        }
        Ok(None)
    }
}

struct Entries<'de> {
    rest: &'de [Entry],
    current: Option<&'de Entry>,
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = Misread;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Misread> {
        while let [entry, rest @ ..] = self.rest {
            self.rest = rest;
            if !entry.node.removed {
                self.current = Some(entry);
                return entry.name(seed).map(Some);
            }
        }
        Ok(None)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Misread> {
        let entry =
            self.current.take().ok_or_else(|| <Misread as de::Error>::custom("a value without a key"))?;
        seed.deserialize(&entry.node).map_err(|e| e.in_step(Step::Key(entry.key.clone()), entry.place()))
    }
}

impl Entry {
    /// Its key as what it should be.
    fn name<'de, K: DeserializeSeed<'de>>(&'de self, seed: K) -> Result<K::Value, Misread> {
        let key: StrDeserializer<'_, Misread> = self.key.as_str().into_deserializer();
        seed.deserialize(key).map_err(|e| {
            let step = Step::Key(self.key.clone());
            Misread { unknown: true, ..e.in_step(step, &self.at) }
        })
    }

    /// Of a table under a header, or one that dotted keys make, the key.
    fn place(&self) -> &Range<usize> {
        if matches!(self.node.value, Value::Table(_)) { &self.at } else { &self.node.at }
    }
}

impl<'de> EnumAccess<'de> for &'de Entry {
    type Error = Misread;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Misread> {
        Ok((self.name(seed)?, self))
    }
}

impl<'de> VariantAccess<'de> for &'de Entry {
    type Error = Misread;

    fn unit_variant(self) -> Result<(), Misread> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Misread> {
        seed.deserialize(&self.node).map_err(|e| e.in_step(Step::Key(self.key.clone()), self.place()))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Misread> {
        self.struct_variant(&[], visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misread> {
        self.node.deserialize_any(visitor).map_err(|e| e.in_step(Step::Key(self.key.clone()), self.place()))
    }
}
