//! Materials, with their textures, as kernels read them.

use raggio_kernels::{
    AlphaMode as DeviceAlphaMode, Material as DeviceMaterial, NO_TEXTURE, NONE, Principled as DevicePrincipled,
};
use raggio_scene::{AlphaMode, Material, Medium, Principled, Reflection, Texture};

use super::TranslationError;
use crate::translation::textures::{ColorSpace, TextureTable};

/// Materials in the order of the scene, and the principled ones among them in a list of their own.
#[derive(Default)]
pub(super) struct Materials {
    pub materials: Vec<DeviceMaterial>,
    pub principled: Vec<DevicePrincipled>,
}

impl Materials {
    /// Materials of a scene, and behind them that of the air if it has any.
    pub fn new(
        materials: &[Material],
        air: Option<&Medium>,
        textures: &mut TextureTable,
    ) -> Result<Self, TranslationError> {
        let mut list = Self::default();
        for material in materials {
            let translated = match &material.principled {
                None => plain(material),
                Some(principled) => {
                    list.principled.push(device_principled(principled, textures)?);
                    body(principled, list.principled.len() as u32 - 1)
                }
            };
            let medium = material.medium.filter(|_| material.is_dielectric());
            list.materials.push(medium.map_or(translated, |medium| filled(translated, &medium)));
        }
        // Every other body goes before the air.
        let nothing = DeviceMaterial { refractive_index: 1.0, priority: i32::MIN, seamless: 1, ..white() };
        list.materials.extend(air.map(|air| filled(nothing, air)));
        Ok(list)
    }

    /// Whether any of the materials takes light away inside its bodies.
    pub fn absorbing(&self) -> bool {
        self.materials.iter().any(|material| material.absorption != [0.0; 3])
    }

    /// Whether any of the materials scatters light inside its bodies.
    pub fn scattering(&self) -> bool {
        self.materials.iter().any(|material| material.scattering != [0.0; 3])
    }

    /// Whether bodies of any of the materials have no surface.
    pub fn seamless(&self) -> bool {
        self.materials.iter().any(|material| material.seamless != 0)
    }
}

/// Whether light may pass surfaces of `material` straight: see `passesStraight` in kernels/materials/principled.slang.
pub(super) fn is_clear(material: &Material) -> bool {
    /// Roughness from which on no sheet is smooth.
    const ROUGH: f32 = 0.04;
    material.principled.as_ref().is_some_and(|principled| {
        let smooth = principled.roughness < ROUGH || principled.metallic_roughness_texture.is_some();
        principled.thin_walled && principled.transmission > 0.0 && smooth
    })
}

/// Whether `material` lets light pass between what is there and what is not.
pub(super) fn has_holes(material: &Material) -> bool {
    material.principled.as_ref().is_some_and(|principled| principled.alpha_mode != AlphaMode::Opaque)
}

/// `material` with what its bodies are filled with.
fn filled(material: DeviceMaterial, medium: &Medium) -> DeviceMaterial {
    let absorption = std::array::from_fn(|c| material.absorption[c] + medium.absorption[c]);
    DeviceMaterial { absorption, scattering: medium.scattering.to_array(), asymmetry: medium.anisotropy, ..material }
}

/// White material without any properties.
fn white() -> DeviceMaterial {
    DeviceMaterial { color: [1.0; 3], reflection: -1.0, principled: NONE, ..DeviceMaterial::default() }
}

fn plain(material: &Material) -> DeviceMaterial {
    if material.is_seamless() {
        // What bends light may be around it: then it has a boundary, which is all white.
        return DeviceMaterial { refractive_index: 1.0, priority: material.priority, seamless: 1, ..white() };
    }
    DeviceMaterial {
        color: material.color.to_array(),
        emission: (material.emission_color * material.emission_strength).to_array(),
        smoothness: material.smoothness,
        refractive_index: material.refractive_index.unwrap_or(0.0),
        reflection: match material.reflection {
            Reflection::Fresnel => -1.0,
            Reflection::Probability(p) => p,
        },
        priority: material.priority,
        ..white()
    }
}

/// Material for the bodies of a principled one: all that a path has to know of them.
fn body(principled: &Principled, index: u32) -> DeviceMaterial {
    let is_body = principled.transmission > 0.0 && !principled.thin_walled;
    // White light has the attenuation colour after the attenuation distance; no colour is quite black.
    let absorption = principled.attenuation_color.map(|color| -color.max(1e-6).ln() / principled.attenuation_distance);
    DeviceMaterial {
        refractive_index: if is_body { refractive_index(principled) } else { 0.0 },
        priority: principled.priority,
        absorption: if is_body { absorption.map(|a| a.max(0.0)) } else { [0.0; 3] },
        // KHR_materials_dispersion: half of what the index spreads over.
        dispersion: if is_body { (refractive_index(principled) - 1.0) * 0.025 * principled.dispersion } else { 0.0 },
        principled: index,
        ..DeviceMaterial::default()
    }
}

/// Refractive index of a principled material; glTF's 0 stands for an infinite one, which bends like a large one.
fn refractive_index(principled: &Principled) -> f32 {
    if principled.ior > 0.0 { principled.ior } else { 1000.0 }
}

fn device_principled(
    principled: &Principled,
    textures: &mut TextureTable,
) -> Result<DevicePrincipled, TranslationError> {
    let mut add = |texture: &Option<Texture>, space| match texture {
        None => Ok(NO_TEXTURE),
        Some(texture) => textures.add(texture, space),
    };
    let (color, data) = (ColorSpace::Srgb, ColorSpace::Linear);
    let p = principled;
    let (alpha_mode, alpha_cutoff) = match p.alpha_mode {
        AlphaMode::Opaque => (DeviceAlphaMode::Opaque, 0.0),
        AlphaMode::Mask(cutoff) => (DeviceAlphaMode::Mask, cutoff),
        AlphaMode::Blend => (DeviceAlphaMode::Blend, 0.0),
    };
    let (sine, cosine) = p.anisotropy_rotation.sin_cos();
    // Textures stand in the order of `PrincipledTexture`.
    let textures = [
        add(&p.base_color_texture, color)?,
        add(&p.metallic_roughness_texture, data)?,
        add(&p.normal_texture, data)?,
        add(&p.emissive_texture, color)?,
        add(&p.specular_texture, data)?,
        add(&p.specular_color_texture, color)?,
        add(&p.transmission_texture, data)?,
        add(&p.diffuse_transmission_texture, data)?,
        add(&p.diffuse_transmission_color_texture, color)?,
        add(&p.clearcoat_texture, data)?,
        add(&p.clearcoat_roughness_texture, data)?,
        add(&p.clearcoat_normal_texture, data)?,
        add(&p.sheen_color_texture, color)?,
        add(&p.sheen_roughness_texture, data)?,
        add(&p.anisotropy_texture, data)?,
        add(&p.iridescence_texture, data)?,
        add(&p.iridescence_thickness_texture, data)?,
    ];
    let texture_kinds = (0..).zip(textures).map(|(kind, t)| u32::from(t != NO_TEXTURE) << kind).sum();
    Ok(DevicePrincipled {
        textures,
        texture_kinds,
        base_color: p.base_color,
        alpha: p.alpha,
        emissive: p.emissive,
        metallic: p.metallic,
        specular_color: p.specular_color,
        specular: p.specular,
        diffuse_transmission_color: p.diffuse_transmission_color,
        diffuse_transmission: p.diffuse_transmission,
        sheen_color: p.sheen_color,
        sheen_roughness: p.sheen_roughness,
        roughness: p.roughness,
        ior: p.ior,
        transmission: p.transmission,
        clearcoat: p.clearcoat,
        clearcoat_roughness: p.clearcoat_roughness,
        anisotropy: p.anisotropy,
        anisotropy_direction: [cosine, sine],
        iridescence: p.iridescence,
        iridescence_ior: p.iridescence_ior,
        iridescence_thickness_minimum: p.iridescence_thickness_minimum,
        iridescence_thickness_maximum: p.iridescence_thickness_maximum,
        normal_scale: p.normal_scale,
        clearcoat_normal_scale: p.clearcoat_normal_scale,
        alpha_mode: alpha_mode as u32,
        alpha_cutoff,
        thin_walled: u32::from(p.thin_walled),
        emissive_by_vertex_color: u32::from(p.emissive_by_vertex_color),
    })
}
