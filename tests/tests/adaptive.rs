//! Sampling until the error is small enough: no bias, and less work than sampling everything alike.

use raggio_render::{CpuDevice, CpuOptions, Device, DeviceScene, Film, Renderer};
use raggio_scene::{Integrator, Scene};
use raggio_tests::devices::{cpu, vulkan};
use raggio_tests::render;
use raggio_tests::statistics::sidak;
use statrs::distribution::{ContinuousCDF, Normal};

const SIDE: u32 = 64;
const CORNELL: &str = include_str!("../../scenes/reference/cornell.toml");
const LAMP: &str = include_str!("../../scenes/reference/lamp.toml");

fn scene(text: &str, integrator: Integrator, seed: u32) -> Scene {
    let mut scene = Scene::parse(text, "scene.toml").expect("the scene is valid");
    scene.render.integrator = integrator;
    (scene.render.width, scene.render.height, scene.render.seed) = (SIDE, SIDE, seed);
    scene
}

/// Renders the scene until its error is below `noise`, in passes of `pass` samples.
fn adaptive(device: &dyn Device, scene: &Scene, noise: f64, pass: Option<u32>) -> Film {
    let device_scene = DeviceScene::new(scene).expect("the scene fits devices");
    let session = device.load(&device_scene).expect("the scene loads");
    let mut renderer = Renderer::new(session, &device_scene, 0..1 << 16);
    renderer.set_noise(noise);
    renderer.set_samples_per_pass(pass);
    while !renderer.finished() {
        renderer.advance().expect("the device renders");
    }
    let film = renderer.film().expect("the film is read");
    assert_eq!(renderer.progress().total_samples, film.samples() + film.rejected(), "samples are counted");
    film
}

/// Mean luminance of each block of 8 x 8 pixels.
fn blocks(film: &Film) -> Vec<f64> {
    let side = SIDE as usize;
    let block = |i: usize| {
        let (left, top) = (i % (side / 8) * 8, i / (side / 8) * 8);
        (0..64).map(|j| film.pixels()[(top + j / 8) * side + left + j % 8].luminance()).sum::<f64>() / 64.0
    };
    (0..side * side / 64).map(block).collect()
}

/// Mean of each block over repetitions, and the squared standard error of that.
fn summary(runs: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let count = runs.len() as f64;
    let block = |i: usize| {
        let mean = runs.iter().map(|run| run[i]).sum::<f64>() / count;
        let spread = runs.iter().map(|run| (run[i] - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (mean, spread / count)
    };
    (0..runs[0].len()).map(block).collect()
}

/// Z-tests, two-sided, compare all blocks with samples that nobody chose, together at one in a thousand. A lucky early
/// look is what could make the picture too dark; the lamp's light is found by chance alone, so that there is luck to be
/// had.
#[test]
fn choosing_where_to_sample_leaves_no_bias() {
    const RUNS: u32 = 24;
    let found: Vec<_> =
        (0..RUNS).map(|seed| blocks(&adaptive(cpu(), &scene(LAMP, Integrator::Reference, seed), 1.0, None))).collect();
    let expected: Vec<_> =
        (0..8).map(|seed| blocks(&render(cpu(), &scene(LAMP, Integrator::Reference, 1000 + seed), 1024))).collect();
    let (found, expected) = (summary(&found), summary(&expected));
    let normal = Normal::standard();
    let significance = sidak(1e-3, found.len());
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let z = (found.0 - expected.0) / (found.1 + expected.1).sqrt().max(1e-12);
        let p = 2.0 * normal.sf(z.abs());
        assert!(p > significance, "block {i}: expected {expected:?}, found {found:?}, z = {z:.2}");
    }
}

/// Mean squared error of each block's pixels, in parts of its luminance and a hundredth of the picture's.
fn relative_errors(film: &Film, exact: &Film) -> Vec<f64> {
    let side = SIDE as usize;
    let luminance = blocks(exact);
    let least = 0.01 * luminance.iter().sum::<f64>() / luminance.len() as f64;
    let mut errors = vec![0.0; luminance.len()];
    for (i, (found, exact)) in film.pixels().iter().zip(exact.pixels()).enumerate() {
        let block = i / side / 8 * (side / 8) + i % side / 8;
        errors[block] += ((found.luminance() - exact.luminance()) / (luminance[block] + least)).powi(2) / 64.0;
    }
    errors
}

/// Samples spread evenly, as many, leave a larger error where it is largest, which is what is asked to be small; and
/// with a lamp that little of the picture sees, a larger error on average too.
#[test]
fn samples_go_where_the_error_is() {
    let lamp = ("lamp", LAMP, Integrator::Reference, 1.0, 16_384);
    let cornell = ("cornell", CORNELL, Integrator::Path, 0.15, 2048);
    for (name, text, integrator, noise, exact) in [lamp, cornell] {
        let exact = render(cpu(), &scene(text, integrator, 99), exact);
        let mut sums = [vec![0.0; blocks(&exact).len()], vec![0.0; blocks(&exact).len()]];
        for seed in 0..4 {
            let scene = scene(text, integrator, seed);
            let film = adaptive(cpu(), &scene, noise, None);
            let samples = film.samples().div_ceil(u64::from(SIDE * SIDE)) as u32;
            for (sum, film) in sums.iter_mut().zip([film, render(cpu(), &scene, samples)]) {
                sum.iter_mut().zip(relative_errors(&film, &exact)).for_each(|(sum, error)| *sum += error);
            }
        }
        let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
        let average = mean(&sums[1]) / mean(&sums[0]);
        let worst = sums.map(|mut errors| {
            errors.sort_by(f64::total_cmp);
            mean(&errors[errors.len() * 9 / 10..])
        });
        let worst = worst[1] / worst[0];
        println!("{name}: evenly, the squared error is {average:.2} times as large, in the worst blocks {worst:.2}");
        assert!(worst > 1.1, "{name}: in the worst blocks only {worst:.2} times");
        assert!(name == "cornell" || average > 1.05, "{name}: only {average:.2} times");
    }
}

/// Decisions fall at fixed numbers of samples, so threads and passes leave no trace.
#[test]
fn adaptive_pictures_are_reproducible() {
    let scene = scene(CORNELL, Integrator::Path, 3);
    let options = CpuOptions { threads: 1, tile_rows: 7, ..CpuOptions::default() };
    let other = CpuDevice::new(options).expect("the CPU is there");
    let film = adaptive(cpu(), &scene, 0.15, None);
    let (fewest, most) = film.sample_range();
    assert!(fewest >= 64 && most > fewest, "{fewest} to {most} samples");
    assert!(film == adaptive(&other, &scene, 0.15, Some(13)), "passes of 13 samples make another picture");
    let Some(vulkan) = vulkan() else { return };
    let lamp = adaptive(vulkan, &scene, 0.15, None);
    let mean = |film: &Film| blocks(film).iter().sum::<f64>();
    assert!((mean(&lamp) / mean(&film) - 1.0).abs() < 1e-2, "Vulkan's picture is another");
    assert!(lamp.sample_range().0 >= 64 && lamp.sample_range().1 > lamp.sample_range().0);
}
