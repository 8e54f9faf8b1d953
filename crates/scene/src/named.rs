//! Choices by their names in scene files.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use raggio_choice::Choice;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{EnumAccess, Error, VariantAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Value, json};

/// A choice that the file writes by its name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Named<T>(pub T);

impl<T: Choice> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

impl<'de, T: Choice> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Name<T>(PhantomData<T>);

        impl<'de, T: Choice> Visitor<'de> for Name<T> {
            type Value = Named<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("string")
            }

            fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<Named<T>, A::Error> {
                let (name, variant) = data.variant::<String>()?;
                variant.unit_variant()?;
                let found = T::ALL.iter().copied().find(|choice| choice.name() == name);
                found.map(Named).ok_or_else(|| A::Error::unknown_variant(&name, T::NAMES))
            }
        }

        deserializer.deserialize_enum(T::KIND, T::NAMES, Name(PhantomData))
    }
}

impl<T: Choice> JsonSchema for Named<T> {
    fn schema_name() -> Cow<'static, str> {
        T::KIND.into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let kind =
            |choice: &T| json!({ "type": "string", "const": choice.name(), "description": choice.description() });
        json_schema!({ "oneOf": T::ALL.iter().map(kind).collect::<Vec<Value>>() })
    }
}
