//! A glTF document as it is written, with the extensions that are understood.
//!
//! References between its parts are plain numbers, which [`super::validate`] checks all at once.

mod code;
pub(super) mod data;
pub(super) mod material;

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer};

pub(super) use data::{Accessor, Buffer, BufferView};
pub(super) use material::{Image, Material, Sampler, Texture};

/// Attributes by their names, as indices of accessors.
pub(super) type Attributes = BTreeMap<String, usize>;

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Document {
    pub asset: Option<AssetInfo>,
    pub accessors: Vec<Accessor>,
    pub animations: Vec<Animation>,
    pub buffers: Vec<Buffer>,
    pub buffer_views: Vec<BufferView>,
    pub cameras: Vec<Camera>,
    pub images: Vec<Image>,
    pub materials: Vec<Material>,
    pub meshes: Vec<Mesh>,
    pub nodes: Vec<Node>,
    pub samplers: Vec<Sampler>,
    pub scene: Option<usize>,
    pub scenes: Vec<Scene>,
    pub skins: Vec<Skin>,
    pub textures: Vec<Texture>,
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
    pub extensions: DocumentExtensions,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct AssetInfo {
    pub version: String,
    pub min_version: Option<String>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub lights: Lights,
    #[serde(rename = "KHR_materials_variants")]
    pub variants: Variants,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Lights {
    pub lights: Vec<Light>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Variants {
    pub variants: Vec<Variant>,
}

#[derive(Deserialize)]
pub(super) struct Variant {
    pub name: String,
}

#[derive(Deserialize)]
pub(super) struct Light {
    #[serde(default)]
    pub name: String,
    #[serde(rename = "type")]
    pub kind: LightType,
    pub color: Option<[f32; 3]>,
    pub intensity: Option<f32>,
    pub range: Option<f32>,
    #[serde(default)]
    pub spot: Spot,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(super) enum LightType {
    Directional,
    Point,
    Spot,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Spot {
    pub inner_cone_angle: Option<f32>,
    pub outer_cone_angle: Option<f32>,
}

#[derive(Deserialize)]
pub(super) struct Camera {
    #[serde(default)]
    pub name: String,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "camelCase")]
pub(super) struct Perspective {
    pub yfov: f32,
    pub aspect_ratio: Option<f32>,
}

#[derive(Deserialize, Clone, Copy)]
pub(super) struct Orthographic {
    pub xmag: f32,
    pub ymag: f32,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Scene {
    pub nodes: Vec<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct Node {
    pub name: String,
    pub children: Vec<usize>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub camera: Option<usize>,
    pub matrix: Option<Box<[f64; 16]>>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub weights: Option<Vec<f32>>,
    pub extensions: Option<Box<NodeExtensions>>,
}

#[derive(Deserialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
}

#[derive(Deserialize)]
pub(super) struct NodeLight {
    pub light: usize,
}

#[derive(Deserialize)]
pub(super) struct Instancing {
    pub attributes: Attributes,
}

#[derive(Deserialize)]
pub(super) struct Visibility {
    pub visible: Option<bool>,
}

impl Node {
    pub(super) fn light(&self) -> Option<usize> {
        self.extensions.as_ref()?.light.as_ref().map(|light| light.light)
    }

    pub(super) fn instancing(&self) -> Option<&Attributes> {
        self.extensions.as_ref()?.instancing.as_ref().map(|instancing| &instancing.attributes)
    }

    pub(super) fn is_hidden(&self) -> bool {
        let visibility = self.extensions.as_ref().and_then(|extensions| extensions.visibility.as_ref());
        visibility.is_some_and(|visibility| visibility.visible == Some(false))
    }
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    #[serde(default)]
    pub name: String,
    pub primitives: Vec<Primitive>,
    pub weights: Option<Vec<f32>>,
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    #[serde(default)]
    pub mode: Mode,
    #[serde(default)]
    pub targets: Vec<Attributes>,
    #[serde(default)]
    pub extensions: PrimitiveExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Draco>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Draco {
    pub buffer_view: usize,
    /// Attributes by Draco's own numbers, which it calls unique ids.
    pub attributes: BTreeMap<String, u32>,
}

/// Figures that a primitive's vertices make up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Mode {
    PointsOrLines,
    #[default]
    Triangles,
    Strip,
    Fan,
}

impl TryFrom<u32> for Mode {
    type Error = String;

    fn try_from(mode: u32) -> Result<Self, String> {
        match mode {
            0..=3 => Ok(Self::PointsOrLines),
            4 => Ok(Self::Triangles),
            5 => Ok(Self::Strip),
            6 => Ok(Self::Fan),
            _ => Err(format!("the mode is {mode}: it should be 0 to 6")),
        }
    }
}

impl<'de> Deserialize<'de> for Mode {
    fn deserialize<D: Deserializer<'de>>(reader: D) -> Result<Self, D::Error> {
        code::read(reader)
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    pub inverse_bind_matrices: Option<usize>,
    pub joints: Vec<usize>,
}

#[derive(Deserialize)]
pub(super) struct Animation {
    #[serde(default)]
    pub name: String,
    pub channels: Vec<Channel>,
    pub samplers: Vec<AnimationSampler>,
}

#[derive(Deserialize)]
pub(super) struct Channel {
    pub sampler: usize,
    pub target: Target,
}

#[derive(Deserialize)]
pub(super) struct Target {
    pub node: Option<usize>,
    pub path: Path,
}

#[derive(Deserialize, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[serde(rename_all = "lowercase")]
pub(super) enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
    /// Target of KHR_animation_pointer.
    Pointer,
}

#[derive(Deserialize)]
pub(super) struct AnimationSampler {
    pub input: usize,
    pub output: usize,
    #[serde(default)]
    pub interpolation: Interpolation,
}

#[derive(Deserialize, Clone, Copy, Debug, Default, PartialEq)]
#[serde(rename_all = "UPPERCASE")]
pub(super) enum Interpolation {
    #[default]
    Linear,
    Step,
    CubicSpline,
}
