//! Reader of the file's types out of a parsed TOML document.
//!
//! A deserializer of our own, because serde's generic messages neither name the key nor say what
//! would be right: it answers every mismatch with a [`Fault`] and notes the path on the way out.

use serde::de::{DeserializeSeed, Deserializer, Error as _, IntoDeserializer, MapAccess, SeqAccess, Visitor};
use serde::forward_to_deserialize_any;
use toml::Spanned;
use toml::de::{DeInteger, DeValue};

use crate::fault::{Fault, Kind, Step};
use crate::names;

/// One value of the document.
#[derive(Clone, Copy)]
pub(crate) struct Node<'de>(pub(crate) &'de DeValue<'de>);

impl<'de> Node<'de> {
    fn is_not(self, expected: impl Into<String>) -> Fault {
        let found = match self.0 {
            DeValue::String(_) => Some("a string"),
            DeValue::Datetime(_) => Some("a date"),
            DeValue::Array(_) => Some("a list"),
            DeValue::Table(_) => Some("a table"),
            DeValue::Integer(_) | DeValue::Float(_) | DeValue::Boolean(_) => None,
        };
        let expected = expected.into();
        Fault::new(Kind::WrongType { expected, found })
    }

    fn number(self) -> Result<f64, Fault> {
        match self.0 {
            DeValue::Integer(integer) => Ok(whole(integer) as f64),
            DeValue::Float(float) => {
                let number = float.as_str().parse();
                number.map_err(|_| self.is_not("a number"))
            }
            _ => Err(self.is_not("a number")),
        }
    }
}

/// The integer in 128 bits; larger ones are as much out of every range as the largest of those.
fn whole(integer: &DeInteger<'_>) -> i128 {
    let text = integer.as_str();
    let beyond = if text.starts_with('-') { i128::MIN } else { i128::MAX };
    i128::from_str_radix(text, integer.radix()).unwrap_or(beyond)
}

impl<'de> Deserializer<'de> for Node<'de> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(_) | DeValue::Float(_) => visitor.visit_f64(self.number()?),
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            DeValue::Datetime(_) => Err(self.is_not("a number or a string")),
            DeValue::Array(_) => self.deserialize_seq(visitor),
            DeValue::Table(_) => self.deserialize_map(visitor),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            _ => Err(self.is_not("`true` or `false`")),
        }
    }

    fn deserialize_i128<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::Integer(integer) => visitor.visit_i128(whole(integer)),
            _ => Err(self.is_not("a whole number")),
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_f64(self.number()?)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::String(text) => visitor.visit_str(text),
            _ => Err(self.is_not("a string")),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.deserialize_str(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_newtype_struct(self)
    }

    /// Reads a list of any length; the only one is that of the shapes.
    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::Array(array) => visitor.visit_seq(Items(array.iter().enumerate())),
            DeValue::Table(_) => Err(self.is_not("a list, written `[[shapes]]`")),
            _ => Err(self.is_not("a list")),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::Array(array) if array.len() == length => visitor.visit_seq(Items(array.iter().enumerate())),
            DeValue::Array(array) => {
                let (expected, found) = (length, array.len());
                Err(Fault::new(Kind::WrongLength { expected, found }))
            }
            _ => Err(self.is_not(format!("a list of {length} numbers"))),
        }
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::Table(table) => {
                let entries = table.iter();
                let rest = entries.map(|(key, value)| (key.get_ref().as_ref(), value.get_ref()));
                visitor.visit_map(Entries { rest, current: None })
            }
            _ => Err(self.is_not("a table")),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.deserialize_map(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.0 {
            DeValue::String(text) => visitor.visit_enum(text.as_ref().into_deserializer()),
            _ => Err(self.is_not(names::strings(variants))),
        }
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 u32 u64 u128 f32 char bytes byte_buf unit unit_struct tuple_struct
        identifier ignored_any
    }
}

/// The elements of a list.
struct Items<I>(I);

impl<'de, I> SeqAccess<'de> for Items<I>
where
    I: Iterator<Item = (usize, &'de Spanned<DeValue<'de>>)>,
{
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let Some((index, value)) = self.0.next() else {
            return Ok(None);
        };
        let element = seed.deserialize(Node(value.get_ref()));
        element.map(Some).map_err(|fault| fault.inside(Step::Index(index)))
    }
}

/// The entries of a table; the key is kept until its value has been read.
struct Entries<'de, I> {
    rest: I,
    current: Option<(&'de str, &'de DeValue<'de>)>,
}

impl<'de, I> MapAccess<'de> for Entries<'de, I>
where
    I: Iterator<Item = (&'de str, &'de DeValue<'de>)>,
{
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        self.current = self.rest.next();
        let Some((key, _)) = self.current else {
            return Ok(None);
        };
        seed.deserialize(key.into_deserializer()).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let Some((key, value)) = self.current.take() else {
            return Err(Fault::custom("must be preceded by its key"));
        };
        let value = seed.deserialize(Node(value));
        value.map_err(|fault| fault.inside(Step::from(key)))
    }
}
