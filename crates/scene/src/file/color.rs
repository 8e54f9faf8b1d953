//! Colours: linear numbers, or sRGB in the web's notation or as numbers.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::json;

use crate::number::Encoded;

/// Linear red, green and blue, however the file writes them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Color<T>(pub [T; 3]);

impl<T: Into<f64>> Color<T> {
    /// Linear components.
    pub fn linear(self) -> [f64; 3] {
        self.0.map(Into::into)
    }
}

/// What a colour must be, as messages say it.
pub(crate) const COLOR: &str = "a colour: 3 linear numbers, a text such as `\"#ff8800\"`, or `{ srgb = [1, 0.5, 0] }`";

/// Encoded red, green and blue in a table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SrgbTable {
    srgb: [Encoded; 3],
}

impl<'de, T: Deserialize<'de> + TryFrom<f64, Error: fmt::Display>> Deserialize<'de> for Color<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // Of the lists of the reader this alone has a length.
        deserializer.deserialize_tuple_struct("color", 3, ColorVisitor(PhantomData))
    }
}

struct ColorVisitor<T>(PhantomData<T>);

impl<T: TryFrom<f64, Error: fmt::Display>> ColorVisitor<T> {
    /// Colour of encoded components from 0 to 1.
    fn decoded<E: Error>(encoded: [f64; 3]) -> Result<Color<T>, E> {
        let component = |encoded: f64| T::try_from(decode(encoded)).map_err(E::custom);
        let [red, green, blue] = encoded;
        Ok(Color([component(red)?, component(green)?, component(blue)?]))
    }
}

impl<'de, T: Deserialize<'de> + TryFrom<f64, Error: fmt::Display>> Visitor<'de> for ColorVisitor<T> {
    type Value = Color<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(COLOR)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Color<T>, A::Error> {
        let mut next = || list.next_element()?.ok_or_else(|| A::Error::custom("must be three numbers"));
        Ok(Color([next()?, next()?, next()?]))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Color<T>, E> {
        let advice = "write `\"#rrggbb\"`, three pairs of hexadecimal digits, or `\"#rgb\"`";
        let digits = hexadecimal(text).ok_or_else(|| E::custom(format!("must be a colour: {advice}")))?;
        Self::decoded(digits.map(|byte| f64::from(byte) / 255.0))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Color<T>, A::Error> {
        let SrgbTable { srgb } = SrgbTable::deserialize(MapAccessDeserializer::new(map))?;
        Self::decoded(srgb.map(f64::from))
    }
}

/// Bytes of a colour in the web's notation, `#rrggbb` or `#rgb`.
fn hexadecimal(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#')?;
    let digits: Vec<u8> =
        digits.chars().map(|digit| digit.to_digit(16).map(|digit| digit as u8)).collect::<Option<_>>()?;
    match digits[..] {
        [r, g, b] => Some([17 * r, 17 * g, 17 * b]),
        [r, rr, g, gg, b, bb] => Some([16 * r + rr, 16 * g + gg, 16 * b + bb]),
        _ => None,
    }
}

/// Linear value of an sRGB component from 0 to 1 (IEC 61966-2-1).
fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

impl<T: JsonSchema> JsonSchema for Color<T> {
    fn schema_name() -> Cow<'static, str> {
        // Components of all surfaces' colours have one range, whatever they are called.
        let limited = T::json_schema(&mut SchemaGenerator::default()).get("maximum") == Some(&json!(1));
        if limited { "Color".into() } else { "Radiance".into() }
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let component = T::json_schema(generator);
        let encoded = Encoded::json_schema(generator);
        let three = |items: Schema| json!({ "type": "array", "items": items, "minItems": 3, "maxItems": 3 });
        json_schema!({
            "description": "Linear red, green and blue, or the same as sRGB.",
            "anyOf": [
                three(component),
                { "type": "string", "pattern": "^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$" },
                {
                    "type": "object",
                    "additionalProperties": false,
                    "required": ["srgb"],
                    "properties": { "srgb": three(encoded) }
                }
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{decode, hexadecimal};

    #[test]
    fn notation_of_the_web() {
        assert_eq!(hexadecimal("#ff8800"), Some([255, 136, 0]));
        assert_eq!(hexadecimal("#F80"), Some([255, 136, 0]));
        for wrong in ["", "#", "ff8800", "#ff88", "#ff88000", "#ff880g", "#ff8800ff", "red", "#+f+f+f"] {
            assert_eq!(hexadecimal(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn decoding() {
        assert_eq!((decode(0.0), decode(1.0)), (0.0, 1.0));
        assert!((decode(0.5) - 0.214_041_140_482).abs() < 1e-12, "{}", decode(0.5));
        assert!((decode(0.04045) - decode(0.040_450_001)).abs() < 1e-8);
    }
}
