//! Translation of MTL's materials into principled ones.
//!
//! MTL describes a picture more than a surface, and programs have written it with several meanings. Ours: colours are
//! linear; a texture multiplies the colour beside it, and counts alone where that colour is black, because exporters
//! write it so; `Ks` of 0.5 is what a refractive index of 1.5 reflects, as Blender has it, and a material without `Ks`
//! is diffuse; `Ns` is the exponent of a Blinn-Phong highlight; bump maps are heights in texels, times `-bm`. The
//! extensions Pr, Pm, Pc, Pcr, aniso, anisor and norm have the principled material's own meaning.

use std::f32::consts::TAU;

use super::mtl::{MtlMap, MtlMaterial};
use super::textures::Textures;
use crate::material::{AlphaMode, Principled, Texture};
use crate::model::Material;
use crate::text::quoted;

/// Colour of materials that give none.
const GREY: [f32; 3] = [0.8; 3];
/// Refractive index where a library gives none, or one below it.
const DEFAULT_IOR: f32 = 1.5;
/// The reflection colours that stand for a dielectric's own reflection.
const USUAL_SPECULAR: f32 = 0.5;
/// Values of illum that refract.
const REFRACTING: [f32; 4] = [4.0, 6.0, 7.0, 9.0];

/// Translates all materials; what gets lost is told to `textures`.
pub(crate) fn translate(materials: &[MtlMaterial], textures: &mut Textures<'_>) -> Vec<Material> {
    let translate = |mtl: &MtlMaterial| Material { name: mtl.name.clone(), surface: surface(mtl, textures) };
    let mut translated: Vec<_> = materials.iter().map(translate).collect();
    show(materials, &mut translated, textures);
    translated
}

/// Tells of materials that cannot be seen. Where there are no others and `Tr` says so, it has been written with the meaning
/// of `d`, as MeshLab does: they are opaque then.
fn show(materials: &[MtlMaterial], translated: &mut [Material], textures: &mut Textures<'_>) {
    let is_invisible = |material: &Material| material.surface.alpha == 0.0;
    let by_tr = materials.iter().all(|mtl| mtl.opacity_by_tr);
    if !translated.is_empty() && by_tr && translated.iter().all(is_invisible) {
        for material in translated {
            (material.surface.alpha, material.surface.alpha_mode) = (1.0, AlphaMode::Opaque);
        }
        textures.warn(
            "by `Tr 1` all materials would be invisible: they are taken for opaque, which some programs mean by it",
        );
        return;
    }
    for (mtl, _) in materials.iter().zip(translated.iter()).filter(|(_, material)| is_invisible(material)) {
        let line = if mtl.opacity_by_tr { "Tr 1" } else { "d 0" };
        let name = quoted(mtl.name.as_bytes());
        textures.warn(&format!("the material {name} cannot be seen: by `{line}` it is wholly transparent"));
    }
}

fn surface(mtl: &MtlMaterial, textures: &mut Textures<'_>) -> Principled {
    textures.look_beside(&mtl.folder);
    let mut surface = Principled {
        metallic: unit(mtl.metallic.unwrap_or(0.0)),
        clearcoat: unit(mtl.clearcoat.unwrap_or(0.0)),
        clearcoat_roughness: unit(mtl.clearcoat_roughness.unwrap_or(0.0)),
        anisotropy: unit(mtl.anisotropy.unwrap_or(0.0)),
        anisotropy_rotation: mtl.anisotropy_rotation.unwrap_or(0.0).fract() * TAU,
        ior: mtl.refractive_index.filter(|ior| *ior > 1.0).unwrap_or(DEFAULT_IOR),
        ..Principled::default()
    };
    set_color(&mut surface, mtl, textures);
    set_reflection(&mut surface, mtl, textures);
    set_transmission(&mut surface, mtl);
    set_emission(&mut surface, mtl, textures);
    set_normals(&mut surface, mtl, textures);
    for keyword in &mtl.unread {
        textures.warn(&format!("the lines {keyword} of materials are not used"));
    }
    surface
}

fn set_color(surface: &mut Principled, mtl: &MtlMaterial, textures: &mut Textures<'_>) {
    let color = mtl.diffuse_map.as_ref().and_then(|map| textures.load(map));
    surface.base_color = factor(mtl.diffuse, color.as_ref(), GREY).map(unit);
    surface.alpha = unit(mtl.opacity.unwrap_or(1.0));
    let coverage = mtl.opacity_map.as_ref().and_then(|map| textures.load(map));
    if coverage.is_some() && surface.alpha == 0.0 {
        surface.alpha = 1.0;
    }
    if coverage.is_some() || surface.alpha < 1.0 {
        surface.alpha_mode = AlphaMode::Blend;
    }
    surface.base_color_texture = match coverage {
        Some(coverage) => textures.with_coverage(color, coverage),
        None => color,
    };
}

/// Sets the reflection: GGX's width for an exponent is `walter2007microfacet`'s, roughness is its square root.
fn set_reflection(surface: &mut Principled, mtl: &MtlMaterial, textures: &mut Textures<'_>) {
    let is_physical = mtl.roughness.is_some() || mtl.metallic.is_some() || mtl.roughness_map.is_some();
    let is_diffuse = mtl.illumination.is_some_and(|model| model < 2.0) && !is_physical;
    let map = mtl.specular_map.as_ref().filter(|_| !is_diffuse).and_then(|map| textures.load(map));
    let default = if is_physical { [USUAL_SPECULAR; 3] } else { [0.0; 3] };
    let reflected = factor(mtl.specular, map.as_ref(), default);
    let has_highlight = !is_diffuse && reflected.iter().any(|x| *x > 0.0);
    surface.specular = if has_highlight { 1.0 } else { 0.0 };
    surface.specular_color = reflected.map(|x| (x.max(0.0) / USUAL_SPECULAR).min(f32::MAX));
    surface.specular_color_texture = map;
    let exponent = mtl.shininess.filter(|_| has_highlight).map(|exponent| exponent.max(0.0));
    let roughness = mtl.roughness.or(exponent.map(|exponent| (2.0 / (exponent + 2.0)).sqrt().sqrt()));
    surface.roughness = unit(roughness.unwrap_or(1.0));
    let maps = [&mtl.roughness_map, &mtl.metallic_map];
    let [rough, metal] = maps.map(|map| map.as_ref().and_then(|map| textures.load(map)));
    let replaces = |value: f32, map: &Option<Texture>| if map.is_some() && value == 0.0 { 1.0 } else { value };
    surface.roughness = replaces(surface.roughness, &rough);
    surface.metallic = replaces(surface.metallic, &metal);
    surface.metallic_roughness_texture = textures.metallic_roughness(rough, metal);
}

/// Sets the transmission. An index above 1 is asked for, because there are exporters that give every material a model
/// of illumination that refracts, or a filter of white, and the index of nothing.
fn set_transmission(surface: &mut Principled, mtl: &MtlMaterial) {
    let refracts = mtl.illumination.is_some_and(|model| REFRACTING.contains(&model));
    let filters = mtl.transmission.is_some() && surface.alpha < 1.0;
    let bends = mtl.refractive_index.is_some_and(|ior| ior > 1.0);
    let is_black = mtl.transmission == Some([0.0; 3]);
    if !bends || is_black || mtl.opacity_map.is_some() || !(refracts || filters) {
        return;
    }
    surface.transmission = if surface.alpha < 1.0 { 1.0 - surface.alpha } else { 1.0 };
    (surface.alpha, surface.alpha_mode) = (1.0, AlphaMode::Opaque);
    (surface.specular, surface.specular_color, surface.specular_color_texture) = (1.0, [1.0; 3], None);
    if surface.transmission == 1.0 {
        surface.base_color = mtl.transmission.unwrap_or([1.0; 3]).map(unit);
        surface.base_color_texture = None;
    }
    if mtl.roughness.is_none() && mtl.shininess.is_none() {
        surface.roughness = 0.0;
    }
}

fn set_normals(surface: &mut Principled, mtl: &MtlMaterial, textures: &mut Textures<'_>) {
    surface.normal_texture = match (&mtl.normal_map, &mtl.bump_map) {
        (Some(map), _) => textures.load(map),
        (None, Some(map)) => textures.bump(map),
        (None, None) => None,
    };
    if let Some(map) = mtl.normal_map.as_ref().or(mtl.bump_map.as_ref()) {
        surface.normal_scale = map.multiplier;
    }
    if mtl.normal_map.is_some() && mtl.bump_map.is_some() {
        textures.warn("bump maps are not used beside a normal map, `norm`");
    }
}

fn set_emission(surface: &mut Principled, mtl: &MtlMaterial, textures: &mut Textures<'_>) {
    let map = mtl.emission_map.as_ref().and_then(|map: &MtlMap| textures.load(map));
    surface.emissive = factor(mtl.emission, map.as_ref(), [0.0; 3]).map(|x| x.max(0.0));
    surface.emissive_texture = map;
}

/// Factor beside a texture or without one: white under a texture whose colour is black or missing.
fn factor(color: Option<[f32; 3]>, texture: Option<&Texture>, default: [f32; 3]) -> [f32; 3] {
    match (color.filter(|color| texture.is_none() || *color != [0.0; 3]), texture) {
        (Some(color), _) => color,
        (None, Some(_)) => [1.0; 3],
        (None, None) => default,
    }
}

fn unit(value: f32) -> f32 {
    value.clamp(0.0, 1.0)
}
