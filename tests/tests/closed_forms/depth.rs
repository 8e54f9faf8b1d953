//! Meaning of `max_depth`: it counts the rays along a path, the camera's included.

use glam::DVec3;
use raggio_tests::render::means;
use raggio_tests::{for_each_way, render};

use crate::closed_forms::{View, materials, shapes};

const SKY: &str = "[environment]\ncolor = [0.5, 1, 2]\n";

/// Checks that all pixels are one number, up to a few roundings: under a constant sky a diffuse plane has no noise.
fn assert_constant(what: &str, max_depth: u32, material: &str, shape: &str, expected: [f64; 3]) {
    let rest = [SKY, &materials(&[("m", material), ("none", "")]), &shapes(&[("m", shape)])].concat();
    let scene = View::new([0.0, 2.0, 0.0], [0.3, 0.0, 0.2], 20.0).size(8, 8).depth(max_depth).scene(&rest);
    let expected = DVec3::from_array(expected);
    for_each_way(&scene, |device, scene| {
        for mean in means(&render(device.device, scene, 8)) {
            let near = (mean - expected).abs().max_element() < 2e-6;
            assert!(near, "{}: {what} at depth {max_depth}: expected {expected}, found {mean}", device.label);
        }
    });
}

const GROUND: &str = "plane = { point = [0, 0, 0], normal = [0, 1, 0] }";
const BEHIND: &str = "plane = { point = [0, 9, 0], normal = [0, 1, 0] }";

#[test]
fn one_ray_sees_lamps_and_sky() {
    let gray = "color = [0.5, 0.5, 0.5]";
    assert_constant("sky", 1, gray, BEHIND, [0.5, 1.0, 2.0]);
    assert_constant("ground", 1, gray, GROUND, [0.0; 3]);
    assert_constant(
        "lamp",
        1,
        "color = [0.5, 0.5, 0.5]\nemission_color = [1, 2, 3]\nemission_strength = 2",
        GROUND,
        [2.0, 4.0, 6.0],
    );
}

#[test]
fn two_rays_see_the_sky_reflected() {
    for depth in [2, 3, 10] {
        assert_constant("ground", depth, "color = [0.5, 0.25, 0.125]", GROUND, [0.25, 0.25, 0.25]);
        let lamp = "color = [0.5, 0.25, 0.125]\nemission_color = [1, 2, 3]\nemission_strength = 2";
        assert_constant("lamp", depth, lamp, GROUND, [2.25, 4.25, 6.25]);
    }
}

/// Rays go into a sheet of glass, through it, out of it: three.
#[test]
fn glass_takes_a_ray_for_each_boundary() {
    let glass = "color = [1, 1, 1]\nrefractive_index = 1.5\nreflection = 0";
    let sheet = "box = { center = [0, 0, 0], size = [9, 0.5, 9] }";
    assert_constant("glass", 2, glass, sheet, [0.0; 3]);
    assert_constant("glass", 3, glass, sheet, [0.5, 1.0, 2.0]);
}
