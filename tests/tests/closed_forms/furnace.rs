//! White furnaces: under a sky of 1 from everywhere, whatever absorbs nothing is invisible.

use glam::DVec3;
use raggio_tests::render::means;
use raggio_tests::{for_each_device, for_each_way, render};

use crate::closed_forms::{View, WHITE_SKY, materials, shapes};

/// Bodies that fill this view, none of which a path meets twice.
const CONVEX: [&str; 4] = [
    "sphere = { center = [0, 0, 0], radius = 1 }",
    "box = { center = [0, 0, 0], size = [2, 2, 2], rotation_degrees = [20, 30, 0] }",
    "plane = { point = [0, 0, 0], normal = [0, 0.2, 1] }",
    "rectangle = { corner = [-9, -9, 0], edge_u = [18, 0, 0], edge_v = [0, 18, 0] }",
];

fn view() -> View {
    View::new([0.0, 0.0, 3.0], [0.0, 0.0, 0.0], 20.0).size(32, 32)
}

/// Every path bounces once: each pixel is the albedo itself, up to a few roundings.
#[test]
fn convex_bodies_show_their_albedo() {
    let albedo = DVec3::new(0.2, 0.5, 0.8);
    for_each_device(|device| {
        for body in CONVEX {
            for smoothness in [0.0, 0.3, 0.7, 1.0] {
                let material = format!("color = [0.2, 0.5, 0.8]\nsmoothness = {smoothness}");
                let scene =
                    view().scene(&[WHITE_SKY, &materials(&[("m", &material)]), &shapes(&[("m", body)])].concat());
                for mean in means(&render(device.device, &scene, 16)) {
                    let error = ((mean - albedo) / albedo).abs().max_element();
                    let label = device.label;
                    assert!(error < 1e-6, "{label}: {body}, smoothness {smoothness}: expected {albedo}, found {mean}");
                }
            }
        }
    });
}

/// A path is worth 1 when it reaches the sky and 0 when it is cut before. Reflected about between opaque bodies it
/// gets out soon: at a thousand rays none of these is left.
#[test]
fn opaque_bodies_vanish() {
    let white = |smoothness: f64| format!("color = [1, 1, 1]\nsmoothness = {smoothness}");
    let list: Vec<_> = [0.0, 0.3, 0.7, 1.0].map(white).into();
    let names = ["diffuse", "rough", "glossy", "mirror"];
    let materials = materials(&names.iter().zip(&list).map(|(n, k)| (*n, k.as_str())).collect::<Vec<_>>());
    let shapes = shapes(&[
        ("diffuse", "plane = { point = [0, -1, 0], normal = [0, 1, 0] }"),
        ("rough", "sphere = { center = [-0.7, 0, 0], radius = 0.9 }"),
        ("glossy", "box = { center = [1, 0, 0], size = [1, 1, 1], rotation_degrees = [10, 20, 30] }"),
        ("mirror", "rectangle = { corner = [-2, -1, -2], edge_u = [4, 0, 0], edge_v = [0, 3, 0] }"),
        ("mirror", "sphere = { center = [0.2, -0.6, 1], radius = 0.4 }"),
    ]);
    let scene = View::new([0.0, 0.5, 5.0], [0.0, 0.0, 0.0], 40.0).scene(&[WHITE_SKY, &materials, &shapes].concat());
    for_each_way(&scene, |device, scene| {
        for (i, mean) in means(&render(device.device, scene, device.pick(64, 16))).into_iter().enumerate() {
            let error = (mean - 1.0).abs().max_element();
            assert!(error < 2e-6, "{}: pixel {i}: expected 1, found {mean}", device.label);
        }
    });
}

/// Light that entered a glass body is reflected inside it with the probability R that it was reflected outside, so of
/// the paths (1-R) that enter (1-R) R^k are inside after k reflections: cut at depth n, a pixel lacks at most 1/(e n)
/// of its light. Nothing may exceed 1, but for the roundings of some thirty factors.
#[test]
fn glass_vanishes() {
    let depth = 4000;
    let lacking = 1.0 / (std::f64::consts::E * f64::from(depth));
    for_each_device(|device| {
        for (reflection, body) in [
            ("\"fresnel\"", CONVEX[0]),
            ("0.3", CONVEX[0]),
            ("\"fresnel\"", "box = { center = [0, 0, 0], size = [1, 1, 1], rotation_degrees = [20, 30, 0] }"),
            ("0.3", "box = { center = [0, 0, 0], size = [1, 1, 1], rotation_degrees = [0, 0, 0] }"),
        ] {
            let glass = format!("color = [1, 1, 1]\nrefractive_index = 1.5\nreflection = {reflection}");
            let rest = [WHITE_SKY, &materials(&[("glass", &glass)]), &shapes(&[("glass", body)])].concat();
            let scene = View { fov_degrees: 45.0, ..view() }.depth(depth).scene(&rest);
            let samples = device.pick(256, 32);
            let means = means(&render(device.device, &scene, samples));
            let what = format!("{}: {body}, reflection {reflection}", device.label);
            let most = means.iter().map(|m| m.max_element()).fold(0.0, f64::max);
            assert!(most < 1.0 + 1e-5, "{what}: expected at most 1, found {most}");
            let mean = means.iter().map(|m| m.x).sum::<f64>() / means.len() as f64;
            // Four standard errors of a probability, for the few that are cut.
            let cut = 1.0 - mean;
            let allowed = lacking + 4.0 * (lacking / (means.len() as f64 * f64::from(samples))).sqrt() + 1e-6;
            assert!(
                cut < allowed,
                "{what}: expected at most {allowed:.2e} of the light to be missing, found {cut:.2e}"
            );
        }
    });
}
