//! Rays that leave a surface do not find it again, and find what is behind it.

use glam::Vec3;
use raggio_kernels::OFFSET_ROUNDINGS;
use raggio_render::{Answer, Probe};
use raggio_scene::Geometry;
use raggio_tests::geometry::{Ray, check, nearest};
use raggio_tests::{Pcg, TestDevice, for_each_device};

use crate::shapes::{SingleRay, found, place, scene_of};

const RAYS: usize = 100_000;

/// Ray to a shape, and the direction in which another leaves it from where the first one ends.
struct Departure {
    arriving: SingleRay,
    leaving: Vec3,
}

/// Departures from all around, inside too, and at all angles; a third of them nearly along the surface.
fn departures(shape: &Geometry, random: &mut Pcg) -> Vec<Departure> {
    let (center, reach) = place(shape);
    let mut departures = vec![];
    while departures.len() < RAYS {
        let origin = center + random.in_cube(3.0 * reach);
        let arriving = SingleRay::new(origin, center + random.in_cube(0.7 * reach) - origin);
        let Some(event) = nearest(shape, &arriving.exact()) else { continue };
        let cosine = if random.below(3) == 0 { 1e-4 } else { random.between(1e-4, 1.0) };
        let side = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
        let along = event.normal.cross(random.direction()).normalize();
        let leaving = (1.0 - cosine * cosine).sqrt() * along + side * cosine * event.normal;
        departures.push(Departure { arriving, leaving: leaving.as_vec3() });
    }
    departures
}

/// Shapes at scales from a thousandth to ten thousand, at the origin and up to a thousand times their size from it.
fn shapes() -> Vec<String> {
    let mut shapes = vec![];
    for scale in [1e-3, 1.0, 1e4] {
        for distance in [0.0, 10.0, 1000.0] {
            let [x, y, z] = [0.36, -0.48, 0.8].map(|c| c * scale * distance);
            let at = format!("[{x}, {y}, {z}]");
            shapes.push(format!("sphere = {{ center = {at}, radius = {scale} }}"));
            shapes.push(format!("plane = {{ point = {at}, normal = [0.2, 0.9, -0.3] }}"));
            let (u, v) = (0.6 * scale, 0.8 * scale);
            shapes.push(format!("rectangle = {{ corner = {at}, edge_u = [{u}, 0, {v}], edge_v = [{v}, 0, -{u}] }}"));
            shapes.push(format!("disk = {{ center = {at}, normal = [0.2, 0.9, -0.3], radius = {scale} }}"));
            let top = format!("[{}, {}, {}]", x + 0.7 * scale, y + 1.1 * scale, z - 0.4 * scale);
            let ends = format!("base = {at}, top = {top}, radius = {}", 0.6 * scale);
            shapes.push(format!("cylinder = {{ {ends} }}"));
            shapes.push(format!("cone = {{ {ends} }}"));
            shapes.push(format!("cone = {{ {ends}, top_radius = {} }}", 0.2 * scale));
            let size = format!("[{scale}, {}, {}]", 0.5 * scale, 2.0 * scale);
            shapes.push(format!("box = {{ center = {at}, size = {size}, rotation_degrees = [20, 30, 40] }}"));
        }
    }
    shapes
}

/// Answers to `Leave`, and to `Trace` for the surface that was left.
fn ask(device: &TestDevice, text: &str, offset: bool, departures: &[Departure]) -> Vec<(Answer, Answer)> {
    let scene = scene_of(text, offset);
    let questions = |third: fn(&Departure) -> [f32; 3]| -> Vec<_> {
        departures.iter().map(|d| d.arriving.question(third(d))).collect()
    };
    let surfaces = device.ask(&scene, Probe::Trace, &questions(|_| [0.0; 3]));
    let onward = device.ask(&scene, Probe::Leave, &questions(|d| d.leaving.to_array()));
    surfaces.into_iter().zip(onward).collect()
}

/// Whether the ray sets out to the outer side of the surface in the answer to `Trace`.
fn outward(surface: &Answer, leaving: Vec3) -> bool {
    Vec3::from_slice(&surface[2]).dot(leaving) >= 0.0
}

/// Ray as it must have left: moved along the normal by a few roundings of the surface's scale. In single precision, for
/// where its origin is rounded to decides how far the other side of a small shape is; a GPU may fuse the product and
/// the sum, and then rounds to the neighbouring number.
fn onward_ray(surface: &Answer, leaving: Vec3) -> Ray {
    let side = if outward(surface, leaving) { 1.0 } else { -1.0 };
    let step = side * OFFSET_ROUNDINGS as f32 * (0.5 * f32::EPSILON) * surface[1][3];
    let origin = Vec3::from_slice(&surface[1]) + step * Vec3::from_slice(&surface[2]);
    let origin_error = f64::from(f32::EPSILON) * f64::from(origin.abs().max_element());
    Ray { origin: origin.as_dvec3(), direction: leaving.as_dvec3(), origin_error }
}

#[test]
fn leaving_rays_do_not_find_their_surface_again() {
    for_each_device(|device| {
        let mut worst = 0.0f64;
        for (i, text) in shapes().iter().enumerate() {
            let shape = scene_of(text, true).shapes[0].geometry.clone();
            let departures = departures(&shape, &mut Pcg::new(100 + i as u64));
            let has_inside = !shape.is_sheet() && !matches!(shape, Geometry::Plane { .. });
            let (mut left, mut inward) = (0, 0);
            for (departure, (surface, answer)) in departures.iter().zip(ask(&device, text, true, &departures)) {
                if answer[0][3] == 0.0 {
                    continue;
                }
                left += 1;
                let leaving = departure.leaving;
                let context = || format!("{}: {text}: {surface:?} left along {leaving}: {answer:?}", device.label);
                if !has_inside || outward(&surface, leaving) {
                    assert!(found(&answer).is_none(), "found its own surface again: {}", context());
                } else {
                    inward += 1;
                    let far_side = check(&shape, &onward_ray(&surface, leaving), found(&answer));
                    worst = worst.max(far_side.unwrap_or_else(|why| panic!("{why}: {}", context())).ratio);
                    assert!(answer[0][0] != 0.0, "a distance of zero: {}", context());
                }
            }
            assert!(left > RAYS * 95 / 100, "{text}: only {left} of {RAYS} rays found a surface to leave");
            assert!(!has_inside || inward > RAYS / 3, "{text}: only {inward} of {RAYS} rays went inward");
        }
        println!("{}: worst error of a far side {worst:.2} of the allowed", device.label);
    });
}

/// Rays that leave without the offset must fail the test above, or it tests nothing.
#[test]
fn without_the_offset_some_do() {
    for_each_device(|device| {
        for text in [
            "sphere = { center = [0.3, 0.1, -2], radius = 1 }",
            "plane = { point = [0.5, 2, -1], normal = [1, 2, -0.5] }",
            "box = { center = [1, 2, -3], size = [1, 2, 3], rotation_degrees = [20, 30, 40] }",
        ] {
            let shape = scene_of(text, false).shapes[0].geometry.clone();
            let departures = departures(&shape, &mut Pcg::new(7));
            let answers = ask(&device, text, false, &departures);
            let again = departures
                .iter()
                .zip(&answers)
                .filter(|(departure, (surface, _))| outward(surface, departure.leaving))
                .filter(|(_, (_, answer))| found(answer).is_some())
                .count();
            println!("{} {text}: {again} of about {} find it again", device.label, RAYS / 2);
            assert!(again > 100, "{}: {text}: only {again} rays find their own surface again", device.label);
        }
    });
}
