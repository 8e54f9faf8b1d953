//! Hard cases: rounding, or a list that is kept carelessly, would let light through or lose it.

use glam::DVec3;
use raggio_tests::{for_each_device, render};

use crate::closed_forms::{ONE_DIRECTION, View, WHITE_SKY, materials, shapes};

/// A pane is as thick as sixteen neighbouring floats are apart: at 1000 units from the origin they lie 6e-5 apart. In a
/// white furnace it is invisible, unless refracted rays jump over its far side and stay inside for ever.
#[test]
fn a_thin_pane_far_away_lets_all_light_through() {
    let glass = materials(&[("glass", "color = [1, 1, 1]\nrefractive_index = 1.5")]);
    for_each_device(|device| {
        for far in [0.0, 100.0, 1000.0] {
            let pane =
                format!("box = {{ center = [{far}, 0, 0], size = [0.001, 4, 4], rotation_degrees = [0, 0, 0] }}");
            let view = View::new([far + 5.0, 0.5, 0.3], [far, 0.0, 0.0], ONE_DIRECTION);
            let film =
                render(device.device, &view.scene(&[WHITE_SKY, &glass, &shapes(&[("glass", &pane)])].concat()), 16);
            let mean = mean_of(&film);
            assert!((mean - 1.0).abs() < 1e-3, "{}, {far} away: expected 1, found {mean}", device.label);
        }
    });
}

/// Three bodies overlap, the outer two of one material: who leaves the first of them must not forget the last. In a
/// white furnace nothing of it shows.
#[test]
fn two_bodies_of_one_material_are_told_apart() {
    let list = materials(&[
        ("glass", "color = [1, 1, 1]\nrefractive_index = 1.5"),
        ("water", "color = [1, 1, 1]\nrefractive_index = 1.33"),
    ]);
    let ball = |x: f64| format!("sphere = {{ center = [{x}, 0, 0], radius = 1 }}");
    let bodies = shapes(&[("glass", &ball(-0.6)), ("water", &ball(0.0)), ("glass", &ball(0.6))]);
    for_each_device(|device| {
        let view = View::new([-6.0, 1.5, 2.0], [0.0, 0.0, 0.0], 25.0);
        let mean = mean_of(&render(device.device, &view.scene(&[WHITE_SKY, &list, &bodies].concat()), 16));
        assert!((mean - 1.0).abs() < 1e-3, "{}: expected 1, found {mean}", device.label);
    });
}

/// Nothing gets out of a closed box, so none of the sky gets in, not even where a path grazes the walls.
#[test]
fn walls_do_not_leak() {
    for_each_device(|device| {
        for smoothness in [0.0, 0.95, 1.0] {
            let wall = materials(&[("wall", &format!("color = [1, 1, 1]\nsmoothness = {smoothness}"))]);
            let room = "box = { center = [100, 0, 0], size = [3, 2, 4], rotation_degrees = [10, 20, 30] }";
            let scene = [WHITE_SKY, &wall, &shapes(&[("wall", room)])].concat();
            let view = View::new([100.3, 0.2, 0.1], [101.0, -0.3, 0.0], 90.0).depth(device.pick(100, 20));
            let film = render(device.device, &view.scene(&scene), device.pick(64, 16));
            let mean = mean_of(&film);
            assert!(mean == 0.0, "{}, smoothness {smoothness}: expected 0, found {mean}", device.label);
        }
    });
}

fn mean_of(film: &raggio_render::Film) -> f64 {
    assert_eq!(film.rejected(), 0);
    let means = raggio_tests::render::means(film);
    means.iter().sum::<DVec3>().element_sum() / (3 * means.len()) as f64
}
