//! Speed of following given rays through a scene's hierarchy, on one thread of the CPU.
//!
//! `cargo run --release -p raggio-render --example trace -- SCENE RAYS DISTANCES`: RAYS holds origin and direction of each
//! ray, six floats of 32 bits; the distances of what they meet go to DISTANCES, as floats too, -1 where that is nothing.
//! For every line of its input the program then traces all rays once more and prints the seconds that it took.

use std::io::BufRead;
use std::path::Path;
use std::time::Instant;

use raggio_kernels::cpu::{CpuScene, InstructionSet, TracedHit, TracedRay, Walk, follow};
use raggio_render::DeviceScene;
use raggio_scene::{Integrator, Scene};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let [scene, rays, distances] = &arguments[..] else {
        return Err("usage: trace SCENE RAYS DISTANCES".into());
    };
    let mut scene = Scene::load(Path::new(scene))?;
    scene.render.integrator = Integrator::Path;
    let numbers: Vec<f32> = bytemuck::pod_collect_to_vec(&std::fs::read(rays)?);
    let (numbers, rest) = numbers.as_chunks::<6>();
    if !rest.is_empty() {
        return Err("RAYS does not hold six numbers for each ray".into());
    }
    let ray =
        |&[x, y, z, u, v, w]: &[f32; 6]| TracedRay { origin: [x, y, z], direction: [u, v, w], key: 0, any: false };
    let rays: Vec<_> = numbers.iter().map(ray).collect();
    let mut hits = vec![TracedHit::NOTHING; rays.len()];

    let set = InstructionSet::best().ok_or("this processor is too old for the kernels")?;
    let scene = CpuScene::new(DeviceScene::new(&scene)?.buffers, set, Walk::default())?;
    follow(set, &scene, &rays, &mut hits);
    let found = |hit: &TracedHit| if hit.distance.is_finite() { hit.distance } else { -1.0 };
    let found: Vec<f32> = hits.iter().map(found).collect();
    std::fs::write(distances, bytemuck::cast_slice(&found))?;
    println!("{} kernels", set.name());
    for line in std::io::stdin().lock().lines() {
        line?;
        let start = Instant::now();
        hits.fill(TracedHit::NOTHING);
        follow(set, &scene, &rays, &mut hits);
        println!("{}", start.elapsed().as_secs_f64());
    }
    Ok(())
}
