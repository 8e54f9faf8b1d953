//! Whatever scene passes validation, its translation is sound: every index inside its buffer, every shape in exactly one
//! leaf, every box around what it holds.

use proptest::prelude::*;
use raggio_kernels::{BvhChild, BvhNode};
use raggio_render::{DeviceScene, MAX_NESTED_MEDIA, TranslationError, bounds};
use raggio_scene::{DVec3, Geometry, Material, Scene, Shape, Vec3};

/// A scene with `shapes`, the camera at (0, 0, 5).
fn scene(shapes: Vec<Geometry>, refractive_index: Option<f32>) -> Scene {
    let text = "version = 1\n[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n";
    let mut scene = Scene::parse(text, "empty").expect("a scene");
    scene.materials = vec![Material { name: "any".into(), refractive_index, ..Material::default() }];
    scene.shapes = shapes.into_iter().map(|geometry| Shape { entry: 0, material: 0, geometry }).collect();
    scene
}

fn assert_sound(scene: &Scene) {
    let translated = DeviceScene::new(scene).expect("the scene translates");
    let buffers = &translated.buffers;
    buffers.check().expect("every index is inside its buffer");
    let mut shapes = translated.shape_of_place.clone();
    shapes.sort_unstable();
    assert!(shapes.iter().copied().eq(0..scene.shapes.len() as u32), "every shape has one place");

    let mut covered = vec![false; buffers.order.len()];
    covered[..buffers.constants().counts.unbounded as usize].fill(true);
    for node in buffers.nodes.iter() {
        for child in children(node) {
            match child {
                Child::Leaves(places, inside) => {
                    for place in places {
                        assert!(!std::mem::replace(&mut covered[place], true), "place {place} is in two leaves");
                        let shape = &scene.shapes[translated.shape_of_place[place] as usize];
                        let (lower, upper) = bounds(&shape.geometry).expect("what has no bounds is in no leaf");
                        assert_holds(inside, [lower.as_dvec3(), upper.as_dvec3()]);
                    }
                }
                Child::Node(place, inside) => {
                    let boxes = children(&buffers.nodes[place]).into_iter().map(|child| match child {
                        Child::Leaves(_, own) | Child::Node(_, own) => own,
                    });
                    boxes.for_each(|own| assert_holds(inside, own));
                }
            }
        }
    }
    assert!(covered.iter().all(|&c| c), "a shape is in no leaf");
}

/// A child of a node, with its box as the kernels see it.
enum Child {
    Leaves(std::ops::Range<usize>, [DVec3; 2]),
    Node(usize, [DVec3; 2]),
}

fn children(node: &BvhNode) -> Vec<Child> {
    let point = |p: [f32; 3]| Vec3::from(p).as_dvec3();
    let child = |child: &BvhChild| {
        let inside = child.corners().map(point);
        let first = child.first() as usize;
        match child.count() {
            0 => Child::Node(first, inside),
            count => Child::Leaves(first..first + count as usize, inside),
        }
    };
    // A single leaf is both children of its node, the second time where no ray goes.
    let mut found = vec![child(&node.left)];
    if node.right.corners()[0] != [1e30; 3] {
        found.push(child(&node.right));
    }
    found
}

/// Asserts that `outer` holds `inner`, but for what telling both by centre and half size rounds: boxes have room for more.
fn assert_holds(outer: [DVec3; 2], inner: [DVec3; 2]) {
    let rounding = 2.0 * f64::from(f32::EPSILON) * outer[0].abs().max(outer[1].abs());
    let holds = (outer[0] - rounding).cmple(inner[0]).all() && inner[1].cmple(outer[1] + rounding).all();
    assert!(holds, "{inner:?} reaches out of {outer:?}");
}

fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![4 => -10.0f32..10.0, 1 => Just(0.0), 1 => -1e15f32..1e15, 1 => -1e-15f32..1e-15]
}

fn point() -> impl Strategy<Value = Vec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from)
}

fn length() -> impl Strategy<Value = f32> {
    prop_oneof![3 => 0.01f32..10.0, 1 => 1e-15f32..1e-10, 1 => 1e10f32..1e15]
}

fn geometry() -> impl Strategy<Value = Geometry> {
    let size = [length(), length(), length()].prop_map(Vec3::from);
    prop_oneof![
        (point(), length()).prop_map(|(center, radius)| Geometry::Sphere { center, radius }),
        point().prop_map(|point| Geometry::Plane { point, normal: Vec3::Y }),
        (point(), length(), length()).prop_map(|(corner, u, v)| Geometry::Rectangle {
            corner,
            edge_u: Vec3::X * u,
            edge_v: Vec3::Z * v
        }),
        (point(), length()).prop_map(|(center, radius)| Geometry::Disk { center, normal: Vec3::Y, radius }),
        (point(), length(), length()).prop_map(|(base, height, radius)| Geometry::Cylinder {
            base,
            // Far from the origin a small height is none, which no scene has.
            top: base + height.max(2.0 * f32::EPSILON * base.z.abs()) * Vec3::Z,
            radius,
            capped: true
        }),
        (point(), size, [-720.0f32..720.0, -720.0f32..720.0, -720.0f32..720.0])
            .prop_map(|(center, size, turn)| { Geometry::Box { center, size, rotation_degrees: Vec3::from(turn) } }),
    ]
}

proptest! {
    #[test]
    fn any_scene_translates(shapes in proptest::collection::vec(geometry(), 0..200)) {
        assert_sound(&scene(shapes, None));
    }

    #[test]
    fn any_dielectric_scene_translates_or_is_refused(shapes in proptest::collection::vec(geometry(), 0..40)) {
        let scene = scene(shapes, Some(1.5));
        match DeviceScene::new(&scene) {
            Ok(_) => assert_sound(&scene),
            Err(TranslationError::TooManyMedia { found, .. }) => prop_assert!(found > MAX_NESTED_MEDIA as usize),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}

#[test]
fn a_chain_of_nested_bodies_does_not_make_the_hierarchy_too_deep() {
    let spheres = (0..95).map(|i| Geometry::Sphere { center: Vec3::ZERO, radius: 1e-14 * 2f32.powi(i) });
    assert_sound(&scene(spheres.collect(), None));
}

#[test]
fn coincident_shapes_translate() {
    let sphere = Geometry::Sphere { center: Vec3::ONE, radius: 1.0 };
    assert_sound(&scene(vec![sphere; 10_000], None));
}

#[test]
fn an_empty_scene_translates() {
    assert_sound(&scene(vec![], None));
}
