//! Scenes whose lists are larger than storage buffers may be.

use glam::{DAffine3, DVec3};
use raggio_render::{DeviceScene, Probe};
use raggio_scene::Scene;
use raggio_tests::devices::{cpu, open_vulkan};
use raggio_tests::{Pcg, TestDevice};

use crate::shapes::SingleRay;
use crate::shapes::meshes::{ball, scene_of};

/// Limit of a binding in bytes: less than the triangles take, more than anything else does.
const LIMIT: u64 = 300_000;
const RAYS: usize = 5000;

fn scene() -> Scene {
    let mut scene = scene_of(vec![(ball(60), DAffine3::from_scale(DVec3::splat(2.0)))], "");
    (scene.render.width, scene.render.height) = (64, 64);
    scene
}

fn distances(device: TestDevice, scene: &DeviceScene) -> Vec<f32> {
    let random = &mut Pcg::new(21);
    let rays = (0..RAYS).map(|_| SingleRay::new(random.in_cube(4.0), random.direction()));
    let questions: Vec<_> = rays.map(|ray| ray.question([0.0; 3])).collect();
    device.ask_in(scene, Probe::Trace, &questions).iter().map(|answer| answer[0][0]).collect()
}

#[test]
fn large_lists_are_reached_by_address() {
    let Some(device) = open_vulkan() else { return };
    let vulkan = device.vulkan().expect("it is one");
    if !vulkan.has_addresses() {
        return eprintln!("skipped: this device's kernels reach nothing by address");
    }
    let scene = DeviceScene::new(&scene()).expect("it can be translated");
    assert!(size_of_val(&scene.buffers.triangles[..]) as u64 > LIMIT);
    let small = distances(TestDevice { label: "cpu", slow: false, device: cpu() }, &scene);
    vulkan.pretend_small_bindings(LIMIT);
    // The device lives as long as its tests do elsewhere; here it is leaked for the same reason.
    let device: &'static _ = Box::leak(device);
    let wide = distances(TestDevice { label: "vulkan", slow: true, device }, &scene);

    let hits = small.iter().filter(|distance| **distance > 0.0).count();
    assert!(hits > RAYS / 10, "only {hits} of {RAYS} rays hit anything");
    let near = |(a, b): &(&f32, &f32)| (**a - **b).abs() <= 1e-5 * a.abs();
    let agreeing = small.iter().zip(&wide).filter(near).count();
    assert!(agreeing >= RAYS - 2, "{agreeing} of {RAYS} rays go as far as on the CPU");
    let messages = device.validation_messages();
    assert!(messages.is_empty(), "Vulkan's validation layers complain:\n{}", messages.join("\n"));
}

#[test]
fn what_no_kernel_can_reach_is_refused() {
    let Some(device) = open_vulkan() else { return };
    device.vulkan().expect("it is one").pretend_small_bindings(1 << 10);
    let scene = DeviceScene::new(&scene()).expect("it can be translated");
    // The film has no kernels that reach it by address.
    let error = device.load(&scene).err().expect("a film of 64x64 pixels takes more").to_string();
    assert!(
        error.starts_with("film needs 294912 bytes in one buffer, and ") && error.ends_with(" can take 1024 there"),
        "{error}"
    );
}
