//! Kernels with bounds checks: a read outside a buffer ends the program, and checks leave no trace in the picture.

use raggio_render::{CpuDevice, CpuOptions, InstructionSet};
use raggio_scene::{Integrator, Scene};
use raggio_tests::devices::{cpu, lacks};
use raggio_tests::render::render;

const SAMPLES: u32 = 16;

#[test]
fn kernels_stay_inside_their_buffers() {
    if !InstructionSet::available().contains(&InstructionSet::Checked) {
        return lacks("kernels with bounds checks are not built: set RAGGIO_KERNEL_LEVELS=all, as `make test` does");
    }
    let options = CpuOptions { instruction_set: Some(InstructionSet::Checked), ..CpuOptions::default() };
    let checked = CpuDevice::new(options).expect("the set is available");
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");
    for name in [
        "showcase",
        "materials",
        "reference/cornell",
        "reference/spheres",
        "reference/nested",
        "reference/lamp",
        "reference/weekend",
        "reference/media",
    ] {
        let mut scene = Scene::load(format!("{folder}/{name}.toml").as_ref()).expect("the scene is valid");
        (scene.render.width, scene.render.height) = (160, 90);
        for integrator in [Integrator::Path, Integrator::Reference] {
            scene.render.integrator = integrator;
            // A read outside a buffer ends the program here.
            let film = render(&checked, &scene, SAMPLES);
            assert!(film.pixels() == render(cpu(), &scene, SAMPLES).pixels(), "{name}: checks change the picture");
        }
    }
}
