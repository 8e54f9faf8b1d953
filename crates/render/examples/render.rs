//! Renders a scene file: `cargo run --release -p raggio-render --example render -- scene.toml picture.png`.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use raggio_render::{DeviceChoice, Display, ImageFile, OpenOptions, Progress, RenderRequest, Rendering, open};
use raggio_scene::Scene;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, scene, picture] = &arguments[..] else { return Err("give a scene and a picture to write".into()) };

    let scene = Scene::load(Path::new(scene))?;
    scene.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    let file = ImageFile::new(Path::new(picture))?;
    let device = open(DeviceChoice::Auto, OpenOptions::default(), |warning| eprintln!("warning: {warning}"))?;

    let rendered = Rendering::begin(&scene, &*device, RenderRequest::default())?.run(&mut |progress: &Progress| {
        eprint!("\r{:3.0} %", 100.0 * progress.fraction);
        ControlFlow::Continue(())
    })?;
    rendered.picture.write(&file, Display::default())?;
    Ok(())
}
