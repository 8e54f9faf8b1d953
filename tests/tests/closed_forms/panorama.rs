//! Panoramas: what is seen all around.

use std::f64::consts::{PI, TAU};

use raggio_render::Feature;
use raggio_tests::render::{load, means};
use raggio_tests::{for_each_device, render};

use crate::closed_forms::{View, materials, shapes};

const PANORAMA: &str = "panorama = \"latitude-longitude\"";
const SIZE: [u32; 2] = [256, 128];

/// Solid angle of each pixel of a row.
fn solid_angle(row: usize) -> f64 {
    let edge = |row: usize| (PI * row as f64 / f64::from(SIZE[1])).cos();
    TAU / f64::from(SIZE[0]) * (edge(row) - edge(row + 1))
}

/// A lamp's sphere takes the solid angle that it should, wherever it is: ahead, behind over the seam, over a pole.
#[test]
fn spheres_have_their_solid_angle() {
    let view = View::new([1.0, 2.0, 3.0], [1.0, 2.0, 0.0], 40.0).size(SIZE[0], SIZE[1]).depth(1);
    for_each_device(|device| {
        for (offset, radius) in
            [([0.0, 0.0, -2.0], 0.5), ([0.05, 0.1, 3.0], 1.5), ([0.1, 2.0, 0.1], 0.9), ([0.0, -3.0, 0.2], 1.0)]
        {
            let [x, y, z] = offset;
            let shape = format!("sphere = {{ center = [{}, {}, {}], radius = {radius} }}", 1.0 + x, 2.0 + y, 3.0 + z);
            let rest =
                materials(&[("lamp", "color = [0, 0, 0]\nemission_strength = 1")]) + &shapes(&[("lamp", &shape)]);
            let scene = view.scene_with("", PANORAMA, &rest);
            let pixels = means(&render(device.device, &scene, device.pick(256, 64)));
            let found: f64 =
                pixels.iter().enumerate().map(|(i, mean)| mean.x * solid_angle(i / SIZE[0] as usize)).sum();
            let sine2: f64 = radius * radius / (x * x + y * y + z * z);
            let expected = TAU * (1.0 - (1.0 - sine2).sqrt());
            assert!((found / expected - 1.0).abs() < 2e-3, "{}: {offset:?}: {found}, not {expected}", device.label);
        }
    });
}

/// Depth is along the ray: equal all around in the middle of a sphere.
#[test]
fn depth_is_along_the_ray() {
    let view = View::new([1.0, 2.0, 3.0], [0.0, 2.5, 0.0], 40.0).size(16, 8);
    let rest = materials(&[("wall", "")]) + &shapes(&[("wall", "sphere = { center = [1, 2, 3], radius = 4 }")]);
    for_each_device(|device| {
        let mut session = load(device.device, &view.scene_with("", PANORAMA, &rest));
        for feature in [Feature::Depth, Feature::PlaneDepth] {
            session.show(feature).expect("the feature is shown");
            session.add_samples(0..8, 0..4).expect("samples are added");
            for found in means(&session.film().expect("the film is read")) {
                assert!((found.x - 4.0).abs() < 1e-5, "{}: {feature:?}: {found}", device.label);
            }
        }
    });
}
