//! Enumerations that glTF writes as numbers.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserializer, Error, Visitor};

/// Reads a number and what it stands for. Unlike those of `#[serde(try_from)]`, errors are made while the reader stands
/// behind the number, so that they know their place.
pub(super) fn read<'de, T, D>(reader: D) -> Result<T, D::Error>
where
    T: TryFrom<u32, Error = String>,
    D: Deserializer<'de>,
{
    reader.deserialize_u32(Code(PhantomData))
}

struct Code<T>(PhantomData<T>);

impl<T: TryFrom<u32, Error = String>> Visitor<'_> for Code<T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("u32")
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<T, E> {
        let number =
            u32::try_from(number).map_err(|_| E::invalid_value(serde::de::Unexpected::Unsigned(number), &self))?;
        T::try_from(number).map_err(E::custom)
    }
}
