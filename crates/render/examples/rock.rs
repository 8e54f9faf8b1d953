//! Speed at which hierarchies are built and followed: a bumpy sphere of 20 * 4^LEVEL triangles on a square of two.
//!
//! `cargo run --release -p raggio-render --example rock -- [cpu|vulkan] [LEVEL ...]` prints a row for each level: seconds
//! to translate the scene (the hierarchy above all) and to load it into the device, bytes of each triangle on a GPU and on
//! processors without AVX2 (others have fewer), rays per second.

use std::time::Instant;

use raggio_render::{Device, DeviceChoice, DeviceScene, OpenOptions, Renderer, open};
use raggio_scene::{Integrator, Scene};

/// Seconds of tracing that a rate is taken from.
const LONG_ENOUGH: f64 = 4.0;

fn measure(device: &dyn Device, level: u32) -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = Scene::rock(level);
    // Rays alone, and no samples of light.
    scene.render.integrator = Integrator::Reference;
    let triangles = scene.counts().triangles;

    let start = Instant::now();
    let device_scene = DeviceScene::new(&scene)?;
    let build_seconds = start.elapsed().as_secs_f64();
    let bytes: usize = device_scene.buffers.bytes().iter().map(|list| list.bytes.len()).sum();

    let start = Instant::now();
    let session = device.load(&device_scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let mut renderer = Renderer::new(session, &device_scene, 0..u32::MAX);
    let (mut seconds, mut samples) = (0.0, 0);
    while seconds < LONG_ENOUGH {
        renderer.advance()?;
        let progress = renderer.progress();
        (seconds, samples) = (progress.seconds, progress.total_samples);
    }
    let film = renderer.session().film()?;
    let counted: u64 = film.pixels().iter().map(|pixel| u64::from(pixel.samples)).sum();
    let rays: u64 = film.pixels().iter().map(|pixel| u64::from(pixel.rays)).sum();
    let rate = rays as f64 / counted as f64 * samples as f64 / seconds;
    println!(
        "| {level} | {triangles} | {build_seconds:.2} | {load_seconds:.2} | {:.1} | {:.1} | {:.1} |",
        triangles as f64 / build_seconds / 1e6,
        bytes as f64 / triangles as f64,
        rate / 1e6
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).peekable();
    let choice = match arguments.next_if(|argument| argument.parse::<u32>().is_err()).as_deref() {
        None | Some("cpu") => DeviceChoice::Cpu,
        Some("vulkan") => DeviceChoice::Vulkan(None),
        Some(other) => return Err(format!("`{other}` is no device: give cpu or vulkan").into()),
    };
    let levels: Vec<u32> = arguments.map(|argument| argument.parse()).collect::<Result<_, _>>()?;
    let device = open(choice, OpenOptions::default(), |_| ())?;
    println!("{}", device.name());
    println!("| level | triangles | build, s | load, s | Mtriangles/s | bytes/triangle | Mrays/s |");
    println!("|---|---|---|---|---|---|---|");
    let levels = if levels.is_empty() { vec![6, 7, 8] } else { levels };
    levels.into_iter().try_for_each(|level| measure(&*device, level))
}
