//! One picture, divided in many ways.

use std::ops::Range;

use raggio_render::{CpuDevice, CpuOptions, Device, DeviceScene, Film, InstructionSet, Renderer};
use raggio_scene::{Sampler, Scene};
use raggio_tests::{for_each_device, render, render_range};

use crate::determinism::{scenes, scenes_of_all_kinds};

const SAMPLES: u32 = 20;

/// Renders `rows` before the others and in passes of `pass` samples.
fn in_passes(device: &dyn Device, scene: &Scene, pass: u32, rows: Range<u32>) -> Film {
    let device_scene = DeviceScene::new(scene).expect("the scene fits devices");
    let mut session = device.load(&device_scene).expect("the scene loads");
    for band in [rows.clone(), 0..rows.start, rows.end..scene.render.height] {
        for first in (0..SAMPLES).step_by(pass as usize) {
            let samples = first..SAMPLES.min(first + pass);
            session.add_samples(band.clone(), samples).expect("the device renders");
        }
    }
    session.film().expect("the film can be read")
}

/// Checks that films are equal in all their bits, counters included.
fn assert_same(what: &str, expected: &Film, found: &Film) {
    let differ = expected.pixels().iter().zip(found.pixels()).position(|(a, b)| a != b);
    if let Some(place) = differ {
        let (x, y) = (place % expected.width() as usize, place / expected.width() as usize);
        let [a, b] = [expected, found].map(|film| film.pixels()[place]);
        panic!("{what}: pixel ({x}, {y}) is the first to differ: expected {a:?}, found {b:?}");
    }
    assert_eq!(expected, found, "{what}");
}

#[test]
fn passes_and_bands_leave_no_trace() {
    for_each_device(|device| {
        for (name, scene) in scenes() {
            let expected = render(device.device, &scene, SAMPLES);
            for (pass, rows) in [(1, 0..33), (7, 0..33), (SAMPLES, 5..6), (7, 13..29), (1, 31..33)] {
                let found = in_passes(device.device, &scene, pass, rows.clone());
                let what = format!("{} {name}, passes of {pass} samples, rows {rows:?} first", device.label);
                assert_same(&what, &expected, &found);
            }
        }
    });
}

#[test]
fn ranges_of_samples_merge_to_the_whole() {
    for_each_device(|device| {
        for (name, scene) in scenes() {
            let expected = render(device.device, &scene, SAMPLES);
            let mut merged = render_range(device.device, &scene, 9..SAMPLES);
            let first = render_range(device.device, &scene, 0..9);
            merged.merge(&first).expect("films of one size");
            assert_same(&format!("{} {name}, samples 9..{SAMPLES} and 0..9 merged", device.label), &expected, &merged);
        }
    });
}

/// Renderers choose passes by their speed; films of their ranges still merge to the picture of one call.
#[test]
fn renderers_of_ranges_merge_to_the_whole() {
    for_each_device(|device| {
        for (name, mut scene) in scenes() {
            for sampler in [Sampler::Sobol, Sampler::Pcg] {
                scene.render.sampler = sampler;
                let device_scene = DeviceScene::new(&scene).expect("the scene fits devices");
                let film = |samples: Range<u32>| {
                    let session = device.device.load(&device_scene).expect("the scene loads");
                    let mut renderer = Renderer::new(session, &device_scene, samples.clone());
                    while !renderer.finished() {
                        renderer.advance().expect("the device renders");
                    }
                    assert_eq!(renderer.progress().samples, samples.end - samples.start);
                    renderer.film().expect("the film can be read")
                };
                let mut merged = film(13..SAMPLES);
                for range in [0..5, 5..13] {
                    merged.merge(&film(range)).expect("films of one size");
                }
                let expected = render(device.device, &scene, SAMPLES);
                assert_same(&format!("{} {name}, {sampler:?}, ranges merged", device.label), &expected, &merged);
            }
        }
    });
}

#[test]
fn threads_and_tiles_leave_no_trace() {
    for (name, scene) in scenes_of_all_kinds() {
        let film = |threads, tile_rows| {
            let options = CpuOptions { threads, tile_rows, ..CpuOptions::default() };
            render(&CpuDevice::new(options).expect("threads can be had"), &scene, SAMPLES)
        };
        let expected = film(1, 4);
        for (threads, tile_rows) in [(2, 4), (1, 1), (2, 1), (2, 3), (2, 8), (5, 1000)] {
            let what = format!("{name}, {threads} threads, tiles of {tile_rows} rows");
            assert_same(&what, &expected, &film(threads, tile_rows));
        }
    }
}

#[test]
fn instruction_sets_leave_no_trace() {
    let sets = InstructionSet::available();
    println!("instruction sets: {sets:?}");
    // Two sets are needed, or this test compares nothing: every x86-64 processor of the last ten years has v3 beside
    // v2.
    assert!(sets.len() >= 2 || !cfg!(target_arch = "x86_64"), "only {sets:?} to compare");
    for (name, scene) in scenes_of_all_kinds() {
        let films = sets.iter().map(|&set| {
            let options = CpuOptions { instruction_set: Some(set), ..CpuOptions::default() };
            render(&CpuDevice::new(options).expect("the set is available"), &scene, SAMPLES)
        });
        let films: Vec<_> = films.collect();
        for (set, film) in sets.iter().zip(&films) {
            assert_same(&format!("{name}, {}", set.name()), &films[0], film);
        }
    }
}

#[test]
fn seeds_give_different_pictures() {
    for_each_device(|device| {
        for (name, mut scene) in scenes() {
            let one = render(device.device, &scene, 4);
            scene.render.seed += 1;
            let other = render(device.device, &scene, 4);
            let same = one.pixels().iter().zip(other.pixels()).filter(|(a, b)| a == b).count();
            // A plain sky is equal for all seeds; it fills no more than two thirds of any of the pictures.
            let pixels = one.pixels().len();
            assert!(
                same < pixels * 2 / 3,
                "{} {name}: {same} of {pixels} pixels are alike for two seeds",
                device.label
            );
        }
    });
}
