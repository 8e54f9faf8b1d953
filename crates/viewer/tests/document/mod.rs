//! The scene file being edited.

mod clipboard;
mod files;
mod forms;
mod history;
mod lists;
mod models;
mod paths;
mod properties;
mod values;

use std::path::Path;

use raggio_scene::{Geometry, Scene};
use raggio_viewer::document::Document;

/// A scene in tables under headers, with comments everywhere and odd spaces.
const HEADERS: &str = r#"# A scene.
version = 1

[camera] # where from
position = [0, 1.50,  4]   # integers stay
look_at = [0, 1, 0]
vertical_fov_degrees = 40

# The red one.
[materials.red]
color = [ 0.8, 0.1, 0.1 ] # blood
[materials."matt white"]

# A ball.
[[shapes]]
material = "red"
sphere = { center = [0, 1, 0], radius = 1 } # unit

[[shapes]]
material = "matt white"
plane = { point = [0, 0, 0], normal = [0, 2, 0] }
# The end.
"#;

/// The scene in inline tables.
const INLINE: &str = r#"version = 1
camera = { position = [0, 1.50, 4], look_at = [0, 1, 0], vertical_fov_degrees = 40 }
materials = { red = { color = [0.8, 0.1, 0.1] }, "matt white" = {} }
shapes = [
  { material = "red", sphere = { center = [0, 1, 0], radius = 1 } }, # ball
  # Below it all.
  { material = "matt white", plane = { point = [0, 0, 0], normal = [0, 2, 0] } }, # floor
]
"#;

/// The scene in dotted keys.
const DOTTED: &str = r#"version = 1
camera.position = [0, 1.50, 4]
camera.look_at = [0, 1, 0]
camera.vertical_fov_degrees = 40
materials.red.color = [0.8, 0.1, 0.1]
materials."matt white" = {}
[[shapes]]
material = "red"
sphere.center = [0, 1, 0]
sphere.radius = 1
[[shapes]]
material = "matt white"
[shapes.plane]
point = [0, 0, 0]
normal = [0, 2, 0]
"#;

const FORMS: [&str; 3] = [HEADERS, INLINE, DOTTED];

fn document(text: &str) -> Document {
    Document::from_text(text, Path::new("it.toml")).unwrap()
}

/// Asserts that the document's scene is that of its text, as it must be after every edit.
fn check(document: &Document) {
    let name = raggio_scene::display_name(document.path());
    assert_eq!(document.scene(), &Scene::parse(document.text(), &name).unwrap(), "{}", document.text());
}

/// The text after an edit that must change something; undone, the old one must be back.
fn edited(text: &str, edit: impl FnOnce(&mut Document) -> bool) -> String {
    let mut document = document(text);
    assert!(edit(&mut document), "nothing changed");
    check(&document);
    let after = document.text().to_string();
    assert!(document.undo().is_some() && document.can_undo().is_none());
    assert_eq!(document.text(), text);
    after
}

/// `text` with one part of it replaced.
fn with(text: &str, old: &str, new: &str) -> String {
    assert_eq!(text.matches(old).count(), 1, "{old}");
    text.replace(old, new)
}

fn ball(center: [f32; 3], radius: f32) -> Geometry {
    Geometry::Sphere { center: center.into(), radius }
}
