//! What a model file holds, whatever its format.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::material::Principled;
use crate::mesh::Mesh;

/// A model at one moment: animations, skins and morph targets have been applied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The different meshes.
    pub meshes: Vec<Arc<Mesh>>,
    /// Where they stand; a mesh without an instance is not seen.
    pub instances: Vec<Instance>,
    /// What [`Part::material`](crate::Part::material) names.
    pub materials: Vec<Material>,
    /// Lights without size.
    pub lights: Vec<Light>,
    /// Viewpoints of the file.
    pub cameras: Vec<Camera>,
    /// What the user may want to know, one sentence each, without the file's name.
    pub warnings: Vec<String>,
}

/// A placed mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The node's name; may be empty.
    pub name: Arc<str>,
    /// Index into [`Model::meshes`].
    pub mesh: usize,
    /// May turn, stretch, shear and mirror.
    pub model_from_mesh: DAffine3,
}

/// A material with the name that the file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// May be empty.
    pub name: String,
    /// glTF's meaning; other formats are translated.
    pub surface: Principled,
}

/// A light without size.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// May be empty.
    pub name: String,
    /// Colour times intensity: radiant intensity (W/sr per channel; glTF's candela taken as such) of points and spots,
    /// irradiance (glTF's lux) of directional lights.
    pub intensity: [f32; 3],
    /// From where it shines; of no meaning for directional lights.
    pub position: DVec3,
    /// Unit; where it shines to. Of no meaning for points.
    pub direction: DVec3,
    /// Its kind.
    pub kind: LightKind,
}

/// The kinds of lights without size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light from infinitely far away.
    Directional,
    /// The same in all directions.
    Point,
    /// A cone: full inside the inner angle, nothing outside the outer, as KHR_lights_punctual recommends between.
    Spot {
        /// Radians from the axis.
        inner: f32,
        /// Radians from the axis, greater than `inner`, at most pi / 2.
        outer: f32,
    },
}

/// A perspective camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// May be empty.
    pub name: String,
    /// Where the eye is.
    pub position: DVec3,
    /// Unit.
    pub forward: DVec3,
    /// Unit, at a right angle to `forward`.
    pub up: DVec3,
    /// Radians between the picture's top and bottom edges.
    pub vertical_fov: f32,
    /// Width over height, if the file says it.
    pub aspect: Option<f32>,
}
