//! Contents of a model file, whatever its format.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::inside::Named;
use crate::material::Principled;
use crate::mesh::Mesh;

/// A model at one moment: animations, skins and morph targets have been applied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The different meshes.
    pub meshes: Vec<Arc<Mesh>>,
    /// Placed meshes; a mesh without an instance is not seen.
    pub instances: Vec<Instance>,
    /// Materials that [`Part::material`](crate::Part::material) indexes.
    pub materials: Vec<Material>,
    /// Lights that are no surfaces.
    pub lights: Vec<Light>,
    /// Animations of the file; one without any is equal at every time.
    pub animations: Vec<Animation>,
    /// Viewpoints of the file, in the order of the nodes that place them.
    pub cameras: Vec<Camera>,
    /// Paths, without links, of the files that the model's own names and that were opened: buffers, images, material
    /// libraries. Each is there once.
    pub files: Vec<PathBuf>,
    /// Paths at which files that the model's own names were looked for in vain: it may be another once they are there.
    pub missing: Vec<PathBuf>,
    /// Warnings for the user, one sentence each, without the file's name.
    pub warnings: Vec<String>,
}

impl Model {
    /// The model, with the files that were asked for while it was read.
    pub(crate) fn naming(self, named: &Named) -> Self {
        let [files, missing] = [&named.found, &named.missing].map(|paths| paths.iter().cloned().collect());
        Self { files, missing, ..self }
    }
}

/// An animation, and when something moves in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// Name that the file gives it; may be empty.
    pub name: String,
    /// Moments of its first and its last keyframe, in seconds: before and after these everything rests.
    pub seconds: [f64; 2],
}

/// A placed mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Name of the node; may be empty.
    pub name: Arc<str>,
    /// Index into [`Model::meshes`].
    pub mesh: usize,
    /// Transform of the mesh, which may turn, stretch, shear and mirror.
    pub model_from_mesh: DAffine3,
}

/// A material with the name that the file gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name of the material; may be empty.
    pub name: String,
    /// Surface with glTF's meaning; other formats are translated.
    pub surface: Principled,
}

/// A light that is no surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name of the light; may be empty.
    pub name: String,
    /// Colour times intensity: radiant intensity (W/sr per channel; glTF's candela taken as such) of points and spots,
    /// irradiance (glTF's lux) of directional lights and suns, on a surface that faces them.
    pub intensity: [f32; 3],
    /// Position of the light; without meaning for directional lights and suns.
    pub position: DVec3,
    /// Unit direction in which the light shines; without meaning for points.
    pub direction: DVec3,
    /// Kind of the light.
    pub kind: LightKind,
}

/// The kinds of lights that are no surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light from infinitely far away.
    Directional,
    /// Directional light of a disk of the sky, which is seen there. No file format of models has it.
    Sun {
        /// Angle in radians from the disk's middle to its rim, more than 0 and at most pi / 2.
        half_angle: f32,
    },
    /// Light that is equal in all directions.
    Point,
    /// A cone: full inside the inner angle, nothing outside the outer, as KHR_lights_punctual recommends between.
    Spot {
        /// Inner angle in radians from the axis.
        inner: f32,
        /// Outer angle in radians from the axis, at least `inner`, at most pi / 2; equal angles make a hard edge.
        outer: f32,
    },
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the camera; may be empty.
    pub name: String,
    /// Position of the eye.
    pub position: DVec3,
    /// Unit viewing direction.
    pub forward: DVec3,
    /// Unit vector upwards, at a right angle to `forward`.
    pub up: DVec3,
    /// Projection of what the camera sees onto its picture.
    pub projection: Projection,
}

impl Camera {
    /// Width of the picture over its height, if the file says it.
    pub fn aspect(&self) -> Option<f32> {
        match self.projection {
            Projection::Perspective { aspect, .. } => aspect,
            Projection::Orthographic { xmag, ymag } => Some(xmag / ymag),
        }
    }
}

/// The projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Rays meet in the eye.
    Perspective {
        /// Vertical field of view: radians between the picture's top and bottom edges.
        vertical_fov: f32,
        /// Width over height, if the file says it.
        aspect: Option<f32>,
    },
    /// Rays are parallel to the viewing direction.
    Orthographic {
        /// Half of the picture's width, in the world's units; positive.
        xmag: f32,
        /// Half of the picture's height, in the world's units; positive.
        ymag: f32,
    },
}
