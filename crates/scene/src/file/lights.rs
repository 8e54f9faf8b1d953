//! Lights that are no surfaces.

use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::{Value, json};

use super::{Point, Radiance};
use crate::number::{Brightness, ConeAngle, DiskAngle};

/// A light that is no surface: one of `point`, `spot` and `directional`.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = light_alternatives()))]
#[schemars(rename = "Light")]
pub(crate) struct LightFile {
    /// Light that shines from one point in all directions.
    pub point: Option<PointFile>,
    /// Light that shines from one point into a cone.
    pub spot: Option<SpotFile>,
    /// Parallel light from infinitely far away, or a sun.
    pub directional: Option<DirectionalFile>,
}

impl LightFile {
    /// Keys of all kinds, each with whether the light has it.
    pub fn kinds(&self) -> [(&'static str, bool); 3] {
        [("point", self.point.is_some()), ("spot", self.spot.is_some()), ("directional", self.directional.is_some())]
    }
}

/// Keys that a light must have, in each of the ways to write one.
fn light_alternatives() -> Vec<Value> {
    LightFile::default().kinds().map(|(key, _)| json!({ "required": [key] })).to_vec()
}

/// A light that shines from one point in all directions.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Point")]
pub(crate) struct PointFile {
    /// Position of the light.
    pub position: Point,
    /// Colour of the light.
    #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
    pub color: Option<Radiance>,
    /// Radiant intensity, which `color` multiplies: a surface at distance d that faces the light gets the irradiance `intensity` / d².
    #[schemars(extend("default" = 1.0))]
    pub intensity: Option<Brightness>,
}

/// A light that shines from one point into a cone.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Spot")]
pub(crate) struct SpotFile {
    /// Position of the light.
    pub position: Point,
    /// Direction of the cone's axis, of any length but 0.
    pub direction: Point,
    /// Angle from the axis within which all the light is seen.
    #[schemars(extend("default" = 0.0))]
    pub inner_degrees: Option<ConeAngle>,
    /// Angle from the axis beyond which none is, not less than `inner_degrees`; between them the light fades as in glTF.
    #[schemars(extend("default" = 45.0))]
    pub outer_degrees: Option<ConeAngle>,
    /// Colour of the light.
    #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
    pub color: Option<Radiance>,
    /// Radiant intensity within the inner angle, which `color` multiplies: a surface at distance d that faces the light gets the irradiance `intensity` / d².
    #[schemars(extend("default" = 1.0))]
    pub intensity: Option<Brightness>,
}

/// Parallel light from infinitely far away, or, with an angle, a sun: a disk of the sky.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Directional")]
pub(crate) struct DirectionalFile {
    /// Direction in which the light shines, of any length but 0.
    pub direction: Point,
    /// Angle that the sun's disk is wide, as seen from the scene; the one over the earth is 0.53 wide. 0 has sharp shadows, and is not seen itself.
    #[schemars(extend("default" = 0.0))]
    pub angle_degrees: Option<DiskAngle>,
    /// Colour of the light.
    #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
    pub color: Option<Radiance>,
    /// Irradiance of a surface that faces the light, which `color` multiplies, whatever the angle is.
    #[schemars(extend("default" = 1.0))]
    pub intensity: Option<Brightness>,
}

/// Lights in the order of the file.
#[derive(Debug, Default)]
pub(crate) struct Lights(pub Vec<LightFile>);

impl Lights {
    /// Name of the list, as its tables are written.
    const NAME: &'static str = "lights";
}

impl<'de> Deserialize<'de> for Lights {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple_struct(Self::NAME, 0, LightsVisitor)
    }
}

struct LightsVisitor;

impl<'de> Visitor<'de> for LightsVisitor {
    type Value = Lights;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Lights, A::Error> {
        let mut lights = Vec::with_capacity(list.size_hint().unwrap_or_default());
        while let Some(light) = list.next_element()? {
            lights.push(light);
        }
        Ok(Lights(lights))
    }
}

impl JsonSchema for Lights {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Lights".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        <Vec<LightFile>>::json_schema(generator)
    }
}
