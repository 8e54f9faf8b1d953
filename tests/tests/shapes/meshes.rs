//! Triangles, instances and both levels of the hierarchy: they find what trying every triangle finds.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use raggio_render::{Answer, Probe};
use raggio_scene::{Geometry, Mesh, Part, Scene, Shape};
use raggio_tests::{Pcg, for_each_device, parse};

use crate::shapes::SingleRay;

/// Number of rays in all small scenes together.
const RAYS: usize = 1_000_000;
/// Number of rays in the large scene, of which trial tries every triangle too.
const RAYS_IN_LARGE: usize = 10_000;

/// A mesh of these triangles, without anything over its vertices.
pub fn mesh(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Arc<Mesh> {
    let parts = vec![Part { name: "".into(), material: None, triangles: 0..triangles.len() }];
    Arc::new(Mesh { positions, triangles, parts, ..Mesh::default() })
}

/// A ball of `2 n^2` triangles, bumpy, its poles shared.
pub fn ball(n: u32) -> Arc<Mesh> {
    let vertex = |i: u32, j: u32| {
        let (u, v) = (f64::from(i % n) / f64::from(n), f64::from(j) / f64::from(n));
        let (longitude, latitude) = (u * std::f64::consts::TAU, v * std::f64::consts::PI);
        let r = 1.0 + 0.1 * (5.0 * longitude).sin() * (4.0 * latitude).sin();
        DVec3::new(longitude.cos() * latitude.sin(), latitude.cos(), longitude.sin() * latitude.sin()) * r
    };
    let positions = (0..=n).flat_map(|j| (0..n).map(move |i| vertex(i, j).as_vec3().to_array())).collect();
    let at = |i: u32, j: u32| j * n + i % n;
    let quads = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let triangles = quads.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    mesh(positions, triangles.collect())
}

/// Triangles anywhere in a cube of twice the size `room`; some thin, some of which the next is a copy.
pub fn soup(count: usize, room: f64, random: &mut Pcg) -> Arc<Mesh> {
    let mut positions: Vec<[f32; 3]> = vec![];
    for i in 0..count {
        if i > 0 && random.below(8) == 0 {
            positions.extend_from_within(positions.len() - 3..);
            continue;
        }
        let (at, size) = (random.in_cube(room), room * random.log_between(1e-3, 0.5));
        let [mut b, c] = [random.in_cube(size), random.in_cube(size)];
        if random.below(4) == 0 {
            let thickness = random.log_between(1e-9, 1e-2);
            b = c * random.between(-2.0, 2.0) + random.in_cube(size * thickness);
        }
        positions.extend([at, at + b, at + c].map(|p| p.as_vec3().to_array()));
    }
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    mesh(positions, triangles)
}

/// A flat square of `2 n^2` triangles in one plane, along the axes.
fn floor(n: u32) -> Arc<Mesh> {
    let side = n + 1;
    let positions = (0..side * side).map(|i| [(i % side) as f32, 0.0, (i / side) as f32]).collect();
    let quads = (0..n * n).flat_map(|i| {
        let a = i / n * side + i % n;
        [[a, a + 1, a + side], [a + 1, a + side + 1, a + side]]
    });
    mesh(positions, quads.collect())
}

pub fn scene_of(shapes: Vec<(Arc<Mesh>, DAffine3)>, others: &str) -> Scene {
    let mut scene = parse(&format!(
        "[camera]\nposition = [0, 0, 30]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n[materials.a]\n{others}"
    ));
    for (mesh, world_from_mesh) in shapes {
        let geometry = Geometry::Mesh { mesh, world_from_mesh, first_material: None };
        scene.shapes.push(Shape { entry: scene.shapes.len(), material: 0, geometry });
    }
    scene
}

/// Transform that turns, stretches unevenly, shears or mirrors, and moves.
pub(super) fn placed(room: f64, random: &mut Pcg) -> DAffine3 {
    let turn = DMat3::from_axis_angle(random.direction(), random.between(0.0, 6.0));
    let mut stretch = DMat3::from_diagonal(DVec3::from_array([(); 3].map(|()| random.log_between(0.2, 3.0))));
    match random.below(4) {
        0 => stretch.y_axis.x = random.between(-1.0, 1.0),
        1 => stretch.x_axis *= -1.0,
        _ => {}
    }
    DAffine3::from_mat3_translation(turn * stretch, random.in_cube(room))
}

pub(super) fn scenes() -> Vec<(&'static str, f64, Scene)> {
    let random = &mut Pcg::new(11);
    let still = DAffine3::IDENTITY;
    let one = mesh(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let spheres = "[[shapes]]\nmaterial = \"a\"\nsphere = { center = [1, 0, 0], radius = 1.5 }
        [[shapes]]\nmaterial = \"a\"\nplane = { point = [0, -9, 0], normal = [0, 1, 0] }
        [[shapes]]\nmaterial = \"a\"\nbox = { center = [-3, 0, 2], size = [1, 2, 3], rotation_degrees = [10, 20, 30] }
        [[shapes]]\nmaterial = \"a\"\nrectangle = { corner = [0, 3, 0], edge_u = [3, 0, 0], edge_v = [0, 0, 3] }";
    let many: Vec<_> = {
        let meshes = [ball(5), soup(20, 1.0, random), one.clone()];
        (0..40).map(|i| (meshes[i % 3].clone(), placed(8.0, random))).collect()
    };
    let far =
        DAffine3::from_scale_rotation_translation(DVec3::splat(1e4), glam::DQuat::IDENTITY, DVec3::new(1e5, 0.0, 2e4));
    let coincident = (0..6).map(|_| (ball(6), still)).collect();
    vec![
        ("one triangle", 1.0, scene_of(vec![(one, still)], "")),
        ("a ball", 1.5, scene_of(vec![(ball(12), still)], "")),
        ("soup", 1.5, scene_of(vec![(soup(300, 1.0, random), still)], "")),
        ("wide soup", 1e5, scene_of(vec![(soup(300, 1e5, random), still)], "")),
        ("a floor", 10.0, scene_of(vec![(floor(10), still)], "")),
        ("far and large", 1.2e5, scene_of(vec![(ball(8), far)], "")),
        ("coincident", 1.5, scene_of(coincident, "")),
        ("instances", 10.0, scene_of(many.clone(), "")),
        ("all kinds", 10.0, scene_of(many, spheres)),
        ("nothing", 1.0, scene_of(vec![], "")),
        // The mesh's hierarchy is built in parts.
        ("a large ball", 1.5, scene_of(vec![(ball(180), still)], "")),
    ]
}

/// Rays from anywhere, to anywhere; a third along an axis, through the corners of triangles.
pub(super) fn rays(scene: &Scene, room: f64, count: usize, random: &mut Pcg) -> Vec<SingleRay> {
    let corner = |random: &mut Pcg| match &scene.shapes.get(random.below(scene.shapes.len().max(1)))?.geometry {
        Geometry::Mesh { mesh, world_from_mesh, .. } => {
            let vertex = Vec3::from(mesh.positions[random.below(mesh.positions.len())]);
            Some(world_from_mesh.transform_point3(vertex.as_dvec3()))
        }
        _ => None,
    };
    let ray = |i: usize| {
        let corner = corner(random).unwrap_or(DVec3::ZERO);
        let origin = random.in_cube(1.5 * room);
        match i % 3 {
            0 => {
                let axis = DVec3::AXES[random.below(3)];
                SingleRay::new(corner - 3.0 * room * axis, axis)
            }
            1 => SingleRay::new(origin, corner - origin),
            _ => SingleRay::new(origin, random.in_cube(room) - origin),
        }
    };
    (0..count).map(ray).collect()
}

/// Distances must be equal to the last bit, whatever triangle is named where two are equally far; and whether something
/// stands before a distance must be what the nearest says.
#[test]
fn hierarchies_agree_with_trial() {
    for_each_device(|device| {
        let scenes = scenes();
        let small = scenes.len() - 1;
        for (place, (name, room, scene)) in scenes.iter().enumerate() {
            let count = if place == small { RAYS_IN_LARGE } else { RAYS / small };
            let rays = rays(scene, *room, count, &mut Pcg::new(12));
            let ask = |third: &dyn Fn(usize) -> [f32; 3], probe| {
                let questions: Vec<_> = rays.iter().enumerate().map(|(i, ray)| ray.question(third(i))).collect();
                device.ask(scene, probe, &questions)
            };
            let fast = ask(&|_| [0.0; 3], Probe::Trace);
            let sure = ask(&|_| [1.0, 0.0, 0.0], Probe::Trace);
            let distance = |answer: &Answer| answer[0][0];
            let mut hits = 0;
            for ((ray, fast), sure) in rays.iter().zip(&fast).zip(&sure) {
                let same = distance(fast).to_bits() == distance(sure).to_bits();
                assert!(same, "{}, {name}: {ray:?}: trial finds {sure:?}, the hierarchy {fast:?}", device.label);
                hits += usize::from(distance(sure) > 0.0);
            }
            // The limits are the nearest surface, a little behind it, and none.
            let limit = |i: usize| match (distance(&sure[i]), i % 3) {
                (nearest, 0) if nearest > 0.0 => nearest,
                (nearest, 1) if nearest > 0.0 => nearest.next_up(),
                _ => f32::INFINITY,
            };
            let occluded = ask(&|i| [limit(i), 0.0, 0.0], Probe::Occluded);
            for (i, answer) in occluded.iter().enumerate() {
                let expected = distance(&sure[i]) > 0.0 && distance(&sure[i]) < limit(i);
                let ray = rays[i];
                assert!((answer[0][0] != 0.0) == expected, "{}, {name}: {ray:?}: {:?}", device.label, sure[i]);
            }
            println!("{} {name}: {hits} hits of {count}", device.label);
            let enough = scene.shapes.is_empty() || hits > count / 20;
            assert!(enough, "{name}: only {hits} of {count} rays hit anything");
        }
    });
}

/// A closed mesh lets no ray out, at whatever edge or corner it aims.
#[test]
fn closed_meshes_do_not_leak() {
    for_each_device(|device| {
        let random = &mut Pcg::new(13);
        let ball = ball(24);
        let place = DAffine3::from_mat3_translation(placed(0.0, random).matrix3, DVec3::new(30.0, -20.0, 10.0));
        let scene = scene_of(vec![(ball.clone(), place)], "");
        let corner = |index: u32| place.transform_point3(Vec3::from(ball.positions[index as usize]).as_dvec3());
        let rays: Vec<_> = (0..200_000)
            .map(|i| {
                let origin = place.transform_point3(random.in_cube(0.3));
                let [a, b, _] = ball.triangles[random.below(ball.triangles.len())].map(corner);
                let along = if i % 2 == 0 { 0.0 } else { random.between(0.0, 1.0) };
                SingleRay::new(origin, a + along * (b - a) - origin)
            })
            .collect();
        let questions: Vec<_> = rays.iter().map(|ray| ray.question([0.0; 3])).collect();
        for (ray, answer) in rays.iter().zip(device.ask(&scene, Probe::Trace, &questions)) {
            assert!(answer[0][0] > 0.0, "{}: a ray gets out: {ray:?}", device.label);
        }
    });
}
