//! A scene that shows a model: a camera that sees all of it, a ground below it, a sky above.
//!
//! The scene is made as text, so that it can be read like any other, edited and saved.

use std::fmt::Write;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use raggio_models::{Camera, Format, Place, Projection};

use crate::assets::{Assets, Bounds, Imported, Trouble};
use crate::error::SceneError;
use crate::names::{display_name, escaped};
use crate::number::LARGEST;
use crate::scene::RenderSettings;

/// Vertical field of view: degrees between the picture's top and bottom edges.
const VERTICAL_FOV: f64 = 36.0;
/// Factor by which the camera stands further away than it would have to.
const MARGIN: f64 = 1.08;
/// Direction from the model to the camera: in front of it, to the right and above. glTF's models look along +Z.
const TOWARDS_CAMERA: DVec3 = DVec3::new(0.5, 0.38, 0.866);
/// Most points that are looked at, one by one, for the model's exact extent.
const MOST_POINTS: usize = 50_000_000;
/// Least gaps between the ground and the model, in parts of its size and of its coordinates; below these, the ground
/// would meet the model's flat lower side.
const GAPS: [f64; 2] = [2e-4, 2e-6];

/// Text of a scene in the model's own folder.
pub(crate) fn text(path: &Path, assets: &mut Assets) -> Result<String, SceneError> {
    let name = display_name(path);
    let refuse = |message: &str| SceneError::whole_file(&name, message);
    let file = path.file_name().and_then(|file| file.to_str());
    let file = file.ok_or_else(|| refuse("has a name that is not UTF-8: rename it"))?;
    // Ground and sky stay where they are at the first frame of a sequence, and so does a camera that is none of the file's.
    let models = assets.model_at_first(path.to_path_buf()).map_err(|trouble| described(&name, trouble))?;
    let [model, now] = models;
    let turned = is_z_up(path);
    let bounds = bounds(&model, &upright(turned));
    if model.instances.is_empty() {
        return Err(refuse("has no triangles, so there is nothing to be seen"));
    }
    if bounds.reach() > LARGEST / 10.0 {
        return Err(refuse("is too large: keep all of it within 1e14 of the origin"));
    }
    let own = own_camera(&now, assets.options().camera.as_deref()).map_err(|message| refuse(&message))?;
    let [width, height] = assets.options().picture.unwrap_or_else(|| picture(own));
    let mut text = format!("# Shows {}.\nversion = 1\n", file.escape_debug());
    let _ = writeln!(text, "[render]\nwidth = {width}\nheight = {height}");
    camera(&mut text, own, bounds, f64::from(width) / f64::from(height));
    surroundings(&mut text, &model, bounds);
    let is_animated = Format::of_path(path).is_some_and(Format::is_animated);
    subject(&mut text, &model, file, assets.options().time_seconds.filter(|_| is_animated), turned);
    Ok(text)
}

fn described(name: &str, trouble: Trouble) -> SceneError {
    match trouble.place {
        Place::Whole => SceneError::whole_file(name, trouble.message),
        Place::Line(line) => SceneError { line, ..SceneError::whole_file(name, trouble.message) },
        Place::Byte(byte) => SceneError::whole_file(name, format!("byte {byte}: {}", trouble.message)),
    }
}

/// Whether z is upwards, as it is by custom in files for printers.
fn is_z_up(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("stl"))
}

fn upright(turned: bool) -> DAffine3 {
    let turn = DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y);
    DAffine3::from_mat3(if turned { turn } else { DMat3::IDENTITY })
}

/// Bounds of the model, as tight as can be found in reasonable time: loose ones would have the model float.
fn bounds(model: &Imported, world_from_model: &DAffine3) -> Bounds {
    let points: usize = model.instances.iter().map(|it| model.meshes[it.mesh].positions.len()).sum();
    let of_instances = model.instances.iter().map(|instance| {
        let world_from_mesh = *world_from_model * instance.model_from_mesh;
        if points > MOST_POINTS {
            return model.bounds_of(instance, &world_from_mesh);
        }
        let positions = model.meshes[instance.mesh].positions.iter();
        let world = positions.map(|it| world_from_mesh.transform_point3(DVec3::from(it.map(f64::from))));
        world.fold(Bounds::EMPTY, Bounds::with)
    });
    of_instances.fold(Bounds::EMPTY, Bounds::united)
}

/// Size of the picture, with the aspect of the file's camera if it has one that gives it.
fn picture(own: Option<&Camera>) -> [u32; 2] {
    let RenderSettings { width, height, .. } = RenderSettings::default();
    let aspect = own.and_then(Camera::aspect);
    let aspect = aspect.filter(|aspect| (0.1..=10.0).contains(aspect));
    [aspect.map_or(width, |aspect| (aspect * height as f32).round() as u32), height]
}

/// Writes the camera: the file's own, or one that sees the whole model.
fn camera(text: &mut String, own: Option<&Camera>, bounds: Bounds, aspect: f64) {
    let center = 0.5 * (bounds.min + bounds.max);
    let (position, look_at, up) = match own {
        Some(camera) => (camera.position, looks_at(camera, bounds), camera.up),
        None => (center + distance(bounds, aspect) * TOWARDS_CAMERA.normalize(), center, DVec3::Y),
    };
    let [position, look_at, up] = [position, look_at, up].map(list);
    let _ = writeln!(text, "[camera]\nposition = {position}\nlook_at = {look_at}\nup = {up}");
    let (key, value) = match own.map(|camera| camera.projection) {
        Some(Projection::Perspective { vertical_fov, .. }) => {
            ("vertical_fov_degrees", f64::from(vertical_fov).to_degrees().clamp(0.01, 179.0))
        }
        Some(Projection::Orthographic { ymag, .. }) => ("orthographic_height", 2.0 * f64::from(ymag)),
        None => ("vertical_fov_degrees", VERTICAL_FOV),
    };
    let _ = writeln!(text, "{key} = {}", number(value));
}

/// Camera of the file: the one that is `wanted` by its name or its number from 1 on, or the first.
fn own_camera<'a>(model: &'a Imported, wanted: Option<&str>) -> Result<Option<&'a Camera>, String> {
    let Some(wanted) = wanted else { return Ok(model.cameras.first()) };
    let by_name = model.cameras.iter().find(|camera| camera.name == wanted);
    let by_number = || model.cameras.get(wanted.parse::<usize>().ok()?.checked_sub(1)?);
    by_name.or_else(by_number).map(Some).ok_or_else(|| match &*listed(model) {
        [] => format!("has no camera `{}`, nor any other", escaped(wanted)),
        cameras => format!("has no camera `{}`: give a name or a number of {}", escaped(wanted), cameras.join(", ")),
    })
}

/// Numbers, names and kinds of the file's cameras.
fn listed(model: &Imported) -> Vec<String> {
    let describe = |(i, camera): (usize, &Camera)| {
        let kind = match camera.projection {
            Projection::Perspective { .. } => "perspective",
            Projection::Orthographic { .. } => "orthographic",
        };
        format!("{} `{}` ({kind})", i + 1, escaped(&camera.name))
    };
    model.cameras.iter().enumerate().map(describe).collect()
}

/// Cameras of a model that is shown without a scene file, in words: number, name and kind of each. None where `path` is no
/// model, or the model cannot be read.
pub fn cameras(path: &Path, assets: &mut Assets) -> Vec<String> {
    assets.model(path.to_path_buf(), None).map(|model| listed(&model)).unwrap_or_default()
}

/// Point that a camera of the file looks at: the middle of its picture, as far away as the model's middle.
fn looks_at(camera: &Camera, bounds: Bounds) -> DVec3 {
    let center = 0.5 * (bounds.min + bounds.max);
    let depth = (center - camera.position).dot(camera.forward);
    let depth = depth.max(1e-3 * bounds.size()).max(1e-4 * camera.position.length());
    camera.position + depth * camera.forward
}

/// Distance from the middle of the box, along [`TOWARDS_CAMERA`], at which every corner of it is in the picture.
fn distance(bounds: Bounds, aspect: f64) -> f64 {
    let back = TOWARDS_CAMERA.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let half = 0.5 * (bounds.max - bounds.min);
    let tangent = (0.5 * VERTICAL_FOV).to_radians().tan();
    let corners = (0..8).map(|corner| {
        let sign = |axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let corner = half * DVec3::new(sign(0), sign(1), sign(2));
        let across = (corner.dot(right).abs() / aspect).max(corner.dot(up).abs());
        corner.dot(back) + across / tangent
    });
    let far = corners.fold(0.0, f64::max) * MARGIN;
    // A point has no size, but there must be a difference that 32 bits can hold.
    far.max(1e-4 * bounds.reach()).max(1e-12)
}

/// Writes ground and sky. The sky is bright above, which makes shapes stand out, and dim if the file has lights.
fn surroundings(text: &mut String, model: &Imported, bounds: Bounds) {
    let sky = if model.lights.is_empty() { 1.0 } else { 0.08 };
    let [horizon, zenith] = [DVec3::new(0.36, 0.36, 0.38), DVec3::new(1.25, 1.3, 1.42)].map(|color| list(sky * color));
    let _ = writeln!(text, "[environment]\nhorizon = {horizon}\nzenith = {zenith}");

    let gap = (GAPS[0] * bounds.size()).max(GAPS[1] * bounds.reach());
    let center = 0.5 * (bounds.min + bounds.max);
    let point = list(center.with_y(bounds.min.y - gap));
    let _ = writeln!(text, "[materials.ground]\ncolor = [0.35, 0.35, 0.35]");
    if model.materials.is_empty() {
        // Colours of the vertices, where there are any, multiply the base colour.
        let has_colors = model.meshes.iter().any(|mesh| mesh.colors.is_some());
        let base_color = list(DVec3::splat(if has_colors { 1.0 } else { 0.75 }));
        let _ = writeln!(text, "[materials.clay]\nprincipled = {{ base_color = {base_color}, roughness = 0.6 }}");
    }
    let _ = writeln!(text, "[[shapes]]\nmaterial = \"ground\"\nplane = {{ point = {point}, normal = [0, 1, 0] }}");
}

fn subject(text: &mut String, model: &Imported, file: &str, time_seconds: Option<f64>, turned: bool) {
    text.push_str("[[shapes]]\n");
    if model.materials.is_empty() {
        text.push_str("material = \"clay\"\n");
    }
    let _ = write!(text, "mesh = {{ file = {}", quoted(file));
    if turned {
        text.push_str(", rotation_degrees = [-90, 0, 0]");
    }
    if let Some(seconds) = time_seconds {
        let _ = write!(text, ", time = {seconds}");
    }
    text.push_str(" }\n");
}

fn list(vector: DVec3) -> String {
    let [x, y, z] = vector.to_array().map(number);
    format!("[{x}, {y}, {z}]")
}

/// The number with the digits that 32 bits hold.
fn number(x: f64) -> String {
    format!("{}", x as f32)
}

/// The text as a TOML string; JSON's escapes are TOML's, but for one character that JSON leaves as it is.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string().replace('\u{7f}', "\\u007f")
}
