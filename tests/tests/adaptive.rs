//! Sampling until the error is small enough: no bias, and less work than sampling everything alike.

use raggio_render::{CpuDevice, CpuOptions, Device, DeviceScene, Film, Renderer};
use raggio_scene::Scene;
use raggio_tests::devices::{cpu, vulkan};
use raggio_tests::render;
use raggio_tests::statistics::sidak;
use statrs::distribution::{ContinuousCDF, Normal};

const SIDE: u32 = 32;
const CORNELL: &str = include_str!("../../scenes/reference/cornell.toml");
const LAMP: &str = include_str!("../../scenes/reference/lamp.toml");

fn scene(text: &str, seed: u32) -> Scene {
    let mut scene = Scene::parse(text, "scene.toml").expect("the scene is valid");
    (scene.render.width, scene.render.height, scene.render.seed) = (SIDE, SIDE, seed);
    scene
}

/// Sampled until its error is below `noise`, in passes of `pass` samples.
fn adaptive(device: &dyn Device, scene: &Scene, noise: f64, pass: Option<u32>) -> Film {
    let session = device.load(&DeviceScene::new(scene).expect("the scene fits devices")).expect("the scene loads");
    let mut renderer = Renderer::new(session, SIDE, SIDE, 1 << 16);
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

/// Mean and its squared standard error of each block, over repetitions.
fn summary(runs: &[Vec<f64>]) -> Vec<(f64, f64)> {
    let count = runs.len() as f64;
    let block = |i: usize| {
        let mean = runs.iter().map(|run| run[i]).sum::<f64>() / count;
        let spread = runs.iter().map(|run| (run[i] - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (mean, spread / count)
    };
    (0..runs[0].len()).map(block).collect()
}

/// Two-sided Z-tests of all blocks against samples that nobody chose, together at one in a thousand. A lucky early look is
/// what could make it too dark; the lamp's light is found by chance alone, so that there is luck to be had.
#[test]
fn choosing_where_to_sample_leaves_no_bias() {
    const RUNS: u32 = 48;
    let found: Vec<_> = (0..RUNS).map(|seed| blocks(&adaptive(cpu(), &scene(LAMP, seed), 0.25, None))).collect();
    let expected: Vec<_> = (0..8).map(|seed| blocks(&render(cpu(), &scene(LAMP, 1000 + seed), 2048))).collect();
    let (found, expected) = (summary(&found), summary(&expected));
    let normal = Normal::standard();
    let significance = sidak(1e-3, found.len());
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let z = (found.0 - expected.0) / (found.1 + expected.1).sqrt().max(1e-12);
        let p = 2.0 * normal.sf(z.abs());
        assert!(p > significance, "block {i}: expected {expected:?}, found {found:?}, z = {z:.2}");
    }
}

/// Mean over the pixels of the squared error, in parts of the pixel's luminance and a hundredth of the picture's.
fn relative_error(film: &Film, exact: &Film) -> f64 {
    let luminances = || exact.pixels().iter().map(|pixel| pixel.luminance());
    let count = exact.pixels().len() as f64;
    let least = 0.01 * luminances().sum::<f64>() / count;
    let error =
        |(pixel, exact): (&raggio_render::FilmPixel, f64)| ((pixel.luminance() - exact) / (exact + least)).powi(2);
    film.pixels().iter().zip(luminances()).map(error).sum::<f64>() / count
}

/// As many samples spread evenly leave a larger error.
#[test]
fn samples_go_where_the_error_is() {
    for (name, text, noise, exact) in [("lamp", LAMP, 0.2, 32_768), ("cornell", CORNELL, 0.1, 8192)] {
        let exact = render(cpu(), &scene(text, 99), exact);
        let (mut adapted, mut even) = (0.0, 0.0);
        for seed in 0..4 {
            let scene = scene(text, seed);
            let film = adaptive(cpu(), &scene, noise, None);
            let samples = film.samples().div_ceil(u64::from(SIDE * SIDE)) as u32;
            adapted += relative_error(&film, &exact);
            even += relative_error(&render(cpu(), &scene, samples), &exact);
        }
        println!("{name}: evenly, the squared error is {:.2} times as large", even / adapted);
        assert!(adapted < 0.95 * even, "{name}: expected less than {even}, found {adapted}");
    }
}

/// Decisions fall at fixed numbers of samples, so threads and passes leave no trace.
#[test]
fn adaptive_pictures_are_reproducible() {
    let scene = scene(CORNELL, 3);
    let options = CpuOptions { threads: 1, tile_rows: 7, ..CpuOptions::default() };
    let other = CpuDevice::new(options).expect("the CPU is there");
    let film = adaptive(cpu(), &scene, 0.3, None);
    let (fewest, most) = film.sample_range();
    assert!(fewest >= 64 && most > fewest, "{fewest} to {most} samples");
    assert!(film == adaptive(&other, &scene, 0.3, Some(13)), "passes of 13 samples make another picture");
    let Some(vulkan) = vulkan() else { return };
    let lamp = adaptive(vulkan, &scene, 0.3, None);
    let mean = |film: &Film| blocks(film).iter().sum::<f64>();
    assert!((mean(&lamp) / mean(&film) - 1.0).abs() < 1e-2, "Vulkan's picture is another");
    assert!(lamp.sample_range().0 >= 64 && lamp.sample_range().1 > lamp.sample_range().0);
}
