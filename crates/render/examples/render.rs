//! From a scene file to a picture: `cargo run --release -p raggio-render --example render -- scene.toml picture.png`.

use std::error::Error;
use std::path::Path;

use raggio_render::{DeviceChoice, DeviceScene, Display, ImageFile, OpenOptions, Renderer, open};
use raggio_scene::Scene;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, scene, picture] = &arguments[..] else { return Err("give a scene and a picture to write".into()) };

    let scene = Scene::load(Path::new(scene))?;
    let device = open(DeviceChoice::Auto, OpenOptions::default(), |warning| eprintln!("warning: {warning}"))?;
    let device_scene = DeviceScene::new(&scene)?;
    let session = device.load(&device_scene)?;

    let mut renderer = Renderer::new(session, &device_scene, 0..scene.render.samples);
    while !renderer.finished() {
        let progress = renderer.advance()?;
        eprint!("\r{:3.0} %", 100.0 * progress.fraction);
    }
    ImageFile::new(Path::new(picture))?.write(&renderer.film()?, Display::default())?;
    Ok(())
}
