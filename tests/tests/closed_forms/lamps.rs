//! A lamp over a diffuse plane: radiance is albedo / pi times the irradiance, which has a closed form.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use raggio_tests::{estimate, for_each_device_with, for_each_way};

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

/// Lambert's formula for a convex lamp above the ground is that for its outline: the hull of what it is the hull of, as seen on a
/// plane above the origin.
fn of_outline(points: impl Iterator<Item = DVec3>) -> f64 {
    let mut seen: Vec<DVec2> = points.map(|p| DVec2::new(p.x, p.z) / p.y).collect();
    seen.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = vec![];
        for p in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(p - b) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let hull = [chain(&mut seen.iter().copied()), chain(&mut seen.iter().rev().copied())].concat();
    let corner = |i: usize| DVec3::new(hull[i % hull.len()].x, 1.0, hull[i % hull.len()].y);
    let edge = |i: usize| {
        let (a, b) = (corner(i), corner(i + 1));
        a.cross(b).normalize_or_zero().y * a.angle_between(b)
    };
    (0.5 * (0..hull.len()).map(edge).sum::<f64>()).abs()
}

/// Points of a circle around an axis.
fn circle(center: DVec3, axis: DVec3, radius: f64) -> impl Iterator<Item = DVec3> {
    let (x, y) = axis.normalize().any_orthonormal_pair();
    (0..4096).map(move |i| {
        let (sine, cosine) = (PI * f64::from(i) / 2048.0).sin_cos();
        center + radius * (cosine * x + sine * y)
    })
}

/// E = pi sin^2 of the half angle that it fills, straight above; elsewhere that of its outline.
#[test]
fn disk_lamp() {
    let lamp = "disk = { center = [0, 1, 0], normal = [0, 1, 0], radius = 1 }";
    assert_irradiance("disk", lamp, [-2.0, 0.3, -0.5], 0.5 * PI);
    let (center, normal) = (DVec3::new(0.5, 1.2, -0.3), DVec3::new(0.4, 1.0, 0.7));
    let lamp = format!("disk = {{ center = {}, normal = {}, radius = 0.9 }}", array(center), array(normal));
    assert_irradiance("slanted disk", &lamp, [-2.0, 0.3, -0.5], of_outline(circle(center, normal, 0.9)));
}

#[test]
fn cylinder_and_cone_lamps() {
    for (what, base, top, radii) in [
        ("lying cylinder", [-0.8, 1.0, -0.2], [1.0, 1.1, 0.3], [0.6, 0.6]),
        ("standing cylinder", [0.7, 0.3, 0.2], [0.7, 1.9, 0.2], [0.5, 0.5]),
        ("hanging cone", [0.0, 1.2, 0.0], [0.0, 0.4, 0.0], [0.9, 0.0]),
        ("standing cone", [0.2, 0.7, 0.1], [0.5, 1.6, 0.2], [0.8, 0.0]),
        ("flat cone, cut off", [0.3, 0.9, 0.0], [0.4, 1.1, 0.1], [1.2, 0.5]),
    ] {
        let [base, top] = [base, top].map(DVec3::from_array);
        let [radius, top_radius] = radii;
        let outline = circle(base, top - base, radius).chain(circle(top, top - base, top_radius));
        let ends = format!("base = {}, top = {}, radius = {radius}", array(base), array(top));
        let lamp = if what.contains("cone") {
            format!("cone = {{ {ends}, top_radius = {top_radius} }}")
        } else {
            format!("cylinder = {{ {ends} }}")
        };
        assert_irradiance(what, &lamp, [-2.0, 0.2, -0.5], of_outline(outline));
    }
}

/// Ground under a sun of color `LAMP` and intensity 2, and the eye that looks at it.
fn under_a_sun(direction: DVec3, angle_degrees: f64, look_at: [f64; 3]) -> raggio_scene::Scene {
    let ground_keys = format!("color = {}", array(ALBEDO));
    let sun = format!(
        "[[lights]]\ndirectional = {{ direction = {}, angle_degrees = {angle_degrees}, color = {}, intensity = 2 }}\n",
        array(direction),
        array(LAMP)
    );
    let ground = shapes(&[("ground", "plane = { point = [0, 0, 0], normal = [0, 1, 0] }")]);
    let rest = [sun, materials(&[("ground", &ground_keys)]), ground].concat();
    View::new([-2.0, 0.3, -0.5], look_at, ONE_DIRECTION).depth(4).scene(&rest)
}

/// A sun that is wholly above the horizon lights the ground as if all its light came from its middle, whatever its size.
#[test]
fn suns() {
    let slanted = DVec3::new(0.4, -1.0, 0.3);
    let expected = |direction: DVec3| ALBEDO / PI * LAMP * 2.0 * -direction.normalize().y;
    for (angle, direction) in [(60.0, slanted), (90.0, slanted), (170.0, DVec3::NEG_Y)] {
        for_each_way(&under_a_sun(direction, angle, [0.0; 3]), |device, scene| {
            let found = estimate(device.device, scene, device.pick(512, 192));
            found.assert_near(&format!("{}: sun {angle} wide", device.label), expected(direction), 0.003);
        });
    }
    // Chance finds no small one.
    for angle in [0.0, 0.01, 0.53, 10.0] {
        let scene = under_a_sun(slanted, angle, [0.0; 3]);
        for_each_device_with(&scene, |device| {
            let found = estimate(device.device, &scene, 64);
            found.assert_near(&format!("{}: sun {angle} wide", device.label), expected(slanted), 0.002);
        });
    }
}

/// Radiance of a sun is its irradiance over pi sin^2 of half its width, as far as its disk reaches; without a width it is
/// not seen.
#[test]
fn suns_are_seen() {
    let direction = DVec3::new(0.4, -0.8, 0.3);
    let eye = DVec3::new(-2.0, 0.3, -0.5);
    let across = direction.any_orthogonal_vector().normalize();
    for angle in [0.0, 0.5, 5.0, 120.0f64] {
        let half = 0.5 * angle.to_radians();
        let radiance = if angle > 0.0 { LAMP * 2.0 / (PI * half.sin().powi(2)) } else { DVec3::ZERO };
        for (part, expected) in [(0.0, radiance), (0.9, radiance), (1.1, DVec3::ZERO)] {
            // Without a width there is nothing beside the middle either.
            let off = if angle > 0.0 { part * half } else { 0.1 * part };
            let toward = off.cos() * -direction.normalize() + off.sin() * across;
            let scene = under_a_sun(direction, angle, (eye + toward).to_array());
            for_each_way(&scene, |device, scene| {
                let found = estimate(device.device, scene, 4);
                let off = (found.mean - expected).abs().max_element();
                let what = format!("{}: {part} of the way to the rim of a sun {angle} wide", device.label);
                assert!(off <= 1e-5 * expected.max_element(), "{what}: {} instead of {expected}", found.mean);
            });
        }
    }
}
