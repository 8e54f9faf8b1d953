//! The principled material and its textures, by glTF's names.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::{Priority, Radiance, SurfaceColor};
use crate::number::{Brightness, Coordinate, Fraction, Ior, NonNegative, Positive, Whole};

/// A physically based material with the meaning that glTF 2.0 and its KHR_materials extensions give to each name.
/// A texture multiplies the factor whose name it bears; where a texture is given, a factor that is 0 by default is 1.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Principled")]
pub(crate) struct PrincipledFile {
    /// Reflected colour of the diffuse part, or of a metal seen from the front.
    #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
    pub base_color: Option<SurfaceColor>,
    /// Red, green and blue (sRGB) times `base_color`, alpha times `alpha`.
    pub base_color_texture: Option<TextureFile>,
    /// Coverage, which `alpha_mode` puts to use.
    #[schemars(extend("default" = 1.0))]
    pub alpha: Option<Fraction>,
    /// Use of coverage: "opaque" ignores it, "mask" cuts away what is below `alpha_cutoff`, "blend" lets part of the light pass.
    #[schemars(extend("default" = "opaque"))]
    pub alpha_mode: Option<AlphaModeFile>,
    /// Coverage below which there is no surface; needs `alpha_mode = "mask"`.
    #[schemars(extend("default" = 0.5))]
    pub alpha_cutoff: Option<Fraction>,
    /// Metalness from 0, a dielectric, to 1, a metal.
    #[schemars(extend("default" = 0.0))]
    pub metallic: Option<Fraction>,
    /// Roughness from 0, smooth, to 1.
    #[schemars(extend("default" = 1.0))]
    pub roughness: Option<Fraction>,
    /// Green times `roughness`, blue times `metallic`.
    pub metallic_roughness_texture: Option<TextureFile>,
    /// Refractive index.
    #[schemars(extend("default" = 1.5))]
    pub ior: Option<Ior>,
    /// Strength of a dielectric's specular reflection.
    #[schemars(extend("default" = 1.0))]
    pub specular: Option<Fraction>,
    /// Alpha times `specular`.
    pub specular_texture: Option<TextureFile>,
    /// Colour of a dielectric's specular reflection seen from the front.
    #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
    pub specular_color: Option<Radiance>,
    /// Red, green and blue (sRGB) times `specular_color`.
    pub specular_color_texture: Option<TextureFile>,
    /// Part of the light that is refracted into the body instead of scattered diffusely.
    #[schemars(extend("default" = 0.0))]
    pub transmission: Option<Fraction>,
    /// Red times `transmission`.
    pub transmission_texture: Option<TextureFile>,
    /// Whether the surface is an infinitely thin sheet: what is transmitted is not bent, and there is no inside.
    #[schemars(extend("default" = false))]
    pub thin_walled: Option<bool>,
    /// Colour that is left of white light after `attenuation_distance` inside the body.
    #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
    pub attenuation_color: Option<SurfaceColor>,
    /// Distance after which `attenuation_color` is left; absent: nothing is absorbed.
    pub attenuation_distance: Option<Positive>,
    /// Dispersion, which is 20 over the Abbe number; 0 bends all colours alike.
    #[schemars(extend("default" = 0.0))]
    pub dispersion: Option<NonNegative>,
    /// Priority among overlapping dielectrics: the higher one wins, and of equal ones the one entered last.
    #[schemars(extend("default" = 0))]
    pub priority: Option<Priority>,
    /// Part of the diffuse light that leaves on the other side.
    #[schemars(extend("default" = 0.0))]
    pub diffuse_transmission: Option<Fraction>,
    /// Alpha times `diffuse_transmission`.
    pub diffuse_transmission_texture: Option<TextureFile>,
    /// Colour of the diffusely transmitted light.
    #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
    pub diffuse_transmission_color: Option<SurfaceColor>,
    /// Red, green and blue (sRGB) times `diffuse_transmission_color`.
    pub diffuse_transmission_color_texture: Option<TextureFile>,
    /// Strength of the clear coat.
    #[schemars(extend("default" = 0.0))]
    pub clearcoat: Option<Fraction>,
    /// Red times `clearcoat`.
    pub clearcoat_texture: Option<TextureFile>,
    /// Roughness of the clear coat from 0, smooth, to 1.
    #[schemars(extend("default" = 0.0))]
    pub clearcoat_roughness: Option<Fraction>,
    /// Green times `clearcoat_roughness`.
    pub clearcoat_roughness_texture: Option<TextureFile>,
    /// Normals of the coat in tangent space; without it the coat is as smooth as the geometry.
    pub clearcoat_normal_map: Option<TextureFile>,
    /// Factor that multiplies x and y of `clearcoat_normal_map`.
    #[schemars(extend("default" = 1.0))]
    pub clearcoat_normal_scale: Option<Coordinate>,
    /// Reflectance of the sheen at grazing angles; black is no sheen.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub sheen_color: Option<SurfaceColor>,
    /// Red, green and blue (sRGB) times `sheen_color`.
    pub sheen_color_texture: Option<TextureFile>,
    /// Roughness of the sheen from 0 to 1.
    #[schemars(extend("default" = 0.0))]
    pub sheen_roughness: Option<Fraction>,
    /// Alpha times `sheen_roughness`.
    pub sheen_roughness_texture: Option<TextureFile>,
    /// Strength with which highlights are stretched, from 0 to 1.
    #[schemars(extend("default" = 0.0))]
    pub anisotropy: Option<Fraction>,
    /// Degrees from the tangent to the direction in which highlights are stretched, counter-clockwise.
    #[schemars(extend("default" = 0.0))]
    pub anisotropy_rotation: Option<Coordinate>,
    /// Red and green a direction that `anisotropy_rotation` turns, blue times `anisotropy`.
    pub anisotropy_texture: Option<TextureFile>,
    /// Strength of the thin film.
    #[schemars(extend("default" = 0.0))]
    pub iridescence: Option<Fraction>,
    /// Red times `iridescence`.
    pub iridescence_texture: Option<TextureFile>,
    /// Refractive index of the film.
    #[schemars(extend("default" = 1.3))]
    pub iridescence_ior: Option<Ior>,
    /// Thickness of the film in nanometres where `iridescence_thickness_texture` is 0.
    #[schemars(extend("default" = 100.0))]
    pub iridescence_thickness_minimum: Option<NonNegative>,
    /// Thickness of the film in nanometres where `iridescence_thickness_texture` is 1 or absent.
    #[schemars(extend("default" = 400.0))]
    pub iridescence_thickness_maximum: Option<NonNegative>,
    /// Green chooses between the two thicknesses.
    pub iridescence_thickness_texture: Option<TextureFile>,
    /// Colour of the emitted light. [1, 1, 1] by default when `emissive_strength` or `emissive_texture` is given.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub emissive: Option<Radiance>,
    /// Red, green and blue (sRGB) times `emissive`.
    pub emissive_texture: Option<TextureFile>,
    /// Strength of the emitted light: multiplied by `emissive` it is the emitted radiance.
    #[schemars(extend("default" = 1.0))]
    pub emissive_strength: Option<Brightness>,
    /// Normals in the tangent space of its texture coordinates.
    pub normal_map: Option<TextureFile>,
    /// Factor that multiplies x and y of `normal_map`.
    #[schemars(extend("default" = 1.0))]
    pub normal_scale: Option<Coordinate>,
}

/// Use of coverage.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "AlphaMode")]
pub(crate) enum AlphaModeFile {
    /// No use: the surface is whole.
    Opaque,
    /// A cut: there is no surface where coverage is below `alpha_cutoff`.
    Mask,
    /// A blend: coverage is the part of light that meets the surface; the rest passes.
    Blend,
}

/// An image or a checkerboard, and how it lies on the surface.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["image"] }, { "required": ["checker"] }]))]
#[schemars(rename = "TextureTable")]
pub(crate) struct TextureTable {
    /// Path of a PNG, JPEG, WebP, BMP, TGA, TIFF, KTX2, HDR or EXR file, relative to the scene file.
    pub image: Option<String>,
    /// Two to sixteen colours that take turns along both sides of a checkerboard whose fields have the side 1 in texture coordinates; in place of `image`. With 0 in `scale` fields become stripes.
    #[schemars(length(min = 2, max = 16))]
    pub checker: Option<Vec<SurfaceColor>>,
    /// Number of the mesh's set of texture coordinates, 0 or 1.
    #[schemars(extend("default" = 0))]
    pub uv_set: Option<Whole<0, 1>>,
    /// Offset added to the texture coordinates, last; (0, 0) is the image's top left corner, (1, 1) its bottom right.
    #[schemars(extend("default" = [0.0, 0.0]))]
    pub offset: Option<[Coordinate; 2]>,
    /// Angle by which texture coordinates are turned counter-clockwise about (0, 0), so that the image seems to turn clockwise.
    #[schemars(extend("default" = 0.0))]
    pub rotation_degrees: Option<Coordinate>,
    /// Factors that multiply the texture coordinates, first.
    #[schemars(extend("default" = [1.0, 1.0]))]
    pub scale: Option<[Coordinate; 2]>,
    /// Continuation beyond the image's edges, for both directions or for u and v apart: "repeat", "mirrored_repeat" or "clamp_to_edge".
    #[schemars(extend("default" = "repeat"))]
    pub wrap: Option<WrapFile>,
    /// Interpolation between the centres of texels: "linear" or "nearest".
    #[schemars(extend("default" = "linear"))]
    pub filter: Option<TextureFilterFile>,
}

/// One continuation for both directions, or one for u and one for v.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "must be `\"repeat\"`, `\"mirrored_repeat\"`, `\"clamp_to_edge\"`, or a list of two of them"
)]
#[schemars(rename = "Wrap")]
pub(crate) enum WrapFile {
    /// Continuation for both directions.
    Both(WrapName),
    /// Continuations for u and for v.
    Each([WrapName; 2]),
}

/// Continuation beyond an image's edges.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum WrapName {
    /// The image again.
    Repeat,
    /// The image mirrored, then again as it is.
    MirroredRepeat,
    /// The outermost texels of the image.
    ClampToEdge,
}

/// Interpolation between the centres of texels.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "TextureFilter")]
pub(crate) enum TextureFilterFile {
    /// A blend of the four texels around.
    Linear,
    /// The nearest texel.
    Nearest,
}

/// The path of an image, or a table that also says how it lies on the surface.
#[derive(Debug)]
pub(crate) struct TextureFile(pub TextureTable);

impl<'de> Deserialize<'de> for TextureFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TextureVisitor).map(Self)
    }
}

struct TextureVisitor;

impl TextureVisitor {
    fn refuse<T, E: Error>() -> Result<T, E> {
        Err(E::custom("must be the path of an image, or a table with `image` or `checker`"))
    }
}

/// An untagged enum would hide what is wrong inside the table.
impl<'de> Visitor<'de> for TextureVisitor {
    type Value = TextureTable;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the path of an image, or a table with `image` or `checker`")
    }

    fn visit_str<E: Error>(self, path: &str) -> Result<TextureTable, E> {
        Ok(TextureTable { image: Some(path.to_string()), ..TextureTable::default() })
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TextureTable, A::Error> {
        TextureTable::deserialize(MapAccessDeserializer::new(map))
    }

    fn visit_f64<E: Error>(self, _: f64) -> Result<TextureTable, E> {
        Self::refuse()
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<TextureTable, E> {
        Self::refuse()
    }

    fn visit_seq<A: SeqAccess<'de>>(self, _: A) -> Result<TextureTable, A::Error> {
        Self::refuse()
    }
}

impl JsonSchema for TextureFile {
    fn schema_name() -> Cow<'static, str> {
        "Texture".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<TextureTable>();
        json_schema!({
            "description": "The path of an image, or a table that also says how it lies on the surface.",
            "anyOf": [{ "type": "string" }, table]
        })
    }
}
