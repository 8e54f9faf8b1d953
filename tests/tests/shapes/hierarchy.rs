//! Hierarchies over shapes: they find what trying every shape finds.

use std::fmt::Write;

use glam::DVec3;
use raggio_render::Probe;
use raggio_scene::Scene;
use raggio_tests::{Pcg, for_each_device, parse};

use crate::shapes::{SingleRay, found};

const RAYS: usize = 50_000;
/// Half of the side of the cube in which shapes lie.
const ROOM: f64 = 10.0;

/// Scene of shapes of all kinds; some exactly where others are, some without thickness along an axis.
pub(super) fn random_scene(count: usize, random: &mut Pcg) -> Scene {
    let mut text = String::from(
        "[camera]\nposition = [0, 0, 30]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40
         [materials.a]\n[materials.b]\n",
    );
    let mut last = String::new();
    for i in 0..count {
        if i == 0 || random.below(10) > 0 {
            last = random_shape(random);
        }
        let material = if random.bits() & 1 == 0 { "a" } else { "b" };
        write!(text, "[[shapes]]\nmaterial = \"{material}\"\n{last}\n").expect("strings take all");
    }
    parse(&text)
}

fn random_shape(random: &mut Pcg) -> String {
    let at = array(random.in_cube(ROOM));
    let size = random.log_between(0.01, 3.0);
    match random.below(26) {
        // Planes lie around the room, not through it: the others are to be seen.
        0 => {
            let outward = random.direction();
            format!("plane = {{ point = {}, normal = {} }}", array(1.5 * ROOM * outward), array(-outward))
        }
        1..8 => format!("sphere = {{ center = {at}, radius = {size} }}"),
        // Rectangles lie along two axes: their bounds are flat.
        8..14 => {
            let axis = random.below(3);
            let (u, v) = (DVec3::AXES[axis] * size, DVec3::AXES[(axis + 1) % 3] * random.log_between(0.01, 3.0));
            format!("rectangle = {{ corner = {at}, edge_u = {}, edge_v = {} }}", array(u), array(v))
        }
        // All but along an axis too: bounds are thin.
        14..16 => {
            let spread = random.log_between(1e-5, 1.0);
            let normal = DVec3::AXES[random.below(3)] + random.in_cube(spread);
            format!("disk = {{ center = {at}, normal = {}, radius = {size} }}", array(normal))
        }
        kind @ 16..20 => {
            let base = random.in_cube(ROOM);
            let axis = if kind == 16 { DVec3::AXES[random.below(3)] } else { random.direction() };
            let ends = format!("base = {}, top = {}", array(base), array(base + random.log_between(0.01, 3.0) * axis));
            let capped = random.bits() & 1 == 0;
            match kind {
                16 | 17 => format!("cylinder = {{ {ends}, radius = {size}, capped = {capped} }}"),
                18 => format!("cone = {{ {ends}, radius = {size}, capped = {capped} }}"),
                _ => format!("cone = {{ {ends}, radius = {size}, top_radius = {}, capped = {capped} }}", 0.4 * size),
            }
        }
        kind => {
            let sides = array(DVec3::new(size, random.log_between(0.01, 3.0), random.log_between(1e-6, 1.0)));
            let turned = if kind < 23 { DVec3::ZERO } else { random.in_cube(180.0) };
            format!("box = {{ center = {at}, size = {sides}, rotation_degrees = {} }}", array(turned))
        }
    }
}

fn array(v: DVec3) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

/// Rays from inside and outside the room; a fifth along the axes, through the corners of shapes.
pub(super) fn random_rays(scene: &Scene, random: &mut Pcg) -> Vec<SingleRay> {
    (0..RAYS)
        .map(|i| {
            let place = crate::shapes::place(&scene.shapes[random.below(scene.shapes.len())].geometry).0;
            if i % 5 == 0 {
                let axis = DVec3::AXES[random.below(3)];
                return SingleRay::new(place - 3.0 * ROOM * axis, axis);
            }
            let origin = random.in_cube(1.5 * ROOM);
            let target = if i % 2 == 0 { place + random.in_cube(0.5) } else { random.in_cube(ROOM) };
            SingleRay::new(origin, target - origin)
        })
        .collect()
}

/// Distances must be equal to the last bit, and of coincident shapes the same is named.
#[test]
fn hierarchy_agrees_with_trial() {
    for_each_device(|device| {
        for (seed, count) in [(1, 1), (2, 1), (3, 2), (4, 2), (5, 20), (6, 1000)] {
            let random = &mut Pcg::new(seed);
            let scene = random_scene(count, random);
            let rays = random_rays(&scene, random);
            let ask = |brute_force: f32| {
                let questions: Vec<_> = rays.iter().map(|ray| ray.question([brute_force, 0.0, 0.0])).collect();
                device.ask(&scene, Probe::Trace, &questions)
            };
            let mut hits = 0;
            for ((ray, fast), sure) in rays.iter().zip(ask(0.0)).zip(ask(1.0)) {
                assert!(
                    fast[0][0].to_bits() == sure[0][0].to_bits() && fast[0][1] == sure[0][1],
                    "{}, {count} shapes, seed {seed}: from {} along {}: trial finds {:?}, the hierarchy {:?}",
                    device.label,
                    ray.origin,
                    ray.direction,
                    found(&sure),
                    found(&fast)
                );
                hits += usize::from(found(&sure).is_some());
            }
            println!("{} {count} shapes: {hits} hits", device.label);
            assert!(hits > RAYS / 10, "{count} shapes, seed {seed}: only {hits} of {RAYS} rays hit anything");
        }
    });
}
