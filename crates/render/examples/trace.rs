//! Speed of tracing given rays through a scene, one by one on one thread of the CPU.
//!
//! `cargo run --release -p raggio-render --example trace -- SCENE RAYS DISTANCES`: RAYS holds origin and direction of each
//! ray, six floats of 32 bits; the distances of what they meet go to DISTANCES, as floats too, -1 where that is nothing.
//! For every line of its input the program then traces all rays once more and prints the seconds that it took.

use std::io::BufRead;
use std::path::Path;
use std::time::Instant;

use raggio_render::{CpuDevice, CpuOptions, Device, DeviceScene, Probe, Question};
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
    let question = |&[x, y, z, u, v, w]: &[f32; 6]| [[x, y, z, 0.0], [u, v, w, 0.0], [0.0; 4]];
    let questions: Vec<Question> = numbers.iter().map(question).collect();

    let device = CpuDevice::new(CpuOptions { threads: 1, ..CpuOptions::default() })?;
    let mut session = device.load(&DeviceScene::new(&scene)?)?;
    let answers = session.ask(Probe::Trace, &questions)?;
    let found: Vec<f32> = answers.iter().map(|answer| answer[0][0]).collect();
    std::fs::write(distances, bytemuck::cast_slice(&found))?;
    println!("{}", device.name());
    for line in std::io::stdin().lock().lines() {
        line?;
        let start = Instant::now();
        let answers = session.ask(Probe::Trace, &questions)?;
        println!("{}", start.elapsed().as_secs_f64());
        assert_eq!(answers.len(), questions.len());
    }
    Ok(())
}
