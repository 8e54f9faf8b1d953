//! A lamp over a diffuse plane: radiance is albedo / pi times the irradiance, which has a closed form.

use std::f64::consts::PI;

use glam::DVec3;
use raggio_tests::{estimate, for_each_way};

use crate::closed_forms::{ONE_DIRECTION, View, array, materials, shapes};

const ALBEDO: DVec3 = DVec3::new(0.9, 0.6, 0.3);
const LAMP: DVec3 = DVec3::new(2.0, 3.0, 4.0);

/// Checks the radiance of the plane y = 0 at the origin under a lamp: at least a fifth of the paths reach one of those
/// below, which at two million samples leaves an error below 0.2 %.
fn assert_irradiance(what: &str, lamp: &str, eye: [f64; 3], irradiance: f64) {
    let ground_keys = format!("color = {}", array(ALBEDO));
    let lamp_keys = format!("emission_color = {}\nemission_strength = 1", array(LAMP));
    let materials = materials(&[("ground", &ground_keys), ("lamp", &lamp_keys)]);
    let ground = ("ground", "plane = { point = [0, 0, 0], normal = [0, 1, 0] }");
    let rest = [materials, shapes(&[ground, ("lamp", lamp)])].concat();
    let scene = View::new(eye, [0.0; 3], ONE_DIRECTION).depth(4).scene(&rest);
    for_each_way(&scene, |device, scene| {
        let found = estimate(device.device, scene, device.pick(512, 192));
        println!("{} {what}: error {:.2e}", device.label, found.error.x / found.mean.x);
        found.assert_near(&format!("{}: {what}", device.label), ALBEDO / PI * LAMP * irradiance, 0.003);
    });
}

/// The irradiance is E = pi (r/d)^2 cos for a radiance of 1, while all of the sphere is above the plane.
#[test]
fn sphere_lamp() {
    for (radius, center) in [
        (1.0, DVec3::new(0.0, 1.2, 0.0)),
        (1.5, DVec3::new(0.0, 3.0, 0.0)),
        (1.0, DVec3::new(0.8, 1.4, 0.0)),
        (50.0, DVec3::new(-30.0, 70.0, 20.0)),
    ] {
        let distance = center.length();
        let irradiance = PI * (radius / distance).powi(2) * center.y / distance;
        let lamp = format!("sphere = {{ center = {}, radius = {radius} }}", array(center));
        // The eye is on the side that the lamp leaves free.
        let eye = [-2.0 * center.x.signum(), 0.3, -0.5];
        assert_irradiance(&format!("sphere of radius {radius} at {center}"), &lamp, eye, irradiance);
    }
}

/// Lambert's formula for polygons: half the sum of the angles that the edges subtend, each times the cosine between
/// the plane's normal and that of the edge's own plane through the point.
fn lambert(corners: [DVec3; 4]) -> f64 {
    let edge = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        let across = a.cross(b);
        across.normalize().y * a.angle_between(b)
    };
    (0.5 * (0..4).map(edge).sum::<f64>()).abs()
}

#[test]
fn rectangle_lamp() {
    for (what, corner, u, v) in [
        ("ceiling", [-1.0, 1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]),
        ("ceiling to one side", [0.2, 0.8, -2.0], [3.0, 0.0, 0.0], [0.0, 0.0, 4.0]),
        ("wall", [0.4, 0.0001, -3.0], [0.0, 4.0, 0.0], [0.0, 0.0, 6.0]),
        ("tilted", [0.5, 1.0, -3.0], [-2.4, 3.2, 0.0], [0.0, 0.0, 6.0]),
        ("large and far", [-300.0, 250.0, -400.0], [600.0, 0.0, 0.0], [0.0, 0.0, 800.0]),
    ] {
        let [a, eu, ev] = [corner, u, v].map(DVec3::from_array);
        let irradiance = lambert([a, a + eu, a + eu + ev, a + ev]);
        let lamp = format!("rectangle = {{ corner = {}, edge_u = {}, edge_v = {} }}", array(a), array(eu), array(ev));
        assert_irradiance(&format!("rectangle, {what}"), &lamp, [-1.5, 0.2, -0.3], irradiance);
    }
}
