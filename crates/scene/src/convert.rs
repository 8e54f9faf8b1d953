//! From what the file says to the scene: defaults that depend on other keys, and every check that
//! needs more than one number.

mod shapes;

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::fault::{Fault, steps};
use crate::file::{
    CameraFile, EnvironmentFile, FilterFile, MaterialFile, Materials, ReflectionFile, RenderFile, SceneFile,
};
use crate::names;
use crate::number::{BRIGHTEST, SMALLEST};
use crate::scene::{Camera, Environment, Filter, Material, Reflection, RenderSettings, Scene, Shape};

/// Sine of the smallest angle between `up` and the viewing direction.
const PARALLEL: f64 = 1e-5;

/// The scene, its warnings still apart; the first fault in the order of the sections.
pub(crate) fn scene(file: SceneFile) -> Result<(Scene, Vec<Fault>), Fault> {
    let mut warnings = Vec::new();
    let camera = camera(&file.camera)?;
    let environment = file.environment.as_ref().map(environment).transpose()?;
    let environment = environment.unwrap_or(Environment::Constant(Vec3::ZERO));
    let materials = materials(&file.materials, &mut warnings)?;
    let indices = materials.iter().enumerate().map(|(i, it)| (it.name.as_str(), i)).collect();
    let shapes = all_shapes(&file, &indices)?;
    warnings.extend(file.shapes.iter().zip(&shapes).enumerate().filter_map(|(i, (file, shape))| {
        let dielectric = materials[shape.material].refractive_index.is_some();
        (dielectric && file.rectangle.is_some()).then(|| sheet(i, &file.material))
    }));
    let scene = Scene { render: render(&file.render), camera, environment, shapes, materials, warnings: Vec::new() };
    warnings.extend(darkness(&scene));
    Ok((scene, warnings))
}

fn all_shapes(file: &SceneFile, indices: &HashMap<&str, usize>) -> Result<Vec<Shape>, Fault> {
    let shapes = file.shapes.iter().enumerate();
    shapes.map(|(index, shape)| shapes::shape(index, shape, indices, &file.materials)).collect()
}

/// As 32-bit floats; the types of the file have checked that they are in range.
fn vec3<T: Into<f64>>(numbers: [T; 3]) -> Vec3 {
    dvec3(numbers).as_vec3()
}

fn dvec3<T: Into<f64>>(numbers: [T; 3]) -> DVec3 {
    DVec3::from(numbers.map(Into::into))
}

/// The ranges of the file's types make these casts exact.
fn render(file: &RenderFile) -> RenderSettings {
    RenderSettings {
        width: file.width.0 as u32,
        height: file.height.0 as u32,
        samples: file.samples.0 as u32,
        max_depth: file.max_depth.0 as u32,
        seed: file.seed.0 as u32,
        filter: match file.filter {
            FilterFile::Box => Filter::Box,
            FilterFile::Point => Filter::Point,
        },
        surface_offset: file.surface_offset,
    }
}

/// Checks what 32 bits make of the numbers: two points that they cannot tell apart are equal.
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

fn environment(file: &EnvironmentFile) -> Result<Environment, Fault> {
    refuse_image(file)?;
    let message = match (file.color, file.horizon, file.zenith) {
        (Some(color), None, None) => return Ok(Environment::Constant(vec3(color))),
        (None, Some(horizon), Some(zenith)) => {
            let (horizon, zenith) = (vec3(horizon), vec3(zenith));
            return Ok(Environment::Gradient { horizon, zenith });
        }
        (None, None, None) => "[environment] is empty: give it `color`, or `horizon` and `zenith`",
        (None, Some(_), None) => "`horizon` in [environment] needs `zenith` beside it",
        (None, None, Some(_)) => "`zenith` in [environment] needs `horizon` beside it",
        (Some(_), ..) => {
            "`color` in [environment] cannot stand beside `horizon` and `zenith`: keep one or the \
             other"
        }
    };
    let given =
        [("color", file.color.is_some()), ("horizon", file.horizon.is_some()), ("zenith", file.zenith.is_some())];
    Err(match given.iter().find(|(_, is_given)| *is_given) {
        Some((key, _)) => Fault::key(steps!["environment", *key], message),
        None => Fault::value(steps!["environment"], message),
    })
}

fn refuse_image(file: &EnvironmentFile) -> Result<(), Fault> {
    let given = [
        ("image", file.image.is_some()),
        ("rotation_degrees", file.rotation_degrees.is_some()),
        ("intensity", file.intensity.is_some()),
    ];
    let message = "environment images are not in this version of raggio: use `color` or \
                   `horizon` and `zenith`";
    match given.iter().find(|(_, is_given)| *is_given) {
        Some((key, _)) => Err(Fault::key(steps!["environment", *key], message)),
        None => Ok(()),
    }
}

fn materials(file: &Materials, warnings: &mut Vec<Fault>) -> Result<Vec<Material>, Fault> {
    let mut materials = Vec::with_capacity(file.0.len());
    for (name, material) in &file.0 {
        warn_of_opaque(name, material, warnings);
        refuse_too_bright(name, material)?;
        materials.push(self::material(name, material));
    }
    Ok(materials)
}

fn refuse_too_bright(name: &str, file: &MaterialFile) -> Result<(), Fault> {
    let brightest = file.emission_color.iter().map(|c| c.0).fold(0.0, f64::max) * file.emission_strength.0;
    if brightest <= BRIGHTEST {
        return Ok(());
    }
    let table = names::key(name);
    let message = format!("`emission_strength` times `emission_color` in [materials.{table}] must be at most 1e9");
    Err(Fault::value(steps!["materials", name, "emission_strength"], message))
}

/// What only a dielectric has, given to an opaque material.
fn warn_of_opaque(name: &str, file: &MaterialFile, warnings: &mut Vec<Fault>) {
    if file.refractive_index.is_some() {
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
    let emission_strength = file.emission_strength.0 as f32;
    // A lamp is black unless told otherwise: its own light is what one wants to see of it.
    let default_color = if file.emission_strength.0 > 0.0 { 0.0 } else { 0.8 };
    Material {
        name: name.to_string(),
        color: file.color.map_or(Vec3::splat(default_color), vec3),
        emission_color: vec3(file.emission_color),
        emission_strength,
        smoothness: file.smoothness.0 as f32,
        refractive_index: file.refractive_index.map(|index| index.0 as f32),
        reflection: match file.reflection {
            None | Some(ReflectionFile::Named(_)) => Reflection::Fresnel,
            Some(ReflectionFile::Probability(p)) => Reflection::Probability(p.0 as f32),
        },
        priority: file.priority.map_or(0, |priority| priority.0 as i32),
    }
}

/// A warning of a dielectric without an inside.
fn sheet(index: usize, material: &str) -> Fault {
    let message = format!(
        "a rectangle has no inside, so {} fills all that lies behind it, up to another rectangle of that material that \
         faces the other way: a pane is a thin `box`",
        names::quoted(material)
    );
    Fault::key(steps!["shapes", index, "rectangle"], message)
}

/// A warning when the picture will be black.
fn darkness(scene: &Scene) -> Option<Fault> {
    let mut used = scene.shapes.iter().map(|shape| &scene.materials[shape.material]);
    if !scene.environment.is_black() || used.any(Material::is_emissive) {
        return None;
    }
    let message = "nothing in the scene shines, so the picture will be black: give [environment] \
                   a `color`, or the material of a shape an `emission_strength`";
    Some(Fault::value(steps!["environment"], message))
}
