//! Pictures of Mitsuba 3 (`tests/data/reference`, 16,384 samples per pixel), and ours of the same scenes.

use std::path::{Path, PathBuf};

use raggio_render::Image;
use raggio_scene::{Integrator, Scene};
use raggio_tests::compare::{difference, leave_behind, read_exr, scores};
use raggio_tests::devices::{cpu, long, open_specialised_vulkan, vulkan};
use raggio_tests::render::{means, relative_difference};
use raggio_tests::{for_each_device, render};

/// Scenes with the samples per pixel of the naive path tracer, and those at which the devices are compared with each other.
const SCENES: [(&str, u32, u32); 5] = [
    ("cornell", 4096, 192),
    ("spheres", 1024, 768),
    ("nested", 1024, 768),
    ("lamp", 4096, 768),
    ("weekend", 1024, 192),
];

fn scene(name: &str) -> Scene {
    Scene::load(&root().join(format!("../scenes/reference/{name}.toml"))).unwrap_or_else(|error| panic!("{error}"))
}

fn reference(name: &str) -> Image {
    read_exr(&root().join(format!("data/reference/{name}.exr")))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).into()
}

fn naive_samples(name: &str) -> u32 {
    SCENES.iter().find(|scene| scene.0 == name).expect("a listed scene").1
}

/// Samples per pixel that are enough for every scene where light is looked for.
const PATH_SAMPLES: u32 = 1024;

/// Compares the picture with the reference, on the CPU and on Vulkan.
fn matches_reference(name: &str, integrator: Integrator) {
    let samples = if integrator == Integrator::Path { PATH_SAMPLES } else { naive_samples(name) };
    looks_like_reference(name, scene(name), integrator, samples);
}

/// The naive path tracer finds the small lamp so seldom that blocks would come within the bounds at 16,384 samples only.
/// At a quarter of these the mean must be as near as ever, and the blocks as near as their own noise lets them.
fn is_reference_with_noise(name: &str) {
    let (reference, samples) = (reference(name), naive_samples(name));
    let mut scene = scene(name);
    scene.render.integrator = Integrator::Reference;
    for_each_device(|device| {
        if device.slow {
            return;
        }
        let film = render(device.device, &scene, samples);
        assert_eq!(film.rejected(), 0, "{name}: samples without a finite value");
        let scores = scores(&reference, &film);
        let mean = difference(&reference, &film.mean()).mean;
        let bias = scores.iter().sum::<f64>() / (scores.len() as f64).sqrt();
        let spread = (scores.iter().map(|score| score * score).sum::<f64>() / scores.len() as f64).sqrt();
        let largest = scores.iter().map(|score| score.abs()).fold(0.0, f64::max);
        println!("{name}, {}: mean {mean:.5}, bias {bias:.2}, spread {spread:.3}, largest {largest:.2}", device.label);
        if mean > 0.005 || bias.abs() > 3.0 || spread > 1.0 || largest > 4.5 {
            let folder = leave_behind(&format!("{name}-noise"), &reference, &film.mean());
            panic!(
                "{name} on {} at {samples} samples: expected a mean within 0.5 % of the reference, found {:.2} %; blocks \
                 with a standard normal distribution of errors, found a joint bias of {bias:.2}, a spread of \
                 {spread:.3} and {largest:.2} as the largest; see {}/{name}-noise-*.png",
                device.label,
                100.0 * mean,
                folder.display()
            );
        }
    });
}

fn looks_like_reference(name: &str, mut scene: Scene, integrator: Integrator, samples: u32) {
    let reference = reference(name);
    scene.render.integrator = integrator;
    for_each_device(|device| {
        // Software Vulkan would take minutes; that it draws what the CPU does, pixel by pixel, is tested below.
        if device.slow && (integrator == Integrator::Reference || !long()) {
            return;
        }
        let film = render(device.device, &scene, samples);
        let label = format!("{name}-{integrator:?}-{}", device.label).to_lowercase();
        assert_eq!(film.rejected(), 0, "{label}: samples without a finite value");
        let image = film.mean();
        let found = difference(&reference, &image);
        println!("{label}: {found:?}");
        if !found.within_bounds() {
            let folder = leave_behind(&label, &reference, &image);
            panic!(
                "{label} at {samples} samples: expected a mean within 0.5 %, a median block within 1 %, the 95th \
                 percentile within 4 % of the reference, found {found:?}; see {}/{label}-*.png",
                folder.display()
            );
        }
    });
}

#[test]
fn cornell() {
    matches_reference("cornell", Integrator::Reference);
}

#[test]
fn spheres() {
    matches_reference("spheres", Integrator::Reference);
}

#[test]
fn nested() {
    matches_reference("nested", Integrator::Reference);
}

#[test]
fn lamp() {
    is_reference_with_noise("lamp");
}

#[test]
fn weekend() {
    matches_reference("weekend", Integrator::Reference);
}

mod path {
    use std::fs;

    use super::{Integrator, PATH_SAMPLES, Scene, looks_like_reference, matches_reference, root};

    #[test]
    fn cornell() {
        matches_reference("cornell", Integrator::Path);
    }

    #[test]
    fn spheres() {
        matches_reference("spheres", Integrator::Path);
    }

    #[test]
    fn nested() {
        matches_reference("nested", Integrator::Path);
    }

    #[test]
    fn lamp() {
        matches_reference("lamp", Integrator::Path);
    }

    #[test]
    fn weekend() {
        matches_reference("weekend", Integrator::Path);
    }

    /// Fog, smoke, and milk behind a smooth boundary; the picture is of `volpath` (`tests/data/reference/media.py`).
    #[test]
    fn media() {
        looks_like_reference("media", super::scene("media"), Integrator::Path, 4096);
    }

    /// The scene's model and sky are others' files, and not in the project.
    #[test]
    fn bunny() {
        let models = ["tests/data/models", "../shared/models"].map(|folder| root().join("..").join(folder));
        let Some(models) = models.iter().find(|folder| folder.join("bunny.ply").exists()) else {
            eprintln!("skipped: tests/data/models/ has neither bunny.ply nor spiaggia_di_mondello_1k.hdr");
            return;
        };
        let text = fs::read_to_string(root().join("data/reference/bunny.toml")).expect("the scene is there");
        // The scene is read as if it stood where its `../models` are those.
        let scene = Scene::parse(&text, &models.join("../reference/bunny.toml").display().to_string());
        let scene = scene.unwrap_or_else(|error| panic!("{error}"));
        looks_like_reference("bunny", scene, Integrator::Path, PATH_SAMPLES);
    }
}

/// Both devices draw from one sequence of random numbers, so at equal samples they must agree to rounding. A path whose
/// decision a rounding turned is another sample of its pixel. On lavapipe 12,288 of the 12,288 pixels agree to 1e-5 in
/// the first four scenes and 12,033 in the last, whose paths meet hundreds of small spheres; the means agree to 5e-7.
/// The path tracer has kernels that are specialised for each scene, in software too, and the reference general ones there.
/// GPUs fuse multiplications and additions: on an H200 12,179 agree, 10,128 in the last, and the means agree to 2e-6.
#[test]
fn vulkan_draws_the_pictures_of_the_cpu() {
    let (Some(vulkan), Some(specialised)) = (vulkan(), open_specialised_vulkan()) else { return };
    let is_software = vulkan.vulkan().is_some_and(|context| context.physical().kind.name() == "software");
    let (least, p95) = if is_software { (95, 2e-4) } else { (80, 4e-4) };
    let integrators = [(Integrator::Reference, 1), (Integrator::Path, 4)];
    for ((name, _, samples), (integrator, divisor)) in
        SCENES.into_iter().flat_map(|scene| integrators.map(|integrator| (scene, integrator)))
    {
        let mut scene = scene(name);
        scene.render.integrator = integrator;
        let samples = samples / divisor;
        let device = if integrator == Integrator::Path { &*specialised } else { vulkan };
        let (ours, theirs) = (render(device, &scene, samples), render(cpu(), &scene, samples));
        let equal =
            means(&ours).into_iter().zip(means(&theirs)).filter(|(a, b)| relative_difference(*a, *b) < 1e-5).count();
        let pixels = ours.pixels().len();
        let found = difference(&theirs.mean(), &ours.mean());
        println!("{name}: {equal} of {pixels} pixels agree to 1e-5; {found:?}");
        if equal < pixels * least / 100 || found.mean > 1e-5 || found.p95 > p95 {
            let folder = leave_behind(&format!("{name}-vulkan"), &theirs.mean(), &ours.mean());
            panic!(
                "{name} at {samples} samples: expected {least} % of pixels and the mean to agree with the CPU to 1e-5, \
                 found {equal} of {pixels} and {found:?}; see {}/{name}-vulkan-*.png",
                folder.display()
            );
        }
    }
    let messages = [vulkan.validation_messages(), specialised.validation_messages()].concat();
    assert!(messages.is_empty(), "Vulkan's validation layers complain:\n{}", messages.join("\n"));
}
