//! Boundaries that light does not notice leave no trace in a picture.

use raggio_render::Film;
use raggio_tests::render::{means, relative_difference};
use raggio_tests::{for_each_device, render};

use crate::closed_forms::{View, materials, shapes};

const SKY: &str = "[environment]\nhorizon = [1, 0.8, 0.6]\nzenith = [0.2, 0.4, 1]\n";

/// Renders `bodies` in the surroundings that both scenes have; a diffuse floor makes paths meet the bodies from all
/// sides.
fn picture(device: &dyn raggio_render::Device, bodies: &[(&str, &str)], max_depth: u32, samples: u32) -> Film {
    let list = materials(&[
        ("floor", "color = [0.7, 0.6, 0.5]"),
        ("glass", "color = [0.9, 1, 0.9]\nrefractive_index = 1.5\npriority = 1"),
        ("water", "color = [0.5, 0.5, 0.9]\nrefractive_index = 1.33\npriority = 0"),
        ("ice", "color = [0.1, 0.5, 0.9]\nrefractive_index = 1.31\npriority = -1"),
    ]);
    let floor = shapes(&[("floor", "plane = { point = [0, -1.2, 0], normal = [0, 1, 0] }")]);
    let view = View::new([0.5, 0.7, 5.0], [0.0, 0.0, 0.0], 40.0).depth(max_depth);
    render(device, &view.scene(&[SKY, &list, &floor, &shapes(bodies)].concat()), samples)
}

/// Checks that two films agree. A hidden boundary takes no random number and no depth. But the ray starts anew behind
/// it, which rounds its origin: 32 roundings of about two units, so a few 1e-6 in what it hits. A path whose decision
/// that turns is another one; nearly all pixels are without.
fn assert_alike(what: &str, one: &Film, other: &Film) {
    let (a, b) = (means(one), means(other));
    let alike = a.iter().zip(&b).filter(|(a, b)| relative_difference(**a, **b) < 2e-5).count();
    println!("{what}: {alike} of {} pixels alike", a.len());
    assert!(alike > a.len() * 97 / 100, "{what}: expected 97 % of {} pixels to be alike, found {alike}", a.len());
    let total = |means: &[glam::DVec3]| means.iter().map(|m| m.element_sum()).sum::<f64>();
    let apart = (total(&a) / total(&b) - 1.0).abs();
    assert!(apart < 1e-4, "{what}: expected equal means, found a difference of {apart:.1e}");
}

const BALL: (&str, &str) = ("glass", "sphere = { center = [0, 0, 0], radius = 1.1 }");

#[test]
fn bodies_inside_one_of_higher_priority_are_hidden() {
    let hidden = [
        ("water", "sphere = { center = [0.3, 0.1, 0.2], radius = 0.6 }"),
        ("ice", "box = { center = [-0.2, 0, 0.1], size = [0.8, 0.7, 0.9], rotation_degrees = [10, 20, 30] }"),
    ];
    for_each_device(|device| {
        for depth in [3, 4, 30] {
            let plain = picture(device.device, &[BALL], depth, 16);
            for (i, body) in hidden.into_iter().enumerate() {
                let found = picture(device.device, &[BALL, body], depth, 16);
                assert_alike(&format!("{}: hidden body {i}, depth {depth}", device.label), &plain, &found);
            }
            let both = picture(device.device, &[hidden[0], BALL, hidden[1]], depth, 16);
            assert_alike(&format!("{}: two hidden bodies, depth {depth}", device.label), &plain, &both);
        }
    });
}

/// Two sheets that overlap, and the sheet they make together; a ball, and a smaller one inside it. (Their sides,
/// which coincide, are out of sight: where two faces do, a path cannot tell that it crosses both.)
#[test]
fn overlapping_bodies_of_one_material_are_one() {
    let sheet =
        |middle: f64, height: f64| format!("box = {{ center = [0, {middle}, 0], size = [200, {height}, 200] }}");
    let (upper, lower, whole) = (sheet(0.2, 0.6), sheet(-0.2, 0.6), sheet(0.0, 1.0));
    let inner = ("glass", "sphere = { center = [-0.2, 0.3, 0.1], radius = 0.6 }");
    for_each_device(|device| {
        for depth in [3, 4, 30] {
            let one = picture(device.device, &[("glass", &whole)], depth, 16);
            let two = picture(device.device, &[("glass", &upper), ("glass", &lower)], depth, 16);
            assert_alike(&format!("{}: overlapping sheets, depth {depth}", device.label), &one, &two);
            let one = picture(device.device, &[BALL], depth, 16);
            let two = picture(device.device, &[BALL, inner], depth, 16);
            assert_alike(&format!("{}: ball in ball, depth {depth}", device.label), &one, &two);
        }
    });
}

/// A boundary that counts changes the picture: the comparison can tell.
#[test]
fn boundaries_that_count_are_seen() {
    for_each_device(|device| {
        let plain = picture(device.device, &[BALL], 30, 16);
        let inner = ("glass", "box = { center = [1.3, 0, 0], size = [1, 0.5, 0.5] }");
        let found = picture(device.device, &[BALL, inner], 30, 16);
        let (a, b) = (means(&plain), means(&found));
        let alike = a.iter().zip(&b).filter(|(a, b)| relative_difference(**a, **b) < 2e-5).count();
        assert!(alike < a.len() * 95 / 100, "{}: {alike} of {} pixels are alike", device.label, a.len());
    });
}
