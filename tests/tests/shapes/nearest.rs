//! Nearest hit of single shapes.

use glam::DVec3;
use raggio_render::Probe;
use raggio_scene::Geometry;
use raggio_tests::geometry::{check, nearest};
use raggio_tests::{Pcg, for_each_device};

use crate::shapes::{SHAPES, SingleRay, found, place, scene_of};

const RAYS: usize = 100_000;

/// Rays of many kinds at and past a shape.
fn rays(shape: &Geometry, random: &mut Pcg) -> Vec<SingleRay> {
    let (center, reach) = place(shape);
    (0..RAYS)
        .map(|i| {
            let target = center + random.in_cube(0.8 * reach);
            match i % 5 {
                // The ray starts near the shape, inside or outside.
                0 | 1 => {
                    let origin = center + random.in_cube(3.0 * reach);
                    SingleRay::new(origin, target - origin)
                }
                // The ray starts ten thousand units away.
                2 => {
                    let origin = center + 1e4 * random.direction();
                    SingleRay::new(origin, target - origin)
                }
                3 => grazing(shape, random).unwrap_or_else(|| SingleRay::new(target, random.direction())),
                // The ray goes along an axis, where components of the direction are zero.
                _ => {
                    let axis = DVec3::AXES[random.below(3)] * if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
                    SingleRay::new(target - 3.0 * reach * axis, axis)
                }
            }
        })
        .collect()
}

/// A ray that touches a point of the surface at a small angle.
fn grazing(shape: &Geometry, random: &mut Pcg) -> Option<SingleRay> {
    let (center, reach) = place(shape);
    let origin = center + 2.0 * reach * random.direction();
    let inward = center + random.in_cube(0.5 * reach) - origin;
    let ray = SingleRay::new(origin, inward).exact();
    let event = nearest(shape, &ray)?;
    let along = event.normal.cross(random.direction()).normalize();
    let cosine = random.log_between(1e-5, 1e-2);
    let direction = (along - cosine * event.normal).normalize();
    Some(SingleRay::new(ray.at(event.distance) - reach * direction, direction))
}

/// Errors stay below the bound in `geometry`: eight roundings of the numbers involved, carried through the formulas.
/// Where that leaves a choice between hit and miss both are accepted: it does for most that graze, and for small shapes
/// from far away. At least half of the rays must leave none, or the test would mean little.
#[test]
fn hits_are_those_of_double_precision() {
    for_each_device(|device| {
        for (i, text) in SHAPES.iter().enumerate() {
            let scene = scene_of(text, true);
            let shape = &scene.shapes[0].geometry;
            let rays = rays(shape, &mut Pcg::new(i as u64));
            let questions: Vec<_> = rays.iter().map(|ray| ray.question([0.0; 3])).collect();
            let answers = device.ask(&scene, Probe::Trace, &questions);
            let (mut certain, mut hits, mut worst) = (0, 0, 0.0f64);
            for (ray, answer) in rays.iter().zip(&answers) {
                let agreement = check(shape, &ray.exact(), found(answer)).unwrap_or_else(|why| {
                    panic!("{}: {text}: from {} along {}: {why}", device.label, ray.origin, ray.direction)
                });
                certain += usize::from(agreement.certain);
                hits += usize::from(found(answer).is_some());
                worst = worst.max(agreement.ratio);
            }
            println!("{} {text}: {hits} hits, {certain} certain, worst error {worst:.2} of the allowed", device.label);
            assert!(hits > RAYS / 10, "{text}: only {hits} of {RAYS} rays hit");
            assert!(certain > RAYS / 2, "{text}: only {certain} of {RAYS} rays leave no choice");
        }
    });
}
