//! Materials, textures and images as they are written.

use std::sync::LazyLock;

use serde::Deserialize;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Image {
    #[serde(default)]
    pub name: String,
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(in crate::gltf) struct Texture {
    pub sampler: Option<usize>,
    pub source: Option<usize>,
    pub extensions: TextureExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(in crate::gltf) struct TextureExtensions {
    #[serde(rename = "KHR_texture_basisu")]
    pub basisu: Option<Source>,
    #[serde(rename = "EXT_texture_webp")]
    pub webp: Option<Source>,
}

#[derive(Deserialize)]
pub(in crate::gltf) struct Source {
    pub source: Option<usize>,
}

impl Texture {
    /// Numbers of the images, best first.
    pub(in crate::gltf) fn sources(&self) -> impl Iterator<Item = usize> + '_ {
        let extensions = [&self.extensions.basisu, &self.extensions.webp].into_iter().flatten();
        extensions.filter_map(|extension| extension.source).chain(self.source)
    }
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Sampler {
    pub mag_filter: Option<u32>,
    pub wrap_s: Option<u32>,
    pub wrap_t: Option<u32>,
}

/// Use of a texture by a material; `scale` belongs to normal textures alone.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct TextureInfo {
    pub index: usize,
    #[serde(default)]
    pub tex_coord: u32,
    pub scale: Option<f32>,
    #[serde(default)]
    pub extensions: TextureInfoExtensions,
}

#[derive(Deserialize, Default)]
#[serde(default)]
pub(in crate::gltf) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub transform: Option<Box<Transform>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::gltf) struct Transform {
    pub offset: [f32; 2],
    pub rotation: f32,
    pub scale: [f32; 2],
    pub tex_coord: Option<u32>,
}

impl Default for Transform {
    fn default() -> Self {
        Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

/// Structures whose members all have a default, which stands beside them.
macro_rules! with_defaults {
    ($($(#[$meta:meta])* $name:ident { $($(#[$attribute:meta])* $member:ident: $type:ty = $default:expr,)* })*) => {$(
        $(#[$meta])*
        #[derive(Deserialize)]
        #[serde(rename_all = "camelCase", default)]
        pub(in crate::gltf) struct $name { $($(#[$attribute])* pub $member: $type,)* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($member: $default,)* }
            }
        }
    )*};
}

with_defaults! {
    Material {
        name: String = String::new(),
        pbr_metallic_roughness: MetallicRoughness = MetallicRoughness::default(),
        normal_texture: Option<TextureInfo> = None,
        occlusion_texture: Option<TextureInfo> = None,
        emissive_texture: Option<TextureInfo> = None,
        emissive_factor: [f32; 3] = [0.0; 3],
        alpha_mode: AlphaMode = AlphaMode::Opaque,
        alpha_cutoff: f32 = 0.5,
        extensions: Option<Box<MaterialExtensions>> = None,
    }

    MetallicRoughness {
        base_color_factor: [f32; 4] = [1.0; 4],
        base_color_texture: Option<TextureInfo> = None,
        metallic_factor: f32 = 1.0,
        roughness_factor: f32 = 1.0,
        metallic_roughness_texture: Option<TextureInfo> = None,
    }

    MaterialExtensions {
        #[serde(rename = "KHR_materials_anisotropy")]
        anisotropy: Option<Anisotropy> = None,
        #[serde(rename = "KHR_materials_clearcoat")]
        clearcoat: Option<Clearcoat> = None,
        #[serde(rename = "KHR_materials_diffuse_transmission")]
        diffuse_transmission: Option<DiffuseTransmission> = None,
        #[serde(rename = "KHR_materials_dispersion")]
        dispersion: Option<Dispersion> = None,
        #[serde(rename = "KHR_materials_emissive_strength")]
        emissive_strength: Option<EmissiveStrength> = None,
        #[serde(rename = "KHR_materials_ior")]
        ior: Option<Ior> = None,
        #[serde(rename = "KHR_materials_iridescence")]
        iridescence: Option<Iridescence> = None,
        #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
        specular_glossiness: Option<SpecularGlossiness> = None,
        #[serde(rename = "KHR_materials_sheen")]
        sheen: Option<Sheen> = None,
        #[serde(rename = "KHR_materials_specular")]
        specular: Option<Specular> = None,
        #[serde(rename = "KHR_materials_transmission")]
        transmission: Option<Transmission> = None,
        #[serde(rename = "KHR_materials_unlit")]
        unlit: Option<Unlit> = None,
        #[serde(rename = "KHR_materials_volume")]
        volume: Option<Volume> = None,
    }

    Anisotropy {
        anisotropy_strength: f32 = 0.0,
        anisotropy_rotation: f32 = 0.0,
        anisotropy_texture: Option<TextureInfo> = None,
    }

    Clearcoat {
        clearcoat_factor: f32 = 0.0,
        clearcoat_texture: Option<TextureInfo> = None,
        clearcoat_roughness_factor: f32 = 0.0,
        clearcoat_roughness_texture: Option<TextureInfo> = None,
        clearcoat_normal_texture: Option<TextureInfo> = None,
    }

    DiffuseTransmission {
        diffuse_transmission_factor: f32 = 0.0,
        diffuse_transmission_texture: Option<TextureInfo> = None,
        diffuse_transmission_color_factor: [f32; 3] = [1.0; 3],
        diffuse_transmission_color_texture: Option<TextureInfo> = None,
    }

    Dispersion {
        dispersion: f32 = 0.0,
    }

    EmissiveStrength {
        emissive_strength: f32 = 1.0,
    }

    Ior {
        ior: f32 = 1.5,
    }

    Iridescence {
        iridescence_factor: f32 = 0.0,
        iridescence_texture: Option<TextureInfo> = None,
        iridescence_ior: f32 = 1.3,
        iridescence_thickness_minimum: f32 = 100.0,
        iridescence_thickness_maximum: f32 = 400.0,
        iridescence_thickness_texture: Option<TextureInfo> = None,
    }

    SpecularGlossiness {
        diffuse_factor: [f32; 4] = [1.0; 4],
        diffuse_texture: Option<TextureInfo> = None,
        specular_factor: [f32; 3] = [1.0; 3],
        glossiness_factor: f32 = 1.0,
        specular_glossiness_texture: Option<TextureInfo> = None,
    }

    Sheen {
        sheen_color_factor: [f32; 3] = [0.0; 3],
        sheen_color_texture: Option<TextureInfo> = None,
        sheen_roughness_factor: f32 = 0.0,
        sheen_roughness_texture: Option<TextureInfo> = None,
    }

    Specular {
        specular_factor: f32 = 1.0,
        specular_texture: Option<TextureInfo> = None,
        specular_color_factor: [f32; 3] = [1.0; 3],
        specular_color_texture: Option<TextureInfo> = None,
    }

    Transmission {
        transmission_factor: f32 = 0.0,
        transmission_texture: Option<TextureInfo> = None,
    }

    Unlit {}

    Volume {
        thickness_factor: f32 = 0.0,
        thickness_texture: Option<TextureInfo> = None,
        attenuation_distance: f32 = f32::INFINITY,
        attenuation_color: [f32; 3] = [1.0; 3],
    }
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "UPPERCASE")]
pub(in crate::gltf) enum AlphaMode {
    Opaque,
    Mask,
    Blend,
}

static NO_EXTENSIONS: LazyLock<MaterialExtensions> = LazyLock::new(MaterialExtensions::default);

impl Material {
    pub(in crate::gltf) fn extensions(&self) -> &MaterialExtensions {
        self.extensions.as_deref().unwrap_or(&NO_EXTENSIONS)
    }

    /// The textures that light can see, each with where it stands; light transport has no use for occlusion, nor for
    /// the thickness of volumes.
    pub(in crate::gltf) fn textures(&self) -> impl Iterator<Item = (&'static str, &TextureInfo)> {
        let core = &self.pbr_metallic_roughness;
        let more = self.extensions();
        let anisotropy = more.anisotropy.as_ref();
        let clearcoat = more.clearcoat.as_ref();
        let diffuse_transmission = more.diffuse_transmission.as_ref();
        let glossiness = more.specular_glossiness.as_ref();
        let iridescence = more.iridescence.as_ref();
        let sheen = more.sheen.as_ref();
        let specular = more.specular.as_ref();
        let transmission = more.transmission.as_ref();
        let list = [
            ("pbrMetallicRoughness.baseColorTexture", core.base_color_texture.as_ref()),
            ("pbrMetallicRoughness.metallicRoughnessTexture", core.metallic_roughness_texture.as_ref()),
            ("normalTexture", self.normal_texture.as_ref()),
            ("emissiveTexture", self.emissive_texture.as_ref()),
            ("anisotropyTexture", anisotropy.and_then(|e| e.anisotropy_texture.as_ref())),
            ("clearcoatTexture", clearcoat.and_then(|e| e.clearcoat_texture.as_ref())),
            ("clearcoatRoughnessTexture", clearcoat.and_then(|e| e.clearcoat_roughness_texture.as_ref())),
            ("clearcoatNormalTexture", clearcoat.and_then(|e| e.clearcoat_normal_texture.as_ref())),
            ("diffuseTransmissionTexture", diffuse_transmission.and_then(|e| e.diffuse_transmission_texture.as_ref())),
            (
                "diffuseTransmissionColorTexture",
                diffuse_transmission.and_then(|e| e.diffuse_transmission_color_texture.as_ref()),
            ),
            ("diffuseTexture", glossiness.and_then(|e| e.diffuse_texture.as_ref())),
            ("specularGlossinessTexture", glossiness.and_then(|e| e.specular_glossiness_texture.as_ref())),
            ("iridescenceTexture", iridescence.and_then(|e| e.iridescence_texture.as_ref())),
            ("iridescenceThicknessTexture", iridescence.and_then(|e| e.iridescence_thickness_texture.as_ref())),
            ("sheenColorTexture", sheen.and_then(|e| e.sheen_color_texture.as_ref())),
            ("sheenRoughnessTexture", sheen.and_then(|e| e.sheen_roughness_texture.as_ref())),
            ("specularTexture", specular.and_then(|e| e.specular_texture.as_ref())),
            ("specularColorTexture", specular.and_then(|e| e.specular_color_texture.as_ref())),
            ("transmissionTexture", transmission.and_then(|e| e.transmission_texture.as_ref())),
        ];
        list.into_iter().filter_map(|(name, info)| info.map(|info| (name, info)))
    }
}
