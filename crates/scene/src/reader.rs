//! Reader of the file's types out of a parsed TOML document.
//!
//! A deserializer of our own, because serde's generic messages neither name the key nor say what
//! would be right: it answers every mismatch with a [`Fault`] and notes the path on the way out.
//!
//! serde ends at the first fault. To find them all, what is at fault is amended in the [`Review`] (an unknown key is left
//! out, a wrong or missing value has a stand-in), and reading begins anew. Each material and each shape is a part of its
//! own: a fault in one does not keep the others from being read, so that there are no more readings than the worst part
//! has faults.

mod stand_in;

use std::iter::Enumerate;
use std::marker::PhantomData;
use std::slice;

use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, Error as _, IntoDeserializer, MapAccess, SeqAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

use crate::fault::{Fault, Kind, Step, steps};
use crate::file::{COLOR, Shapes, Time};
use crate::names;
use crate::review::Review;
use stand_in::StandIn;

/// Most readings of one document; each finds at least one fault.
const MOST_READINGS: usize = 20;

/// The document as `T`, and in `review` what is wrong with it; `None` where there is too much of that.
pub(crate) fn read<T: DeserializeOwned>(root: &DeValue<'_>, review: &Review) -> Option<T> {
    for _ in 0..MOST_READINGS {
        let before = review.met();
        match read_value(PhantomData, Some(root), review) {
            Ok(value) if review.met() == before => return Some(value),
            Ok(_) => {}
            Err(fault) => review.note(fault),
        }
        if review.is_full() {
            break;
        }
    }
    None
}

/// One value as `T`, or its first fault.
pub(crate) fn read_alone<T: DeserializeOwned>(value: &DeValue<'_>) -> Result<T, Fault> {
    T::deserialize(Node { value, review: &Review::default() })
}

/// Reads a value, or its stand-in where it is at fault or missing.
fn read_value<'de, T: DeserializeSeed<'de>>(
    seed: T,
    value: Option<&'de DeValue<'de>>,
    review: &'de Review,
) -> Result<T::Value, Fault> {
    match value {
        Some(value) if !review.is_replaced(value) => {
            seed.deserialize(Node { value, review }).inspect_err(|fault| review.amend(value, fault))
        }
        _ => seed.deserialize(StandIn),
    }
}

/// One value of the document.
#[derive(Clone, Copy)]
struct Node<'de> {
    value: &'de DeValue<'de>,
    review: &'de Review,
}

impl<'de> Node<'de> {
    fn is_not(self, expected: impl Into<String>) -> Fault {
        let found = match self.value {
            DeValue::String(_) => Some("a string"),
            DeValue::Datetime(_) => Some("a date"),
            DeValue::Array(_) => Some("a list"),
            DeValue::Table(_) => Some("a table"),
            DeValue::Integer(_) | DeValue::Float(_) | DeValue::Boolean(_) => None,
        };
        let expected = expected.into();
        Fault::new(Kind::WrongType { expected, found })
    }

    fn items(self, array: &'de [Spanned<DeValue<'de>>], is_list: bool) -> Items<'de> {
        Items { rest: array.iter().enumerate(), review: self.review, is_list }
    }

    /// Entries of a table, without unknown keys and with the missing ones.
    fn entries(
        self,
        table: &'de DeTable<'de>,
        is_list: bool,
    ) -> Entries<'de, impl Iterator<Item = (&'de str, Option<&'de DeValue<'de>>)>> {
        let entries = table.iter().map(|(key, value)| (key.get_ref().as_ref(), value.get_ref()));
        let known = entries.filter(move |(_, value)| !self.review.is_left_out(value));
        let missing = self.review.missing_in(self.value).into_iter().map(|key| (key, None));
        let rest = known.map(|(key, value)| (key, Some(value))).chain(missing);
        Entries { rest, current: None, review: self.review, is_list }
    }

    fn number(self) -> Result<f64, Fault> {
        match self.value {
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
        match self.value {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(_) | DeValue::Float(_) => visitor.visit_f64(self.number()?),
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            DeValue::Datetime(_) => Err(self.is_not("a number or a string")),
            DeValue::Array(array) => visitor.visit_seq(self.items(array, false)),
            DeValue::Table(table) => visitor.visit_map(self.entries(table, false)),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            _ => Err(self.is_not("`true` or `false`")),
        }
    }

    fn deserialize_i128<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::Integer(integer) => visitor.visit_i128(whole(integer)),
            _ => Err(self.is_not("a whole number")),
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_f64(self.number()?)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
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

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::Datetime(time) if name == Time::NAME => visitor.visit_str(&time.to_string()),
            DeValue::String(_) => visitor.visit_newtype_struct(self),
            _ if name == Time::NAME => Err(self.is_not(Time::EXPECTED)),
            _ => visitor.visit_newtype_struct(self),
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::Array(array) => visitor.visit_seq(self.items(array, false)),
            _ => Err(self.is_not("a list")),
        }
    }

    /// Reads a colour, which has three components, or a list of tables, which has any length. Shapes are parts of their own;
    /// other lists are read with the keys of the table around them.
    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::Array(array) if length > 0 && array.len() != length => {
                Err(Fault::new(Kind::WrongLength { expected: length, found: array.len() }))
            }
            DeValue::Array(array) => visitor.visit_seq(self.items(array, name == Shapes::NAME)),
            DeValue::String(text) if length > 0 => visitor.visit_str(text),
            DeValue::Table(table) if length > 0 => visitor.visit_map(self.entries(table, false)),
            _ if length > 0 => Err(self.is_not(COLOR)),
            DeValue::Table(_) => Err(self.is_not(format!("a list, written `[[{name}]]`"))),
            _ => Err(self.is_not("a list")),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::Array(array) if array.len() == length => visitor.visit_seq(self.items(array, false)),
            DeValue::Array(array) => {
                let (expected, found) = (length, array.len());
                Err(Fault::new(Kind::WrongLength { expected, found }))
            }
            _ => Err(self.is_not(format!("a list of {length} numbers"))),
        }
    }

    /// Reads a table of any keys; the only one is that of the materials.
    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::Table(table) => visitor.visit_map(self.entries(table, true)),
            _ => Err(self.is_not("a table")),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::Table(table) => visitor.visit_map(self.entries(table, false)),
            _ => Err(self.is_not("a table")),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.value {
            DeValue::String(text) => visitor.visit_enum(text.as_ref().into_deserializer()),
            _ => Err(self.is_not(names::strings(variants))),
        }
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 u8 u16 u32 u64 u128 f32 char bytes byte_buf unit unit_struct identifier ignored_any
    }
}

/// The elements of a list.
struct Items<'de> {
    rest: Enumerate<slice::Iter<'de, Spanned<DeValue<'de>>>>,
    review: &'de Review,
    /// Whether these are the shapes: the fault of one is noted, and the next may be asked for.
    is_list: bool,
}

impl<'de> SeqAccess<'de> for Items<'de> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let Some((index, value)) = self.rest.next() else {
            return Ok(None);
        };
        let element = read_value(seed, Some(value.get_ref()), self.review).map(Some);
        element.map_err(|fault| match self.is_list {
            true => self.review.note_part(fault, steps![Shapes::NAME, index]),
            false => fault.inside(Step::Index(index)),
        })
    }
}

/// The entries of a table; the key is kept until its value, which a missing key has not, has been read.
struct Entries<'de, I> {
    rest: I,
    current: Option<(&'de str, Option<&'de DeValue<'de>>)>,
    review: &'de Review,
    /// Whether these are the materials: the fault of one is noted, and the next may be asked for.
    is_list: bool,
}

impl<'de, I> MapAccess<'de> for Entries<'de, I>
where
    I: Iterator<Item = (&'de str, Option<&'de DeValue<'de>>)>,
{
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        self.current = self.rest.next();
        let Some((key, value)) = self.current else {
            return Ok(None);
        };
        let unknown = |_: &Fault| {
            if let Some(value) = value {
                self.review.leave_out(value);
            }
        };
        seed.deserialize(key.into_deserializer()).map(Some).inspect_err(unknown)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let Some((key, value)) = self.current.take() else {
            return Err(Fault::custom("must be preceded by its key"));
        };
        read_value(seed, value, self.review).map_err(|fault| match self.is_list {
            true => self.review.note_part(fault, steps!["materials", key]),
            false => fault.inside(Step::from(key)),
        })
    }
}
