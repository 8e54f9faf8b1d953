//! Cost of samples by what can be counted: a clock says something else each time, and nothing while other programs run.

mod counts;
mod instructions;

use raggio_scene::Scene;

/// Scenes by the names that messages give them; `rock` has 20,482 triangles.
fn scene(name: &str) -> Scene {
    match name {
        "rock" => Scene::rock(5),
        _ => {
            let file = format!("{}/../scenes/reference/{name}.toml", env!("CARGO_MANIFEST_DIR"));
            Scene::load(file.as_ref()).expect("the scene is valid")
        }
    }
}
