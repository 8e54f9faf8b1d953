//! Numbers that check their own range when they are read, and describe it in the schema.
//!
//! Numbers stay 64-bit floats until the scene is built, so that too large a number is an error and
//! not infinity, and one that 32 bits would round to zero is an error where zero is one.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// Largest magnitude of a number: those from [`SMALLEST`] to here have a square that is a normal 32-bit float.
pub(crate) const LARGEST: f64 = 1e15;
/// Smallest magnitude of a number that may not be 0; see [`LARGEST`].
pub(crate) const SMALLEST: f64 = 1e-15;

/// Rule that a number must keep, and advice that may help whoever wrote another.
#[derive(Debug)]
pub(crate) struct Rule {
    must: String,
    advice: &'static str,
}

impl fmt::Display for Rule {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.advice {
            "" => formatter.write_str(&self.must),
            advice => write!(formatter, "{}: {advice}", self.must),
        }
    }
}

/// Checks a condition: `Ok` when it holds. NaN fails every comparison, so conditions are written positively.
fn require(condition: bool, must: impl Into<String>, advice: &'static str) -> Result<(), Rule> {
    let must = must.into();
    if condition { Ok(()) } else { Err(Rule { must, advice }) }
}

fn finite(x: f64) -> Result<(), Rule> {
    require(x.is_finite(), "must be a finite number", "")?;
    require(x.abs() <= LARGEST, "must be at most 1e15 in size", "")
}

fn positive(x: f64) -> Result<(), Rule> {
    require(x > 0.0, "must be greater than 0", "")?;
    let in_range = (SMALLEST..=LARGEST).contains(&x);
    require(in_range, "must be at least 1e-15 and at most 1e15", "")
}

fn non_negative(x: f64) -> Result<(), Rule> {
    require(x >= 0.0, "must be 0 or more", "")?;
    require(x <= LARGEST, "must be at most 1e15", "")
}

/// Largest radiance: far above any sun, and far enough below the 2^35 at which a film takes a sample for a fault.
pub(crate) const BRIGHTEST: f64 = 1e9;

fn brightness(x: f64) -> Result<(), Rule> {
    require(x >= 0.0, "must be 0 or more", "")?;
    require(x <= BRIGHTEST, "must be at most 1e9", "")
}

fn fraction(x: f64) -> Result<(), Rule> {
    require((0.0..=1.0).contains(&x), "must be between 0 and 1", "")
}

fn reflectance(x: f64) -> Result<(), Rule> {
    let advice = "a surface reflects no more light than it gets; brightness is `emission_strength`";
    require((0.0..=1.0).contains(&x), "must be between 0 and 1", advice)
}

fn encoded(x: f64) -> Result<(), Rule> {
    let advice = "sRGB of 255 steps is a text such as `\"#ff8800\"`";
    require((0.0..=1.0).contains(&x), "must be between 0 and 1", advice)
}

fn refractive_index(x: f64) -> Result<(), Rule> {
    let advice = "air has 1, water 1.33, glass 1.5, diamond 2.42";
    require((0.1..=10.0).contains(&x), "must be between 0.1 and 10", advice)
}

fn ior(x: f64) -> Result<(), Rule> {
    let advice = "water has 1.33, glass 1.5, diamond 2.42";
    require((1.0..=10.0).contains(&x), "must be between 1 and 10", advice)
}

fn asymmetry(x: f64) -> Result<(), Rule> {
    let advice = "0 scatters to all sides alike, more goes forward, less goes back";
    require((-0.999..=0.999).contains(&x), "must be between -0.999 and 0.999", advice)
}

fn field_of_view(x: f64) -> Result<(), Rule> {
    let in_range = x > 0.0 && x < 180.0;
    require(in_range, "must be greater than 0 and less than 180", "")?;
    let in_range = (0.001..=179.999).contains(&x);
    require(in_range, "must be at least 0.001 and at most 179.999", "")
}

/// A cone's angle from its axis.
fn cone_angle(x: f64) -> Result<(), Rule> {
    require((0.0..=90.0).contains(&x), "must be between 0 and 90", "it is counted from the axis")
}

/// Width of a disk of the sky: directions of 32 bits find smaller ones by luck alone.
fn disk_angle(x: f64) -> Result<(), Rule> {
    let in_range = x == 0.0 || (0.01..=180.0).contains(&x);
    require(in_range, "must be 0, or at least 0.01 and at most 180", "the sun's is 0.53, seen from the earth")
}

fn latitude(x: f64) -> Result<(), Rule> {
    require((-90.0..=90.0).contains(&x), "must be between -90 and 90", "south of the equator it is negative")
}

fn longitude(x: f64) -> Result<(), Rule> {
    require((-180.0..=180.0).contains(&x), "must be between -180 and 180", "west of Greenwich it is negative")
}

fn turbidity(x: f64) -> Result<(), Rule> {
    require((1.0..=10.0).contains(&x), "must be between 1 and 10", "a clear day has about 3, a hazy one 6")
}

fn focal_length(x: f64) -> Result<(), Rule> {
    require(x > 0.0, "must be greater than 0", "")?;
    require((1e-3..=1e9).contains(&x), "must be at least 0.001 and at most 1e9", "it is in pixels")
}

fn pixel_place(x: f64) -> Result<(), Rule> {
    require(x.abs() <= 1e9, "must be at most 1e9 in size", "it is in pixels")
}

macro_rules! numbers {
    ($($(#[$doc:meta])* $name:ident, $check:ident, { $($schema:tt)* };)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
        #[serde(try_from = "f64")]
        pub(crate) struct $name(pub(crate) f64);

        impl TryFrom<f64> for $name {
            type Error = Rule;

            fn try_from(x: f64) -> Result<Self, Rule> {
                $check(x).map(|()| Self(x))
            }
        }

        impl From<$name> for f64 {
            fn from(number: $name) -> f64 {
                number.0
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn inline_schema() -> bool {
                true
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({ "type": "number", $($schema)* })
            }
        }
    )*};
}

numbers! {
    /// A number of either sign.
    Coordinate, finite, { "minimum": -1e15, "maximum": 1e15 };
    /// A length.
    Positive, positive, { "minimum": 1e-15, "maximum": 1e15 };
    /// One component of radiance, or a factor of it.
    Brightness, brightness, { "minimum": 0, "maximum": 1e9 };
    /// A length that may be 0.
    NonNegative, non_negative, { "minimum": 0, "maximum": 1e15 };
    /// A fraction from 0 to 1.
    Fraction, fraction, { "minimum": 0, "maximum": 1 };
    /// One component of a surface's colour.
    Reflectance, reflectance, { "minimum": 0, "maximum": 1 };
    /// Mean cosine of the angle by which a medium scatters light.
    Asymmetry, asymmetry, { "minimum": -0.999, "maximum": 0.999 };
    /// One component of a colour, encoded as sRGB.
    Encoded, encoded, { "minimum": 0, "maximum": 1 };
    /// Refractive index relative to vacuum.
    RefractiveIndex, refractive_index, { "minimum": 0.1, "maximum": 10 };
    /// Refractive index of a principled material, relative to vacuum.
    Ior, ior, { "minimum": 1, "maximum": 10 };
    /// Angle of view in degrees.
    FieldOfView, field_of_view, { "minimum": 0.001, "maximum": 179.999 };
    /// Angle from the axis of a cone, in degrees.
    ConeAngle, cone_angle, { "minimum": 0, "maximum": 90 };
    /// Width of a disk of the sky in degrees; 0 for none.
    DiskAngle, disk_angle, { "minimum": 0, "maximum": 180, "not": { "exclusiveMinimum": 0, "exclusiveMaximum": 0.01 } };
    /// Latitude on the earth in degrees.
    Latitude, latitude, { "minimum": -90, "maximum": 90 };
    /// Longitude on the earth in degrees.
    Longitude, longitude, { "minimum": -180, "maximum": 180 };
    /// Haziness of the air, as the models of the sky have it.
    Turbidity, turbidity, { "minimum": 1, "maximum": 10 };
    /// Focal length in pixels.
    FocalLength, focal_length, { "minimum": 0.001, "maximum": 1e9 };
    /// Place along one side of a picture, in pixels.
    PixelPlace, pixel_place, { "minimum": -1e9, "maximum": 1e9 };
}

/// A whole number from `MIN` to `MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "i128")]
pub(crate) struct Whole<const MIN: i64, const MAX: i64>(pub(crate) i64);

impl<const MIN: i64, const MAX: i64> TryFrom<i128> for Whole<MIN, MAX> {
    type Error = Rule;

    fn try_from(x: i128) -> Result<Self, Rule> {
        let must = format!("must be at least {MIN} and at most {MAX}");
        match i64::try_from(x) {
            Ok(x) if (MIN..=MAX).contains(&x) => Ok(Self(x)),
            _ => Err(Rule { must, advice: "" }),
        }
    }
}

impl<const MIN: i64, const MAX: i64> JsonSchema for Whole<MIN, MAX> {
    fn schema_name() -> Cow<'static, str> {
        format!("Whole{MIN}To{MAX}").into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "integer", "minimum": MIN, "maximum": MAX })
    }
}

/// The version of the format: 1 is the only one so far.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(try_from = "i128")]
pub(crate) struct Version(i64);

impl TryFrom<i128> for Version {
    type Error = Rule;

    fn try_from(x: i128) -> Result<Self, Rule> {
        let must = "must be 1";
        let advice = "this program reads scene files of version 1 only";
        require(x == 1, must, advice).map(|()| Self(1))
    }
}

impl JsonSchema for Version {
    fn schema_name() -> Cow<'static, str> {
        "Version".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "const": 1 })
    }
}
