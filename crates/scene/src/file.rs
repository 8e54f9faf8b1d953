//! Types that mirror the scene file: serde fills them, and the schema is generated from them.
//!
//! Doc comments of these types are the descriptions in the schema, so they speak to whoever writes a scene.

mod color;
mod keyframes;
mod lights;
mod medium;
mod principled;
mod time;

use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};

use crate::curve::Interpolation;
use crate::named::Named;
use crate::number::{
    Brightness, Coordinate, FieldOfView, FocalLength, Fraction, Latitude, Longitude, NonNegative, PixelPlace, Positive,
    Reflectance, RefractiveIndex, Turbidity, Version, Whole,
};
use crate::scene::{Filter, Panorama, RenderSettings, Sampler};

pub(crate) use color::{COLOR, Color};
pub(crate) use keyframes::{KeyframeFile, Keyframes};
pub(crate) use lights::{DirectionalFile, LightFile, Lights, PointFile, SpotFile};
pub(crate) use medium::{CoefficientFile, MediumFile};
pub(crate) use principled::{
    AlphaModeFile, PrincipledFile, TextureFile, TextureFilterFile, TextureTable, WrapFile, WrapName,
};
pub(crate) use time::Time;

/// A point or a direction: x, y and z.
pub(crate) type Point = [Coordinate; 3];
/// Red, green and blue, 0 or more.
pub(crate) type Radiance = Color<Brightness>;
/// Red, green and blue, 0 to 1.
pub(crate) type SurfaceColor = Color<Fraction>;
/// Rank among overlapping dielectrics: the highest wins.
pub(crate) type Priority = Whole<-2147483648, 2147483647>;

/// A scene for raggio, a progressive path tracer. Lengths are in any one unit, angles in degrees,
/// colours in linear red, green and blue; y points up unless the camera says otherwise.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "raggio scene")]
pub(crate) struct SceneFile {
    /// Version of the format.
    #[allow(dead_code, reason = "reading it is checking it")]
    pub version: Version,
    /// Size and quality of the picture; the command line overrides it.
    #[serde(default)]
    pub render: RenderFile,
    /// Camera that takes the picture.
    pub camera: CameraFile,
    /// Light from outside; absent: black.
    pub environment: Option<EnvironmentFile>,
    /// Medium that fills the scene around all bodies, such as fog; absent: none.
    pub air: Option<MediumFile>,
    /// Lights that are no surfaces, in any order.
    #[serde(default)]
    pub lights: Lights,
    /// Materials by name.
    #[serde(default)]
    pub materials: Materials,
    /// Groups of shapes by name, which are seen where a shape names them.
    #[serde(default)]
    pub groups: Groups,
    /// Shapes that there are to see, in any order.
    #[serde(default)]
    pub shapes: Shapes,
}

/// Size and quality of the picture; the command line overrides it.
#[derive(Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "Render")]
pub(crate) struct RenderFile {
    /// Width of the picture in pixels.
    pub width: Whole<1, 65536>,
    /// Height of the picture in pixels.
    pub height: Whole<1, 65536>,
    /// Number of samples of each pixel.
    pub samples: Whole<1, 2147483647>,
    /// Most rays along one path, the camera's ray included; a shadow ray counts as the ray it replaces. 0 sets no limit.
    pub max_depth: Whole<0, 65535>,
    /// Seed of the random numbers: the same seed gives the same picture.
    pub seed: Whole<0, 4294967295>,
    /// Source of the random numbers.
    pub sampler: Named<Sampler>,
    /// Weights with which the picture around a pixel's centre makes its value.
    pub filter: Named<Filter>,
    /// The largest channel of a sample that counts: what exceeds it is taken off, which loses light and fireflies. Absent: nothing is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clamp: Option<Positive>,
    /// Whether the picture has an alpha channel: the background is left out where the camera sees it directly, but still lights the scene, and is seen in mirrors and through glass.
    pub alpha: bool,
    /// Whether rays start slightly off the surface they leave. Without it surfaces shadow themselves in rings; only for teaching.
    pub surface_offset: bool,
}

/// Camera that takes the picture: its position and direction, and one of `vertical_fov_degrees`, `intrinsics`,
/// `orthographic_height` and `panorama`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    { "required": ["vertical_fov_degrees"] }, { "required": ["intrinsics"] }, { "required": ["orthographic_height"] },
    { "required": ["panorama"] }
]), extend("if" = { "required": ["panorama"] }, "then" = {
    "properties": { "aperture_radius": { "const": 0 } }, "not": { "required": ["focus_distance"] }
}), extend("dependentRequired" = { "interpolation": ["keyframes"] }))]
#[schemars(rename = "Camera")]
pub(crate) struct CameraFile {
    /// Position of the camera.
    pub position: Point,
    /// The point in the middle of the picture, or at the principal point of `intrinsics`.
    pub look_at: Point,
    /// The direction that points up in the picture; neither zero nor parallel to the viewing direction.
    #[serde(default = "y_axis")]
    pub up: Point,
    /// Angle between the picture's top and bottom edges, greater than 0 and less than 180.
    pub vertical_fov_degrees: Option<FieldOfView>,
    /// Intrinsics of a camera that was measured, in place of the angle.
    pub intrinsics: Option<IntrinsicsFile>,
    /// Height of the picture in the scene's units, for an orthographic camera, whose rays are all parallel.
    pub orthographic_height: Option<Positive>,
    /// Layout of a picture of all directions around the camera.
    pub panorama: Option<Named<Panorama>>,
    /// Radius of the lens: 0 keeps everything sharp, more blurs what is out of focus.
    #[serde(default = "zero")]
    pub aperture_radius: NonNegative,
    /// Distance of the plane in focus; default: the distance from `position` to `look_at`.
    pub focus_distance: Option<Positive>,
    /// Keyframes of a camera that moves, in the order of their times.
    #[serde(default)]
    pub keyframes: Keyframes,
    /// Way from one keyframe to the next; needs `keyframes`.
    #[schemars(extend("default" = "smooth"))]
    pub interpolation: Option<Named<Interpolation>>,
}

/// Intrinsics of a pinhole camera, in pixels of a picture of `size`: x / z and y / z of a point to the right, down and
/// forward of the camera become focal[0] x/z + skew y/z + principal_point[0] and focal[1] y/z + principal_point[1].
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Intrinsics")]
pub(crate) struct IntrinsicsFile {
    /// Focal lengths across and down, fx and fy.
    pub focal: [FocalLength; 2],
    /// Point of the picture that lies straight ahead, cx and cy, counted from the top left corner of the picture; where whole numbers are the middles of pixels, add 0.5 to both. Absent: the middle.
    pub principal_point: Option<[PixelPlace; 2]>,
    /// Skew, 0 where pixels are rectangles.
    #[serde(default = "straight")]
    pub skew: PixelPlace,
    /// Width and height of the picture that the other numbers are of. A picture of another height has them in proportion.
    pub size: [Whole<1, 65536>; 2],
}

/// Light from outside: `color`, or `horizon` and `zenith`, or `image`, or the sky by day, by `sun_direction` or by
/// `latitude_degrees`, `longitude_degrees` and `time`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [
    { "required": ["color"] }, { "required": ["horizon", "zenith"] }, { "required": ["image"] },
    { "required": ["sun_direction"] }, { "required": ["latitude_degrees", "longitude_degrees", "time"] }
]), extend("dependentRequired" = {
    "horizon": ["zenith"], "zenith": ["horizon"], "latitude_degrees": ["time"], "longitude_degrees": ["time"]
}), extend("dependentSchemas" = dependent(&[
    ("rotation_degrees", &["image", "sun_direction", "time"]), ("intensity", &["image", "sun_direction", "time"]),
    ("turbidity", &["sun_direction", "time"]), ("ground_albedo", &["sun_direction", "time"]),
    ("sun_intensity", &["sun_direction", "time"]),
])))]
#[schemars(rename = "Environment")]
pub(crate) struct EnvironmentFile {
    /// Radiance that comes from everywhere alike.
    pub color: Option<Radiance>,
    /// Radiance from straight below; needs `zenith`. A ray of unit direction D sees mix(horizon, zenith, 0.5 (D.y + 1)).
    pub horizon: Option<Radiance>,
    /// Radiance from straight above; needs `horizon`.
    pub zenith: Option<Radiance>,
    /// Latitude-longitude image (HDR, EXR, PNG, JPEG, WebP, KTX2), its path relative to the scene file; its centre is seen along -Z, its right along +X, its top along +Y.
    pub image: Option<String>,
    /// Direction toward the sun, of any length but 0 and not below the horizon, which makes a sky by day: up is +Y.
    pub sun_direction: Option<Point>,
    /// Latitude of the place whose sky is seen, north of the equator positive; needs `longitude_degrees` and `time`. North is along -Z, east along +X.
    pub latitude_degrees: Option<Latitude>,
    /// Longitude of the place, east of Greenwich positive; needs `latitude_degrees` and `time`.
    pub longitude_degrees: Option<Longitude>,
    /// Date and time at which the sky is seen, with the clock's offset from universal time: `2026-06-21T17:30:00+02:00`; needs `latitude_degrees` and `longitude_degrees`.
    pub time: Option<Time>,
    /// Haziness of the air, from 1, pure, over 3, a clear day, to 10, hazy; needs a sky by day.
    #[schemars(extend("default" = 3.0))]
    pub turbidity: Option<Turbidity>,
    /// Part of the light that the ground reflects, which brightens the sky and is seen below the horizon; needs a sky by day.
    #[schemars(extend("default" = [0.2, 0.2, 0.2]))]
    pub ground_albedo: Option<Color<Reflectance>>,
    /// Factor that multiplies the light straight from the sun, 0 for a sun that is hidden; needs a sky by day.
    #[schemars(extend("default" = 1.0))]
    pub sun_intensity: Option<Brightness>,
    /// Angle by which the image, or the sky with its sun, is turned about the y axis, counter-clockwise seen from above; needs either.
    #[schemars(extend("default" = 0.0))]
    pub rotation_degrees: Option<Coordinate>,
    /// Factor that multiplies the image, or the light of sky and sun; needs either.
    #[schemars(extend("default" = 1.0))]
    pub intensity: Option<Brightness>,
}

impl EnvironmentFile {
    /// Keys that are given, in the order of the fields.
    pub fn given(&self) -> Vec<&'static str> {
        let keys = [
            ("color", self.color.is_some()),
            ("horizon", self.horizon.is_some()),
            ("zenith", self.zenith.is_some()),
            ("image", self.image.is_some()),
            ("sun_direction", self.sun_direction.is_some()),
            ("latitude_degrees", self.latitude_degrees.is_some()),
            ("longitude_degrees", self.longitude_degrees.is_some()),
            ("time", self.time.is_some()),
            ("turbidity", self.turbidity.is_some()),
            ("ground_albedo", self.ground_albedo.is_some()),
            ("sun_intensity", self.sun_intensity.is_some()),
            ("rotation_degrees", self.rotation_degrees.is_some()),
            ("intensity", self.intensity.is_some()),
        ];
        keys.into_iter().filter_map(|(key, is_given)| is_given.then_some(key)).collect()
    }
}

/// Keys that are of use beside one of others alone.
fn dependent(keys: &[(&str, &[&str])]) -> Value {
    let rule = |(key, beside): &(&str, &[&str])| {
        let any: Vec<_> = beside.iter().map(|key| json!({ "required": [key] })).collect();
        ((*key).to_owned(), json!({ "anyOf": any }))
    };
    Value::Object(keys.iter().map(rule).collect())
}

/// Way in which a surface reflects, transmits and emits light: `principled`, or any of the other keys; and what a body is
/// filled with. A body of a `medium` alone has no surface.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("if" = { "required": ["principled"] }, "then" = {
    "propertyNames": { "enum": ["principled", "medium"] }
}, "else" = { "if": { "required": ["medium"], "not": { "required": ["refractive_index"] } }, "then": {
    "propertyNames": { "enum": ["medium", "priority"] }
} }))]
#[schemars(rename = "Material")]
pub(crate) struct MaterialFile {
    /// Part of the light that is reflected, or transmitted; [0, 0, 0] by default when `emission_strength` is greater than 0.
    #[schemars(extend("default" = [0.8, 0.8, 0.8]))]
    pub color: Option<Color<Reflectance>>,
    /// Colour of the emitted light.
    #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
    pub emission_color: Option<Radiance>,
    /// Strength of the emitted light: multiplied by `emission_color` it is the emitted radiance.
    #[schemars(extend("default" = 0.0))]
    pub emission_strength: Option<Brightness>,
    /// Smoothness from 0, diffuse, to 1, a mirror; a dielectric ignores it.
    #[schemars(extend("default" = 0.0))]
    pub smoothness: Option<Fraction>,
    /// Refractive index, which makes the material a dielectric, such as glass (1.5) or water (1.33); absent: opaque.
    pub refractive_index: Option<RefractiveIndex>,
    /// Probability that a dielectric reflects: "fresnel", or one number for every angle.
    #[schemars(extend("default" = "fresnel"))]
    pub reflection: Option<ReflectionFile>,
    /// Priority among overlapping dielectrics: the higher one wins, and of equal ones the one entered last.
    #[schemars(extend("default" = 0))]
    pub priority: Option<Priority>,
    /// Medium that fills a body of the material, which refracts light by its `refractive_index`, or transmits it as `principled`; without either the body has no surface, as fog and smoke have none.
    pub medium: Option<MediumFile>,
    /// A physically based material with glTF's names and meanings; no other key may stand beside it but `medium`.
    pub principled: Option<PrincipledFile>,
}

/// Probability that a dielectric reflects: "fresnel", or a number.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "must be `\"fresnel\"` or a probability between 0 and 1")]
#[schemars(rename = "Reflection")]
pub(crate) enum ReflectionFile {
    /// Probability by Fresnel's equations.
    Named(ReflectionName),
    /// Probability that is the same at every angle.
    Probability(Fraction),
}

/// The reflections that have a name.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ReflectionName {
    /// Probability by Fresnel's equations.
    Fresnel,
}

/// A material's name and one geometry.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = shape_alternatives()))]
#[schemars(rename = "Shape")]
pub(crate) struct ShapeFile {
    /// Name of one of the materials; only a group, and a mesh whose file has materials, may go without: then their own are seen.
    pub material: Option<String>,
    /// A sphere.
    pub sphere: Option<SphereFile>,
    /// An endless plane.
    pub plane: Option<PlaneFile>,
    /// A rectangle; both sides reflect and emit.
    pub rectangle: Option<RectangleFile>,
    /// A disk; both sides reflect and emit.
    pub disk: Option<DiskFile>,
    /// A cylinder, open or closed.
    pub cylinder: Option<CylinderFile>,
    /// A cone, open or closed, which may be cut off.
    pub cone: Option<ConeFile>,
    /// A box, which may be turned.
    #[serde(rename = "box")]
    pub cuboid: Option<BoxFile>,
    /// Triangles from a file. Without `material` it has the file's own materials.
    pub mesh: Option<MeshFile>,
    /// Name of a group, all of whose shapes are seen. With `material` all are made of that.
    pub group: Option<String>,
    /// Transform of the shape, or of all of the group. Absent: it stays where it is.
    pub transform: Option<TransformFile>,
}

impl ShapeFile {
    /// Keys of all geometries, each with whether the shape has it.
    pub fn geometries(&self) -> impl Iterator<Item = (&'static str, bool)> {
        let geometries = [
            ("sphere", self.sphere.is_some()),
            ("plane", self.plane.is_some()),
            ("rectangle", self.rectangle.is_some()),
            ("disk", self.disk.is_some()),
            ("cylinder", self.cylinder.is_some()),
            ("cone", self.cone.is_some()),
            ("box", self.cuboid.is_some()),
            ("mesh", self.mesh.is_some()),
            ("group", self.group.is_some()),
        ];
        geometries.into_iter()
    }
}

/// Keys that a shape must have, in each of the ways to write one.
fn shape_alternatives() -> Vec<Value> {
    let required = |key| if matches!(key, "mesh" | "group") { json!([key]) } else { json!(["material", key]) };
    let empty = ShapeFile::default();
    empty.geometries().map(|(key, _)| json!({ "required": required(key) })).collect()
}

/// A sphere.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Sphere")]
pub(crate) struct SphereFile {
    /// Centre of the sphere.
    pub center: Point,
    /// Radius of the sphere, greater than 0.
    pub radius: Positive,
}

/// An endless plane.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Plane")]
pub(crate) struct PlaneFile {
    /// Any point of the plane.
    pub point: Point,
    /// Normal of the plane, of any length but 0.
    pub normal: Point,
}

/// A rectangle; both sides reflect and emit.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Rectangle")]
pub(crate) struct RectangleFile {
    /// One corner of the rectangle.
    pub corner: Point,
    /// Edge from that corner along one side.
    pub edge_u: Point,
    /// Edge from that corner along the other side, at a right angle to `edge_u`.
    pub edge_v: Point,
}

/// A disk; both sides reflect and emit.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Disk")]
pub(crate) struct DiskFile {
    /// Centre of the disk.
    pub center: Point,
    /// Normal of the disk, of any length but 0.
    pub normal: Point,
    /// Radius of the disk, greater than 0.
    pub radius: Positive,
}

/// A cylinder. Open, both its sides reflect and emit.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Cylinder")]
pub(crate) struct CylinderFile {
    /// Centre of one end.
    pub base: Point,
    /// Centre of the other end.
    pub top: Point,
    /// Radius of the cylinder, greater than 0.
    pub radius: Positive,
    /// Whether disks close both ends.
    #[serde(default = "yes")]
    pub capped: bool,
}

/// A cone, which may be cut off. Open, both its sides reflect and emit.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Cone")]
pub(crate) struct ConeFile {
    /// Centre of the wide end.
    pub base: Point,
    /// The apex, or the centre of the end where it is cut off.
    pub top: Point,
    /// Radius at `base`, greater than 0.
    pub radius: Positive,
    /// Radius at `top`, where the cone is cut off; 0 for an apex.
    #[serde(default = "zero")]
    pub top_radius: NonNegative,
    /// Whether disks close both ends.
    #[serde(default = "yes")]
    pub capped: bool,
}

/// A box, which may be turned.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Box")]
pub(crate) struct BoxFile {
    /// Centre of the box, about which it turns.
    pub center: Point,
    /// Lengths of the box's sides along x, y and z, before it is turned.
    pub size: [Positive; 3],
    /// Angles by which the box is turned, about the fixed x axis first, then y, then z.
    #[serde(default = "origin")]
    pub rotation_degrees: Point,
}

/// Everything that a model file shows: p becomes translation + rotation * scale * p.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Mesh")]
pub(crate) struct MeshFile {
    /// Path of a .gltf, .glb, .ply, .obj or .stl file, relative to the scene file.
    pub file: String,
    /// Translation of the model, applied last.
    #[serde(default = "origin")]
    pub translation: Point,
    /// Angles by which the model is turned, about the fixed x axis first, then y, then z.
    #[serde(default = "origin")]
    pub rotation_degrees: Point,
    /// One factor, or one for each of x, y and z; not 0, negative ones mirror.
    #[schemars(extend("default" = 1.0))]
    pub scale: Option<ScaleFile>,
    /// Moment of the file's animations, in seconds from their beginning; absent: the pose of rest.
    pub time: Option<NonNegative>,
}

/// Transform of a shape or of a group: p becomes translation + rotation * scale * p.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Transform")]
pub(crate) struct TransformFile {
    /// Translation, applied last.
    #[serde(default = "origin")]
    pub translation: Point,
    /// Angles by which the shape is turned, about the fixed x axis first, then y, then z.
    #[serde(default = "origin")]
    pub rotation_degrees: Point,
    /// One factor, greater than 0; where there is nothing but meshes also one for each of x, y and z, and negative ones, which mirror.
    #[schemars(extend("default" = 1.0))]
    pub scale: Option<ScaleFile>,
}

/// One factor, or one for each of x, y and z.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "must be a number or three numbers")]
#[schemars(rename = "Scale")]
pub(crate) enum ScaleFile {
    /// Factor that is the same along every axis.
    Uniform(Coordinate),
    /// Factors along x, y and z.
    PerAxis(Point),
}

/// Materials in the order of the file, with their names.
#[derive(Debug, Default)]
pub(crate) struct Materials(pub Vec<(String, MaterialFile)>);

impl<'de> Deserialize<'de> for Materials {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(MaterialsVisitor)
    }
}

struct MaterialsVisitor;

impl<'de> Visitor<'de> for MaterialsVisitor {
    type Value = Materials;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Materials, A::Error> {
        let mut materials = Vec::new();
        while let Some(name) = map.next_key()? {
            // What is wrong with a material has been noted by the reader, which goes on.
            if let Ok(material) = map.next_value() {
                materials.push((name, material));
            }
        }
        Ok(Materials(materials))
    }
}

impl JsonSchema for Materials {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Materials".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        <std::collections::BTreeMap<String, MaterialFile>>::json_schema(generator)
    }
}

/// Shapes in the order of the file.
#[derive(Debug, Default)]
pub(crate) struct Shapes(pub Vec<ShapeFile>);

impl Shapes {
    /// Name of the list, as its tables are written.
    pub const NAME: &'static str = "shapes";
}

impl<'de> Deserialize<'de> for Shapes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple_struct(Self::NAME, 0, ShapesVisitor)
    }
}

struct ShapesVisitor;

impl<'de> Visitor<'de> for ShapesVisitor {
    type Value = Shapes;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Shapes, A::Error> {
        let mut shapes = Vec::with_capacity(list.size_hint().unwrap_or_default());
        loop {
            match list.next_element() {
                Ok(Some(shape)) => shapes.push(shape),
                Ok(None) => return Ok(Shapes(shapes)),
                // What is wrong with a shape has been noted by the reader, which goes on.
                Err(_) => {}
            }
        }
    }
}

impl JsonSchema for Shapes {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Shapes".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        <Vec<ShapeFile>>::json_schema(generator)
    }
}

/// Groups of shapes in the order of the file, with their names.
#[derive(Debug, Default)]
pub(crate) struct Groups(pub Vec<(String, Group)>);

impl<'de> Deserialize<'de> for Groups {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // A table of any keys, whose faults are not noted one by one as those of materials are.
        deserializer.deserialize_struct("groups", &[], GroupsVisitor)
    }
}

struct GroupsVisitor;

impl<'de> Visitor<'de> for GroupsVisitor {
    type Value = Groups;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Groups, A::Error> {
        let mut groups = Vec::new();
        while let Some(group) = map.next_entry()? {
            groups.push(group);
        }
        Ok(Groups(groups))
    }
}

impl JsonSchema for Groups {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Groups".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        <std::collections::BTreeMap<String, Vec<ShapeFile>>>::json_schema(generator)
    }
}

/// Shapes of a group in the order of the file.
#[derive(Debug, Default)]
pub(crate) struct Group(pub Vec<ShapeFile>);

impl<'de> Deserialize<'de> for Group {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple_struct("groups.NAME", 0, GroupVisitor)
    }
}

struct GroupVisitor;

impl<'de> Visitor<'de> for GroupVisitor {
    type Value = Group;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Group, A::Error> {
        let mut shapes = Vec::with_capacity(list.size_hint().unwrap_or_default());
        while let Some(shape) = list.next_element()? {
            shapes.push(shape);
        }
        Ok(Group(shapes))
    }
}

impl Default for RenderFile {
    fn default() -> Self {
        let RenderSettings { width, height, samples, max_depth, seed, sampler, filter, alpha, surface_offset, .. } =
            RenderSettings::default();
        Self {
            width: Whole(width.into()),
            height: Whole(height.into()),
            samples: Whole(samples.into()),
            max_depth: Whole(max_depth.into()),
            seed: Whole(seed.into()),
            sampler: Named(sampler),
            filter: Named(filter),
            clamp: None,
            alpha,
            surface_offset,
        }
    }
}

fn origin() -> Point {
    [Coordinate(0.0); 3]
}

fn y_axis() -> Point {
    [Coordinate(0.0), Coordinate(1.0), Coordinate(0.0)]
}

fn yes() -> bool {
    true
}

fn zero() -> NonNegative {
    NonNegative(0.0)
}

fn straight() -> PixelPlace {
    PixelPlace(0.0)
}
