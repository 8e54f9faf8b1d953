//! A camera as text, to be passed on.

use raggio_scene::{Camera, Scene};
use toml_edit::{DocumentMut, Item, value};

use super::fields::{self, Datum};
use super::tree;

/// The camera as a `[camera]` table of a scene file, with every key.
pub fn camera_text(camera: &Camera) -> String {
    let mut fields = fields::camera(camera, camera);
    fields.iter_mut().for_each(|field| field.absent = Datum::Absent);
    let mut toml = DocumentMut::new();
    toml.insert("camera", tree::table(&fields));
    toml.to_string()
}

/// The camera in a text: of [`camera_text`], of its keys alone, or of a whole scene.
///
/// # Errors
/// One sentence for the user when the text has no camera, or one that cannot be used.
pub fn camera_from_text(text: &str) -> Result<Camera, String> {
    let toml = text.parse::<DocumentMut>().ok();
    let item = toml.as_ref().and_then(camera_item);
    let item = item.ok_or("the text has no camera: copy a [camera] table of a scene file")?;
    // The least that is a scene.
    let mut scene = DocumentMut::new();
    scene.insert("version", value(1));
    scene.insert("camera", item);
    let scene = Scene::parse(&scene.to_string(), "the text");
    scene.map(|scene| scene.camera).map_err(|error| format!("the text's camera cannot be used: {}", error.message))
}

fn camera_item(toml: &DocumentMut) -> Option<Item> {
    let keys = || toml.contains_key("look_at").then(|| toml.as_item().clone());
    toml.get("camera").cloned().or_else(keys)
}
