//! The principled material: glTF's metallic-roughness model with its extensions, by glTF's names.

use std::sync::Arc;

use raggio_images::Bitmap;

/// A material with the meaning that glTF 2.0 and its `KHR_materials_*` extensions give to each name.
///
/// A texture multiplies the factor beside it. Colours are linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Principled {
    /// Reflected colour of the diffuse part, or of a metal at normal incidence; each 0 to 1.
    pub base_color: [f32; 3],
    /// Texture whose RGB multiplies `base_color` and whose A multiplies `alpha`; RGB is stored as sRGB.
    pub base_color_texture: Option<Texture>,
    /// Coverage, 0 to 1; see `alpha_mode`.
    pub alpha: f32,
    /// Effect of the coverage.
    pub alpha_mode: AlphaMode,
    /// Metalness, from 0 dielectric to 1 metal.
    pub metallic: f32,
    /// Perceptual roughness, from 0 smooth to 1; GGX's width is its square.
    pub roughness: f32,
    /// Texture whose G multiplies `roughness` and whose B multiplies `metallic`; linear.
    pub metallic_roughness_texture: Option<Texture>,
    /// Normals in the tangent space of the texture's coordinates; linear.
    pub normal_texture: Option<Texture>,
    /// Factor of the x and y of `normal_texture`.
    pub normal_scale: f32,
    /// Emitted radiance, strength included.
    pub emissive: [f32; 3],
    /// Texture whose RGB multiplies `emissive`; stored as sRGB.
    pub emissive_texture: Option<Texture>,
    /// Whether the colours of vertices multiply `emissive`, as they do `base_color`: a material that is not lit is seen by
    /// what it emits.
    pub emissive_by_vertex_color: bool,
    /// Refractive index, at least 1; 0 stands for an infinite one (no Fresnel effect).
    pub ior: f32,
    /// Strength of the specular reflection of dielectrics, 0 to 1.
    pub specular: f32,
    /// Texture whose A multiplies `specular`; linear.
    pub specular_texture: Option<Texture>,
    /// Colour of the specular reflection of dielectrics at normal incidence, 0 and more.
    pub specular_color: [f32; 3],
    /// Texture whose RGB multiplies `specular_color`; stored as sRGB.
    pub specular_color_texture: Option<Texture>,
    /// Part of the light that is refracted into the body instead of scattered diffusely, 0 to 1.
    pub transmission: f32,
    /// Texture whose R multiplies `transmission`; linear.
    pub transmission_texture: Option<Texture>,
    /// Part of the diffuse light that leaves on the other side, 0 to 1.
    pub diffuse_transmission: f32,
    /// Texture whose A multiplies `diffuse_transmission`; linear.
    pub diffuse_transmission_texture: Option<Texture>,
    /// Colour of the diffusely transmitted light.
    pub diffuse_transmission_color: [f32; 3],
    /// Texture whose RGB multiplies `diffuse_transmission_color`; stored as sRGB.
    pub diffuse_transmission_color_texture: Option<Texture>,
    /// Whether the surface is an infinitely thin sheet: transmitted light is not bent, and there is no inside.
    pub thin_walled: bool,
    /// Colour that is left of white light after `attenuation_distance` inside the body.
    pub attenuation_color: [f32; 3],
    /// Distance after which `attenuation_color` is left; positive, infinite where nothing is absorbed.
    pub attenuation_distance: f32,
    /// Dispersion as 20 over the Abbe number; 0 bends all colours alike.
    pub dispersion: f32,
    /// Rank among overlapping dielectrics: the highest wins.
    pub priority: i32,
    /// Strength of the clear coat, 0 to 1.
    pub clearcoat: f32,
    /// Texture whose R multiplies `clearcoat`; linear.
    pub clearcoat_texture: Option<Texture>,
    /// Perceptual roughness of the clear coat, 0 to 1.
    pub clearcoat_roughness: f32,
    /// Texture whose G multiplies `clearcoat_roughness`; linear.
    pub clearcoat_roughness_texture: Option<Texture>,
    /// Normals of the coat; without it the coat has the geometry's.
    pub clearcoat_normal_texture: Option<Texture>,
    /// Factor of the x and y of `clearcoat_normal_texture`.
    pub clearcoat_normal_scale: f32,
    /// Reflectance of the sheen at grazing angles; black is no sheen.
    pub sheen_color: [f32; 3],
    /// Texture whose RGB multiplies `sheen_color`; stored as sRGB.
    pub sheen_color_texture: Option<Texture>,
    /// Perceptual roughness of the sheen, 0 to 1.
    pub sheen_roughness: f32,
    /// Texture whose A multiplies `sheen_roughness`; linear.
    pub sheen_roughness_texture: Option<Texture>,
    /// Stretch of the highlights, 0 to 1.
    pub anisotropy: f32,
    /// Angle of the stretch from the tangent in radians, counter-clockwise.
    pub anisotropy_rotation: f32,
    /// Texture whose RG is a direction in [-1, 1] that is turned by `anisotropy_rotation`, and whose B multiplies
    /// `anisotropy`; linear.
    pub anisotropy_texture: Option<Texture>,
    /// Strength of the thin film, 0 to 1.
    pub iridescence: f32,
    /// Texture whose R multiplies `iridescence`; linear.
    pub iridescence_texture: Option<Texture>,
    /// Refractive index of the film.
    pub iridescence_ior: f32,
    /// Thickness of the film in nanometres where `iridescence_thickness_texture` is 0.
    pub iridescence_thickness_minimum: f32,
    /// Thickness of the film in nanometres where `iridescence_thickness_texture` is 1, or where there is none.
    pub iridescence_thickness_maximum: f32,
    /// Texture whose G chooses between the two thicknesses; linear.
    pub iridescence_thickness_texture: Option<Texture>,
}

impl Default for Principled {
    /// Material with glTF's defaults, except that `metallic` is 0.
    fn default() -> Self {
        Self {
            base_color: [1.0; 3],
            base_color_texture: None,
            alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            emissive_by_vertex_color: false,
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: [1.0; 3],
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            diffuse_transmission: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color: [1.0; 3],
            diffuse_transmission_color_texture: None,
            thin_walled: false,
            attenuation_color: [1.0; 3],
            attenuation_distance: f32::INFINITY,
            dispersion: 0.0,
            priority: 0,
            clearcoat: 0.0,
            clearcoat_texture: None,
            clearcoat_roughness: 0.0,
            clearcoat_roughness_texture: None,
            clearcoat_normal_texture: None,
            clearcoat_normal_scale: 1.0,
            sheen_color: [0.0; 3],
            sheen_color_texture: None,
            sheen_roughness: 0.0,
            sheen_roughness_texture: None,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
            iridescence: 0.0,
            iridescence_texture: None,
            iridescence_ior: 1.3,
            iridescence_thickness_minimum: 100.0,
            iridescence_thickness_maximum: 400.0,
            iridescence_thickness_texture: None,
        }
    }
}

/// Effect of a surface's coverage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Coverage has no effect: the surface is whole.
    #[default]
    Opaque,
    /// The surface is absent where coverage is below this cutoff.
    Mask(f32),
    /// Coverage is the part of light that meets the surface; the rest passes.
    Blend,
}

/// An image and how it lies on a surface.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Image, shared among all its uses.
    pub image: Arc<Bitmap>,
    /// Index of the mesh's set of texture coordinates, 0 or 1.
    pub uv_set: u8,
    /// Rows of an affine map from texture coordinates to the image's: (0, 0) is its top left corner, (1, 1) its bottom right.
    pub transform: [[f32; 3]; 2],
    /// Continuation of the image beyond 0 to 1, along u and v.
    pub wrap: [Wrap; 2],
    /// Interpolation between texels.
    pub filter: TextureFilter,
}

impl PartialEq for Texture {
    fn eq(&self, other: &Self) -> bool {
        let Self { image, uv_set, transform, wrap, filter } = other;
        // One image in memory is equal to itself, however many texels it has.
        (self.uv_set, self.transform, self.wrap, self.filter) == (*uv_set, *transform, *wrap, *filter)
            && (Arc::ptr_eq(&self.image, image) || self.image == *image)
    }
}

impl Texture {
    /// The transform that changes nothing.
    pub const IDENTITY: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// Texture that shows `image` by glTF's defaults: repeated, filtered, by the first set of coordinates.
    pub fn new(image: Arc<Bitmap>) -> Self {
        Self { image, uv_set: 0, transform: Self::IDENTITY, wrap: [Wrap::Repeat; 2], filter: TextureFilter::Linear }
    }
}

/// Continuation of an image beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image is repeated.
    #[default]
    Repeat,
    /// The image is mirrored, then repeated as it is.
    MirroredRepeat,
    /// The outermost texels go on.
    ClampToEdge,
}

/// Interpolation between the centres of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFilter {
    /// Blend of the four texels around.
    #[default]
    Linear,
    /// Value of the nearest texel.
    Nearest,
}
