//! Conversion of the file's types into the scene: defaults that depend on other keys, and every check that needs more
//! than one number.

mod environment;
mod materials;
mod meshes;
mod principled;
mod shapes;

use std::collections::HashMap;
use std::path::Path;

use glam::{DVec3, Vec3};

use crate::assets::{Assets, Imported};
use crate::fault::{Fault, steps};
use crate::file::{CameraFile, RenderFile, SceneFile};
use crate::names;
use crate::number::SMALLEST;
use crate::scene::{Camera, Environment, Material, RenderSettings, Scene, Shape};

/// Sine of the smallest angle between `up` and the viewing direction.
const PARALLEL: f64 = 1e-5;

/// The scene and, apart from it, its warnings; or the first fault in the order of the sections. Paths are relative to
/// `folder`.
pub(crate) fn scene(file: &SceneFile, folder: &Path, assets: &mut Assets) -> Result<(Scene, Vec<Fault>), Fault> {
    let mut warnings = Vec::new();
    let files = &mut Files { folder, assets };
    let camera = camera(&file.camera)?;
    let environment = file.environment.as_ref().map(|file| environment::environment(file, files)).transpose()?;
    let materials = materials::materials(&file.materials, files, &mut warnings)?;
    let mut scene = Scene {
        render: render(&file.render),
        camera,
        environment: environment.unwrap_or(Environment::Constant(Vec3::ZERO)),
        shapes: Vec::with_capacity(file.shapes.len()),
        entries: Vec::with_capacity(file.shapes.len()),
        materials,
        lights: Vec::new(),
        warnings: Vec::new(),
    };
    let names = file.materials.0.iter().enumerate();
    let indices = names.map(|(index, (name, _))| (name.as_str(), index)).collect();
    let mut builder =
        Builder { scene: &mut scene, files, indices, warnings: &mut warnings, first_materials: HashMap::new() };
    for (index, shape) in file.shapes.iter().enumerate() {
        builder.add(index, shape, &file.materials)?;
    }
    warnings.extend(sheets(&scene, file));
    warnings.extend(darkness(&scene));
    Ok((scene, warnings))
}

/// Places of a scene's files.
struct Files<'a> {
    folder: &'a Path,
    assets: &'a mut Assets,
}

/// A scene whose shapes are being added.
struct Builder<'a, 'f> {
    scene: &'a mut Scene,
    files: &'a mut Files<'f>,
    /// Index of each material of the file, by its name.
    indices: HashMap<&'a str, usize>,
    warnings: &'a mut Vec<Fault>,
    /// Models met so far, each with the index of the first of its own materials if these are used.
    first_materials: HashMap<*const Imported, Option<usize>>,
}

/// Vector of 32-bit floats; the types of the file have checked that the numbers are in range.
fn vec3<T: Into<f64>>(numbers: [T; 3]) -> Vec3 {
    dvec3(numbers).as_vec3()
}

fn dvec3<T: Into<f64>>(numbers: [T; 3]) -> DVec3 {
    DVec3::from(numbers.map(Into::into))
}

/// Settings of the renderer; the ranges of the file's types make these casts exact.
fn render(file: &RenderFile) -> RenderSettings {
    RenderSettings {
        width: file.width.0 as u32,
        height: file.height.0 as u32,
        samples: file.samples.0 as u32,
        max_depth: file.max_depth.0 as u32,
        seed: file.seed.0 as u32,
        sampler: file.sampler.0,
        filter: file.filter.0,
        clamp: file.clamp.map(|limit| f64::from(limit) as f32),
        surface_offset: file.surface_offset,
        ..RenderSettings::default()
    }
}

/// Camera of the file. Numbers are checked as 32-bit floats: two points that these cannot tell apart are equal.
fn camera(file: &CameraFile) -> Result<Camera, Fault> {
    let position = vec3(file.position);
    let look_at = vec3(file.look_at);
    let towards = look_at.as_dvec3() - position.as_dvec3();
    if towards.length() < SMALLEST {
        let message = "`look_at` in [camera] is the same point as `position`: move one of them, \
                       so that the camera looks somewhere";
        return Err(Fault::value(steps!["camera", "look_at"], message));
    }
    check_up(dvec3(file.up), towards)?;
    let focus_distance = file.focus_distance.map_or(towards.length(), f64::from);
    Ok(Camera {
        position,
        look_at,
        up: vec3(file.up),
        vertical_fov_degrees: file.vertical_fov_degrees.0 as f32,
        aperture_radius: file.aperture_radius.0 as f32,
        focus_distance: focus_distance as f32,
    })
}

fn check_up(up: DVec3, towards: DVec3) -> Result<(), Fault> {
    let other = perpendicular_axis(towards);
    let wrong = if up.length() < SMALLEST {
        "zero"
    } else if up.normalize().cross(towards.normalize()).length() < PARALLEL {
        "parallel to the viewing direction"
    } else {
        return Ok(());
    };
    let message = format!("`up` in [camera] is {wrong}: `up = {other}` would do");
    Err(Fault::value(steps!["camera", "up"], message))
}

/// The axis furthest from the viewing direction, upwards if that is as good as any.
fn perpendicular_axis(towards: DVec3) -> &'static str {
    let [x, y, z] = towards.abs().to_array();
    if y <= x || y <= z {
        "[0, 1, 0]"
    } else if z <= x {
        "[0, 0, 1]"
    } else {
        "[1, 0, 0]"
    }
}

/// A warning of each dielectric without an inside.
fn sheets(scene: &Scene, file: &SceneFile) -> Vec<Fault> {
    let is_dielectric = |shape: &&Shape| scene.materials[shape.material].is_dielectric();
    let sheets = scene.shapes.iter().filter(|shape| shape.geometry.is_sheet()).filter(is_dielectric);
    sheets.map(|shape| sheet(shape, file.shapes[shape.entry].material.as_deref().unwrap_or_default())).collect()
}

fn sheet(shape: &Shape, material: &str) -> Fault {
    let kind = shape.geometry.key();
    let message = format!(
        "a {kind} has no inside, so {} fills all that lies behind it, up to another {kind} of that material that \
         faces the other way: a pane is a thin `box`",
        names::quoted(material)
    );
    Fault::key(steps!["shapes", shape.entry, kind], message)
}

/// A warning when the picture will be black.
fn darkness(scene: &Scene) -> Option<Fault> {
    let mut used = scene.shapes.iter().map(|shape| &scene.materials[shape.material]);
    let mut imported = scene.materials.iter().filter(|material| material.imported);
    let shines = used.any(Material::is_emissive) || imported.any(Material::is_emissive);
    if !scene.environment.is_black() || !scene.lights.is_empty() || shines {
        return None;
    }
    let message = "nothing in the scene shines, so the picture will be black: give [environment] \
                   a `color`, or the material of a shape an `emission_strength`";
    Some(Fault::value(steps!["environment"], message))
}
