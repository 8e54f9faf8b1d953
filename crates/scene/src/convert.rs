//! Conversion of the file's types into the scene: defaults that depend on other keys, and every check that needs more
//! than one number.

mod environment;
mod keyframes;
mod lights;
mod materials;
mod meshes;
mod principled;
mod projection;
mod shapes;
mod transform;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use raggio_models::Format;

use self::shapes::{Parts, below};
use crate::assets::{AssetOptions, Assets, Imported};
use crate::fault::{Fault, Step, steps, subject};
use crate::file::{CameraFile, Groups, Materials, MeshFile, RenderFile, SceneFile, ShapeFile};
use crate::names;
use crate::number::SMALLEST;
use crate::review::Review;
use crate::scene::{Camera, Environment, LightEntry, Material, Projection, RenderSettings, Scene, Shape};

/// Sine of the smallest angle between `up` and the viewing direction.
const PARALLEL: f64 = 1e-5;
/// Projection in place of one at fault.
const STAND_IN: Projection = Projection::Perspective { vertical_fov_degrees: 40.0 };

/// The scene and, apart from it, its warnings; it is sound if `review` has no faults. Paths are relative to `folder`.
pub(crate) fn scene(file: &SceneFile, folder: &Path, assets: &mut Assets, review: &Review) -> (Scene, Vec<Fault>) {
    let mut warnings = Vec::new();
    let files =
        &mut Files { folder, assets, review, troubles: HashMap::new(), warnings: Vec::new(), warned: HashSet::new() };
    let before = review.count();
    keyframes::check(&file.camera, review, check_camera);
    let posed = keyframes::posed(&file.camera, files.assets.camera_seconds());
    // What is wrong at a keyframe is wrong at its moment too.
    if review.count() == before {
        review.accept(check_camera(&posed));
    }
    let projection = review.accept(projection::projection(&posed));
    let environment = file.environment.as_ref().and_then(|file| review.accept(environment::environment(file, files)));
    let materials = materials::materials(&file.materials, files, &mut warnings);
    let light_entries = lights::lights(&file.lights.0, review);
    let shapes = &file.shapes.0;
    let mut scene = Scene {
        render: render(&file.render),
        camera: camera(&posed, projection.unwrap_or(STAND_IN)),
        environment: environment.unwrap_or(Environment::Constant(Vec3::ZERO)),
        air: file.air.map(materials::medium),
        shapes: Vec::with_capacity(shapes.len()),
        entries: Vec::with_capacity(shapes.len()),
        materials,
        lights: light_entries.iter().map(LightEntry::light).collect(),
        light_entries,
        warnings: Vec::new(),
    };
    let names = file.materials.0.iter().enumerate();
    let indices = names.map(|(index, (name, _))| (name.as_str(), index)).collect();
    let mut builder = Builder {
        scene: &mut scene,
        files,
        indices,
        materials: &file.materials,
        groups: &file.groups,
        known_groups: HashMap::new(),
        warnings: &mut warnings,
        first_materials: HashMap::new(),
    };
    for (index, shape) in shapes.iter().enumerate() {
        review.accept(builder.add(index, shape));
        if review.is_full() {
            break;
        }
    }
    builder.check_groups();
    if let Environment::Sky(sky) = &scene.environment {
        scene.lights.extend(sky.sun());
    }
    warnings.append(&mut files.warnings);
    if review.count() == 0 {
        warnings.extend(radians(&posed));
        warnings.extend(sheets(&scene));
        warnings.extend(lights::dark(&file.lights.0, &scene.light_entries));
        warnings.extend(stillness(&file.camera, &meshes(file), files));
        warnings.extend(darkness(&scene));
        warnings.extend(endlessness(&scene));
    }
    (scene, warnings)
}

/// Places of a scene's files, and what is wrong with the scene.
struct Files<'a> {
    folder: &'a Path,
    assets: &'a mut Assets,
    review: &'a Review,
    /// Troubles of the files that could not be read.
    troubles: HashMap<PathBuf, String>,
    /// Warnings of images, once for each.
    warnings: Vec<Fault>,
    /// Paths of the images whose warnings are among `warnings`.
    warned: HashSet<PathBuf>,
}

/// A scene whose shapes are being added.
struct Builder<'a, 'f> {
    scene: &'a mut Scene,
    files: &'a mut Files<'f>,
    /// Index of each material of the file, by its name.
    indices: HashMap<&'a str, usize>,
    materials: &'a Materials,
    groups: &'a Groups,
    /// Groups that have been read; `None` while one is.
    known_groups: HashMap<String, Option<Parts>>,
    warnings: &'a mut Vec<Fault>,
    /// Models met so far, each with the index of the first of its own materials if these are used.
    first_materials: HashMap<*const Imported, Option<usize>>,
}

/// The first key that is given.
fn first_given(keys: &[(&'static str, bool)]) -> Option<&'static str> {
    keys.iter().find(|(_, is_given)| *is_given).map(|(key, _)| *key)
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
        alpha: file.alpha,
        surface_offset: file.surface_offset,
        ..RenderSettings::default()
    }
}

fn camera(file: &CameraFile, projection: Projection) -> Camera {
    let focus_distance = file.focus_distance.map_or_else(|| towards(file).length(), f64::from);
    Camera {
        position: vec3(file.position),
        look_at: vec3(file.look_at),
        up: vec3(file.up),
        projection,
        aperture_radius: file.aperture_radius.0 as f32,
        focus_distance: focus_distance as f32,
    }
}

/// Viewing direction, of 32-bit floats: two points that these cannot tell apart are equal.
fn towards(file: &CameraFile) -> DVec3 {
    vec3(file.look_at).as_dvec3() - vec3(file.position).as_dvec3()
}

fn check_camera(file: &CameraFile) -> Result<(), Fault> {
    let towards = towards(file);
    if towards.length() < SMALLEST {
        let message = "`look_at` in [camera] is the same point as `position`: move one of them, \
                       so that the camera looks somewhere";
        return Err(Fault::value(steps!["camera", "look_at"], message));
    }
    check_up(dvec3(file.up), towards)
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

/// A warning of an angle of view that may be meant in radians: 3.2 is just above half a turn.
fn radians(file: &CameraFile) -> Option<Fault> {
    const HALF_TURN: f64 = 3.2;
    let angle = file.vertical_fov_degrees.map(|angle| angle.0).filter(|angle| *angle < HALF_TURN)?;
    let degrees = (10.0 * angle.to_degrees()).round() / 10.0;
    let message = format!(
        "`vertical_fov_degrees` in [camera] is {angle}, which shows very little: if these are radians, write {degrees}"
    );
    Some(Fault::value(steps!["camera", "vertical_fov_degrees"], message))
}

/// Models that the file names, among its shapes and in its groups, each with its place.
fn meshes(file: &SceneFile) -> Vec<(Vec<Step>, &MeshFile)> {
    let of_shapes = file.shapes.0.iter().enumerate().map(|(index, shape)| (steps!["shapes", index], shape));
    let of_groups = file.groups.0.iter().flat_map(|(name, group)| {
        group.0.iter().enumerate().map(move |(index, shape)| (steps!["groups", name.as_str(), index], shape))
    });
    let all: Vec<(Vec<Step>, &ShapeFile)> = of_shapes.chain(of_groups).collect();
    all.into_iter().filter_map(|(at, shape)| Some((below(&at, "mesh"), shape.mesh.as_ref()?))).collect()
}

/// Warnings of moments at which nothing is different: few files move.
fn stillness(camera: &CameraFile, meshes: &[(Vec<Step>, &MeshFile)], files: &mut Files<'_>) -> Vec<Fault> {
    let format = |mesh: &MeshFile| Format::of_path(Path::new(&mesh.file));
    let may_move = |mesh: &MeshFile| format(mesh).is_some_and(Format::is_animated);
    let AssetOptions { time_seconds, elapsed_seconds, .. } = *files.assets.options();
    let mut moves = |mesh: &MeshFile| files.model(mesh, Vec::new()).is_ok_and(|model| !model.animations.is_empty());
    if time_seconds.is_some() || elapsed_seconds.is_some() {
        let given = if elapsed_seconds.is_some() { "frames are asked for" } else { "a time is given" };
        let message = format!("{given}, but nothing in the scene moves");
        let still = match () {
            () if keyframes::moves(camera) || meshes.iter().any(|(_, mesh)| moves(mesh)) => return Vec::new(),
            () if meshes.iter().any(|(_, mesh)| may_move(mesh)) => "its .gltf and .glb files have no animations",
            () => "only .gltf and .glb files have animations",
        };
        return vec![Fault::value(Vec::new(), format!("{message}: {still}"))];
    }
    let timed = meshes.iter().filter(|(_, mesh)| mesh.time.is_some() && !moves(mesh));
    let warn = |(at, mesh): &(Vec<Step>, &MeshFile)| {
        let still = match format(mesh) {
            Some(format) if !format.is_animated() => format!(".{format} files have no animations"),
            _ => format!("{} has no animations", names::printable(&mesh.file)),
        };
        let at = below(at, "time");
        let message = format!("{} does nothing: {still}", subject(&at));
        Fault::key(at, message)
    };
    timed.map(warn).collect()
}

/// A warning of each dielectric without an inside.
fn sheets(scene: &Scene) -> Vec<Fault> {
    let is_dielectric = |shape: &&Shape| scene.materials[shape.material].is_dielectric();
    let sheets = scene.shapes.iter().filter(|shape| shape.geometry.is_sheet()).filter(is_dielectric);
    sheets.map(|shape| sheet(shape, &scene.materials[shape.material].name)).collect()
}

fn sheet(shape: &Shape, material: &str) -> Fault {
    let kind = shape.geometry.key();
    let open = if matches!(kind, "cylinder" | "cone") { " without caps" } else { "" };
    let message = format!(
        "a {kind}{open} has no inside, so {} fills all that lies behind it, up to another {kind} of that material that \
         faces the other way: a pane is a thin `box`",
        names::quoted(material)
    );
    Fault::key(steps!["shapes", shape.entry, kind], message)
}

/// A warning of air that no light from infinitely far away comes through.
fn endlessness(scene: &Scene) -> Option<Fault> {
    let air = scene.air?;
    let comes_through = (air.absorption + air.scattering).min_element() <= 0.0;
    if scene.environment.is_black() || comes_through {
        return None;
    }
    let message = "[air] has no end, so no light of [environment] comes through it: for fog under a sky, give a large body a \
                   material with a `medium` instead";
    Some(Fault::value(steps!["air"], message))
}

/// A warning when the picture will be black.
fn darkness(scene: &Scene) -> Option<Fault> {
    let mut used = scene.shapes.iter().map(|shape| &scene.materials[shape.material]);
    let mut imported = scene.materials.iter().filter(|material| material.imported);
    let shines = used.any(Material::is_emissive) || imported.any(Material::is_emissive);
    let has_light = scene.lights.iter().any(|light| light.intensity != [0.0; 3]);
    if !scene.environment.is_black() || has_light || shines {
        return None;
    }
    let message = "nothing in the scene shines, so the picture will be black: give [environment] \
                   a `color`, or the material of a shape an `emission_strength`";
    Some(Fault::value(steps!["environment"], message))
}
