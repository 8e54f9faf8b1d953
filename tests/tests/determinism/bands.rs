//! Large films lie in several buffers on a GPU, and everything is released in order.

use raggio_render::{Comparison, Device, DeviceScene, Display, Feature, Image, Tracer, VulkanDevice};
use raggio_scene::Scene;
use raggio_tests::devices::{cpu, vulkan};
use raggio_tests::render::{displayed, load, means, relative_difference};
use raggio_tests::{parse, render};
use raggio_vulkan::Instance;

/// A film of 1500 x 1200 pixels takes 108 MB, more than one buffer of 64 MiB.
#[test]
fn a_film_of_two_bands_is_one_picture() {
    let Some(vulkan) = vulkan() else { return };
    let mut scene = Scene::parse(crate::determinism::NESTED, "nested.toml").expect("the scene is valid");
    (scene.render.width, scene.render.height) = (1500, 1200);
    let (ours, theirs) = (render(vulkan, &scene, 1), render(cpu(), &scene, 1));
    let near = means(&ours).into_iter().zip(means(&theirs)).filter(|(a, b)| relative_difference(*a, *b) < 1e-5).count();
    let pixels = ours.pixels().len();
    assert!(ours.pixels().iter().all(|pixel| pixel.samples == 1), "every pixel has its sample");
    assert!(near > pixels * 99 / 100, "expected 99 % of {pixels} pixels to agree to 1e-5, found {near}");
}

/// The second band is displayed below the first, with its own part of the reference; so are the bands of a feature.
#[test]
fn two_bands_are_displayed_as_one_picture() {
    let Some(vulkan) = vulkan() else { return };
    let scene = parse(
        "[render]\nwidth = 1500\nheight = 1200\n[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 1]\n
         vertical_fov_degrees = 60\n[environment]\nhorizon = [1, 0.5, 0.2]\nzenith = [0.1, 0.3, 0.9]\n",
    );
    let row = |y: u32| vec![[y as f32 / 1200.0, 0.5, 1.0 - y as f32 / 1200.0]; 1500];
    let reference = Image { width: 1500, height: 1200, pixels: (0..1200).flat_map(row).collect(), alpha: None };
    let display = Display { comparison: Comparison::Split, split: 700, ..Display::default() };
    let show = |device: &dyn Device| {
        let mut session = load(device, &scene);
        session.add_samples(0..1200, 0..1).expect("samples are added");
        session.set_reference(Some(&reference)).expect("the reference is taken");
        let picture = displayed(&mut *session, display);
        session.show(Feature::Hit).expect("the feature is shown");
        session.add_samples(0..1200, 0..1).expect("samples are added");
        let film = session.film().expect("the film is read");
        assert!(film.pixels().iter().all(|pixel| pixel.samples == 1 && pixel.mean() == [0.0; 3]), "{}", device.name());
        picture
    };
    let (ours, theirs) = (show(vulkan), show(cpu()));
    let differ = ours.iter().zip(&theirs).position(|(a, b)| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1));
    assert_eq!(differ, None, "the first pixel that differs");
    assert_eq!(vulkan.validation_messages(), [""; 0]);
}

/// The validation layers notice what is destroyed too early or not at all when the device goes.
#[test]
fn devices_go_without_a_complaint() {
    if vulkan().is_none() {
        return;
    }
    let instance = Instance::new(true).expect("Vulkan was there a moment ago");
    let physical = instance.devices().expect("devices are listed");
    let device = VulkanDevice::new(&physical[0], Tracer::Software, None, true).expect("the device opens");
    let scene = Scene::parse(crate::determinism::EVERYTHING, "scene.toml").expect("the scene is valid");
    let mut session = device.load(&DeviceScene::new(&scene).expect("the scene fits")).expect("the scene loads");
    session.add_samples(0..8, 0..1).expect("samples are added");
    session.film().expect("the film is read");
    drop(session);
    drop(device);
    assert_eq!(instance.validation_messages(), [""; 0]);
}
