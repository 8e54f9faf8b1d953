//! Keyframes of the camera.

use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::Point;
use crate::number::{FieldOfView, NonNegative, Positive};

/// Camera at one moment. A key that it does not have follows the keyframes that have it, and the camera's own where none has.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Keyframe")]
pub(crate) struct KeyframeFile {
    /// Moment of the keyframe in seconds, later than that of the one before.
    pub time: NonNegative,
    /// Position of the camera.
    pub position: Option<Point>,
    /// The point in the middle of the picture.
    pub look_at: Option<Point>,
    /// The direction that points up in the picture, whatever its length.
    pub up: Option<Point>,
    /// Angle between the picture's top and bottom edges, greater than 0 and less than 180.
    pub vertical_fov_degrees: Option<FieldOfView>,
    /// Height of the picture in the scene's units, for an orthographic camera.
    pub orthographic_height: Option<Positive>,
    /// Radius of the lens.
    pub aperture_radius: Option<NonNegative>,
    /// Distance of the plane in focus.
    pub focus_distance: Option<Positive>,
}

/// Keyframes in the order of the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Keyframes(pub Vec<KeyframeFile>);

impl Keyframes {
    /// Name of the list, as its tables are written.
    pub const NAME: &'static str = "camera.keyframes";
}

impl<'de> Deserialize<'de> for Keyframes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple_struct(Self::NAME, 0, KeyframesVisitor)
    }
}

struct KeyframesVisitor;

impl<'de> Visitor<'de> for KeyframesVisitor {
    type Value = Keyframes;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Keyframes, A::Error> {
        let mut keyframes = Vec::with_capacity(list.size_hint().unwrap_or_default());
        while let Some(keyframe) = list.next_element()? {
            keyframes.push(keyframe);
        }
        Ok(Keyframes(keyframes))
    }
}

impl JsonSchema for Keyframes {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Keyframes".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        <Vec<KeyframeFile>>::json_schema(generator)
    }
}
