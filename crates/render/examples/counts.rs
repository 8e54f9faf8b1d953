//! What the CPU's path tracer does for a sample, counted instead of timed.
//!
//! `cargo run --release -p raggio-render --example counts -- [SCENE | LEVEL] ...` prints a row for each scene file, or rock of
//! 20 * 4^LEVEL triangles: rays of a sample, nodes of eight children and blocks of four triangles or closed forms that these
//! rays are tested against, and the part of the lanes that has a path in each stage.

use std::path::Path;

use raggio_render::{Counted, DeviceScene, InstructionSet, Walk};
use raggio_scene::{Integrator, Scene};

const SIZE: [u32; 2] = [160, 120];
const SAMPLES: u32 = 16;

fn count(name: &str, set: InstructionSet) -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = match name.parse() {
        Ok(level) => Scene::rock(level),
        Err(_) => Scene::load(Path::new(name))?,
    };
    scene.render.integrator = Integrator::Path;
    [scene.render.width, scene.render.height] = SIZE;
    let Counted { samples, rays, counts, tried, bytes, .. } =
        Counted::render(&DeviceScene::new(&scene)?, set, Walk::default(), SAMPLES)?;
    let of_sample = |count: u64| format!("{:.4}", count as f64 / samples as f64);
    let work =
        [rays, counts.nodes, counts.triangle_blocks, counts.shape_blocks, rays * u64::from(tried)].map(of_sample);
    let stages = [counts.renew, counts.find, counts.shadow, counts.walk, counts.shade];
    let occupancies = stages.map(|stage| format!("{:.4}", stage.occupancy(set.lanes())));
    println!("| {name} | {} | {} | {bytes} |", work.join(" | "), occupancies.join(" | "));
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut names: Vec<_> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names = vec!["7".into()];
    }
    for set in InstructionSet::available() {
        println!("\n{}, {} paths at once, {}x{}, {SAMPLES} samples", set.name(), set.lanes(), SIZE[0], SIZE[1]);
        println!(
            "| scene | rays | nodes | triangles | shapes | tried | renew | find | shadow | walk | shade | bytes |"
        );
        println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
        names.iter().try_for_each(|name| count(name, set))?;
    }
    Ok(())
}
