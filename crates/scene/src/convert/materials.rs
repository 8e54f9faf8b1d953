//! Materials: the keys of the notes, or the principled material.

use glam::Vec3;

use super::principled::principled;
use super::{Files, first_given, vec3};
use crate::fault::{Fault, steps};
use crate::file::{CoefficientFile, Color, MaterialFile, Materials, MediumFile, PrincipledFile, ReflectionFile};
use crate::names;
use crate::number::BRIGHTEST;
use crate::scene::{Material, Medium, Reflection};

/// Materials in the order of the file; faults are noted.
pub(super) fn materials(file: &Materials, files: &mut Files<'_>, warnings: &mut Vec<Fault>) -> Vec<Material> {
    let mut materials = Vec::with_capacity(file.0.len());
    for (name, material) in &file.0 {
        materials.push(match &material.principled {
            Some(surface) => {
                files.review.accept(refuse_beside_principled(name, material));
                files.review.accept(refuse_unreached(name, material, surface));
                let surface = principled(name, surface, files, warnings);
                let medium = material.medium.map(medium);
                Material { name: name.to_string(), principled: Some(surface.into()), medium, ..Material::default() }
            }
            None => {
                warn_of_opaque(name, material, warnings);
                files.review.accept(refuse_too_bright(name, material));
                files.review.accept(refuse_without_surface(name, material));
                self::material(name, material)
            }
        });
    }
    materials
}

fn refuse_beside_principled(name: &str, file: &MaterialFile) -> Result<(), Fault> {
    let given = [
        ("color", "base_color", file.color.is_some()),
        ("emission_color", "emissive", file.emission_color.is_some()),
        ("emission_strength", "emissive_strength", file.emission_strength.is_some()),
        ("smoothness", "roughness", file.smoothness.is_some()),
        ("refractive_index", "ior", file.refractive_index.is_some()),
        ("reflection", "ior", file.reflection.is_some()),
        ("priority", "priority", file.priority.is_some()),
    ];
    let Some((key, inside, _)) = given.into_iter().find(|(.., is_given)| *is_given) else {
        return Ok(());
    };
    let table = names::key(name);
    let message = format!(
        "`{key}` in [materials.{table}] cannot stand beside `principled`: keep one or the other, or write `{inside}` \
         inside `principled`"
    );
    Err(Fault::key(steps!["materials", name, key], message))
}

/// Refuses a medium that no light enters, because the principled material around it lets none in.
fn refuse_unreached(name: &str, file: &MaterialFile, surface: &PrincipledFile) -> Result<(), Fault> {
    let transmits = surface.transmission.map_or(surface.transmission_texture.is_some(), |part| f64::from(part) > 0.0);
    let is_sheet = surface.thin_walled.unwrap_or(false);
    if file.medium.is_none() || transmits && !is_sheet {
        return Ok(());
    }
    let table = names::key(name);
    let advice = if is_sheet { "leave out `thin_walled`" } else { "give it a `transmission`" };
    let message =
        format!("`medium` in [materials.{table}] is behind a `principled` surface that lets no light in: {advice}");
    Err(Fault::key(steps!["materials", name, "medium"], message))
}

/// Refuses properties of the surface of a body that has none.
fn refuse_without_surface(name: &str, file: &MaterialFile) -> Result<(), Fault> {
    if file.medium.is_none() || file.refractive_index.is_some() {
        return Ok(());
    }
    let given = [
        ("color", file.color.is_some()),
        ("emission_color", file.emission_color.is_some()),
        ("emission_strength", file.emission_strength.is_some()),
        ("smoothness", file.smoothness.is_some()),
        ("reflection", file.reflection.is_some()),
    ];
    let Some(key) = first_given(&given) else { return Ok(()) };
    let table = names::key(name);
    let message = format!(
        "`{key}` in [materials.{table}] is of a surface, and a body with a `medium` has none without `refractive_index`: \
         leave out `{key}`, or give it a `refractive_index`"
    );
    Err(Fault::key(steps!["materials", name, key], message))
}

/// Medium of a body, or of the air.
pub(super) fn medium(file: MediumFile) -> Medium {
    let coefficient = |file: Option<CoefficientFile>| match file {
        None => Vec3::ZERO,
        Some(CoefficientFile::Grey(all)) => Vec3::splat(all.0 as f32),
        Some(CoefficientFile::Colored(each)) => vec3(each),
    };
    Medium {
        absorption: coefficient(file.absorption),
        scattering: coefficient(file.scattering),
        anisotropy: file.anisotropy.map_or(0.0, |g| g.0 as f32),
    }
}

fn strength(file: &MaterialFile) -> f64 {
    file.emission_strength.map_or(0.0, f64::from)
}

fn refuse_too_bright(name: &str, file: &MaterialFile) -> Result<(), Fault> {
    let color = file.emission_color.map_or([1.0; 3], Color::linear);
    if color.into_iter().fold(0.0, f64::max) * strength(file) <= BRIGHTEST {
        return Ok(());
    }
    let table = names::key(name);
    let message = format!("`emission_strength` times `emission_color` in [materials.{table}] must be at most 1e9");
    Err(Fault::value(steps!["materials", name, "emission_strength"], message))
}

/// Warns of keys that only a dielectric has, given to an opaque material.
fn warn_of_opaque(name: &str, file: &MaterialFile, warnings: &mut Vec<Fault>) {
    if file.refractive_index.is_some() || file.medium.is_some() {
        return;
    }
    let given = [("reflection", file.reflection.is_some()), ("priority", file.priority.is_some())];
    for (key, _) in given.into_iter().filter(|(_, is_given)| *is_given) {
        let table = names::key(name);
        let message = format!("`{key}` in [materials.{table}] does nothing without `refractive_index`");
        warnings.push(Fault::key(steps!["materials", name, key], message));
    }
}

fn material(name: &str, file: &MaterialFile) -> Material {
    let strength = strength(file);
    // A lamp is black unless told otherwise: its own light is what one wants to see of it.
    let default_color = if strength > 0.0 { 0.0 } else { 0.8 };
    Material {
        name: name.to_string(),
        color: file.color.map_or(Vec3::splat(default_color), |color| vec3(color.0)),
        emission_color: file.emission_color.map_or(Vec3::ONE, |color| vec3(color.0)),
        emission_strength: strength as f32,
        smoothness: file.smoothness.map_or(0.0, |smoothness| smoothness.0 as f32),
        refractive_index: file.refractive_index.map(|index| index.0 as f32),
        reflection: match file.reflection {
            None | Some(ReflectionFile::Named(_)) => Reflection::Fresnel,
            Some(ReflectionFile::Probability(p)) => Reflection::Probability(p.0 as f32),
        },
        priority: file.priority.map_or(0, |priority| priority.0 as i32),
        principled: None,
        medium: file.medium.map(medium),
        imported: false,
    }
}
