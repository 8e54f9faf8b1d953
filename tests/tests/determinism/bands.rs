//! Large films lie in several buffers on a GPU, and everything is released in order.

use raggio_render::{Device, DeviceScene, VulkanDevice};
use raggio_scene::Scene;
use raggio_tests::devices::{cpu, vulkan};
use raggio_tests::render;
use raggio_tests::render::{means, relative_difference};
use raggio_vulkan::Instance;

/// 1500 x 1200 pixels of film take 86 MB, more than one buffer of 64 MiB.
#[test]
fn a_film_of_two_bands_is_one_picture() {
    let Some(vulkan) = vulkan() else { return };
    let mut scene = Scene::parse(crate::NESTED, "nested.toml").expect("the scene is valid");
    (scene.render.width, scene.render.height) = (1500, 1200);
    let (ours, theirs) = (render(vulkan, &scene, 1), render(cpu(), &scene, 1));
    let near = means(&ours).into_iter().zip(means(&theirs)).filter(|(a, b)| relative_difference(*a, *b) < 1e-5).count();
    let pixels = ours.pixels().len();
    assert!(ours.pixels().iter().all(|pixel| pixel.samples == 1), "every pixel has its sample");
    assert!(near > pixels * 99 / 100, "expected 99 % of {pixels} pixels to agree to 1e-5, found {near}");
}

/// The validation layers notice what is destroyed too early or not at all when the device goes.
#[test]
fn devices_go_without_a_complaint() {
    if vulkan().is_none() {
        return;
    }
    let instance = Instance::new(true).expect("Vulkan was there a moment ago");
    let physical = instance.devices().expect("devices are listed");
    let device = VulkanDevice::new(&physical[0]).expect("the device opens");
    let scene = Scene::parse(crate::EVERYTHING, "scene.toml").expect("the scene is valid");
    let mut session = device.load(&DeviceScene::new(&scene).expect("the scene fits")).expect("the scene loads");
    session.add_samples(0..8, 0..1).expect("samples are added");
    session.film().expect("the film is read");
    drop(session);
    drop(device);
    assert_eq!(instance.validation_messages(), [""; 0]);
}
