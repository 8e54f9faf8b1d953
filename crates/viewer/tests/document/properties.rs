//! Properties of random edits: the text says what the scene is, and undoing all of them gives the first text back.

use proptest::prelude::*;
use raggio_scene::{Environment, Geometry, LightEntry, LightPlace, Reflection, Shape, Vec3};
use raggio_viewer::document::Document;

use crate::document::{FORMS, check, document};

#[derive(Clone, Debug)]
enum Act {
    Camera(Vec3, f32),
    Material(usize, Vec3, f32),
    AddMaterial(Vec3),
    Shape(usize, Geometry, usize),
    AddShape(Geometry, usize),
    Remove(usize),
    Duplicate(usize),
    Light(usize, LightEntry),
    AddLight(LightEntry),
    RemoveLight(usize),
    Environment(Vec3, Option<Vec3>),
    Render(u32),
    Path(usize, f32),
    Gesture(bool),
    Undo,
    Redo,
}

/// Vectors, some of them out of range.
fn vector(range: std::ops::Range<f32>) -> impl Strategy<Value = Vec3> {
    let number = prop_oneof![range, Just(0.0), Just(1.0), Just(0.1)];
    prop::array::uniform3(number).prop_map(Vec3::from)
}

fn geometry() -> impl Strategy<Value = Geometry> {
    prop_oneof![
        (vector(-9.0..9.0), -0.1f32..2.0).prop_map(|(center, radius)| Geometry::Sphere { center, radius }),
        (vector(-9.0..9.0), vector(-1.0..1.0)).prop_map(|(point, normal)| Geometry::Plane { point, normal }),
        (vector(-9.0..9.0), 0.1f32..2.0).prop_map(|(corner, u)| Geometry::Rectangle {
            corner,
            edge_u: Vec3::X * u,
            edge_v: Vec3::Z
        }),
        (vector(-9.0..9.0), vector(-1.0..1.0), -0.1f32..2.0).prop_map(|(center, normal, radius)| Geometry::Disk {
            center,
            normal,
            radius
        }),
        (vector(-9.0..9.0), vector(-9.0..9.0), -0.1f32..2.0, any::<bool>())
            .prop_map(|(base, top, radius, capped)| Geometry::Cylinder { base, top, radius, capped }),
        (vector(-9.0..9.0), vector(-9.0..9.0), 1.0f32..2.0, -0.1f32..1.1, any::<bool>()).prop_map(
            |(base, top, radius, top_radius, capped)| Geometry::Cone { base, top, radius, top_radius, capped }
        ),
        (vector(-9.0..9.0), vector(0.0..2.0), vector(-90.0..90.0))
            .prop_map(|(center, size, rotation_degrees)| Geometry::Box { center, size, rotation_degrees }),
    ]
}

/// Lights, some of them out of range.
fn light() -> impl Strategy<Value = LightEntry> {
    let direction = || vector(-1.0..1.0);
    let place = prop_oneof![
        vector(-9.0..9.0).prop_map(|position| LightPlace::Point { position }),
        (vector(-9.0..9.0), direction(), 0.0f32..50.0, 40.0f32..95.0).prop_map(
            |(position, direction, inner_degrees, outer_degrees)| {
                LightPlace::Spot { position, direction, inner_degrees, outer_degrees }
            }
        ),
        (direction(), prop_oneof![Just(0.0), 0.0f32..0.02, 0.0f32..181.0])
            .prop_map(|(direction, angle_degrees)| LightPlace::Directional { direction, angle_degrees }),
    ];
    (place, vector(0.0..2.0), -0.1f32..9.0).prop_map(|(place, color, intensity)| LightEntry { place, color, intensity })
}

fn act() -> impl Strategy<Value = Act> {
    let index = 0usize..4;
    prop_oneof![
        (vector(-9.0..9.0), -0.1f32..1.0).prop_map(|(position, aperture)| Act::Camera(position, aperture)),
        (index.clone(), vector(0.0..1.1), -0.1f32..1.0).prop_map(|(i, color, x)| Act::Material(i, color, x)),
        vector(0.0..1.0).prop_map(Act::AddMaterial),
        (index.clone(), geometry(), index.clone()).prop_map(|(i, it, material)| Act::Shape(i, it, material)),
        (geometry(), index.clone()).prop_map(|(it, material)| Act::AddShape(it, material)),
        index.clone().prop_map(Act::Remove),
        index.clone().prop_map(Act::Duplicate),
        (index.clone(), light()).prop_map(|(i, it)| Act::Light(i, it)),
        light().prop_map(Act::AddLight),
        index.clone().prop_map(Act::RemoveLight),
        (vector(-0.1..1.0), prop::option::of(vector(0.0..1.0))).prop_map(|(a, b)| Act::Environment(a, b)),
        (0u32..300).prop_map(Act::Render),
        (index, -0.1f32..1.0).prop_map(|(i, x)| Act::Path(i, x)),
        any::<bool>().prop_map(Act::Gesture),
        Just(Act::Undo),
        Just(Act::Redo),
    ]
}

/// Performs an act; false when it was refused.
fn perform(it: &mut Document, act: &Act) -> bool {
    let scene = it.scene().clone();
    match act.clone() {
        Act::Camera(position, aperture_radius) => {
            let camera = raggio_scene::Camera { position, aperture_radius, ..scene.camera };
            it.set_camera(&camera).is_ok_and(|_| it.scene().camera == camera)
        }
        Act::Material(index, color, x) => {
            let Some(old) = scene.materials.get(index) else {
                return it.set_material(index, &scene.materials[0]).is_ok();
            };
            let mut material = old.clone();
            (material.color, material.emission_strength) = (color, x);
            material.refractive_index = (x > 0.5).then_some(1.0 + x);
            material.reflection = if x > 0.7 { Reflection::Probability(x) } else { Reflection::Fresnel };
            it.set_material(index, &material).is_ok_and(|_| it.scene().materials[index] == material)
        }
        Act::AddMaterial(color) => {
            let material = raggio_scene::Material { color, ..scene.materials[0].clone() };
            it.add_material("new", &material).is_ok_and(|index| it.scene().materials[index].color == color)
        }
        Act::Shape(index, geometry, material) => it
            .set_shape(index, &geometry, material)
            .is_ok_and(|_| is_like(&it.scene().shapes[index].geometry, &geometry)),
        Act::AddShape(geometry, material) => {
            it.add_shape(&geometry, material).is_ok_and(|index| is_like(&it.scene().shapes[index].geometry, &geometry))
        }
        Act::Remove(index) => it.remove_shape(index).is_ok_and(|_| it.scene().shapes.len() + 1 == scene.shapes.len()),
        Act::Duplicate(index) => it.duplicate_shape(index).is_ok_and(|copy| {
            let copy = Shape { entry: index, ..it.scene().shapes[copy].clone() };
            copy == it.scene().shapes[index]
        }),
        Act::Light(index, light) => {
            it.set_light(index, &light).is_ok_and(|_| is_like_light(&it.scene().light_entries[index], &light))
        }
        Act::AddLight(light) => {
            it.add_light(&light).is_ok_and(|index| is_like_light(&it.scene().light_entries[index], &light))
        }
        Act::RemoveLight(index) => {
            it.remove_light(index).is_ok_and(|_| it.scene().light_entries.len() + 1 == scene.light_entries.len())
        }
        Act::Environment(color, zenith) => {
            let environment = match zenith {
                Some(zenith) => Environment::Gradient { horizon: color, zenith },
                None => Environment::Constant(color),
            };
            it.set_environment(&environment).is_ok_and(|_| it.scene().environment == environment)
        }
        Act::Render(samples) => {
            let render = raggio_scene::RenderSettings { samples, ..scene.render };
            it.set_render(&render).is_ok_and(|_| it.scene().render == render)
        }
        Act::Path(index, x) => it.edit_path(&format!("shapes.{index}.sphere.radius"), &x.to_string()).is_ok(),
        Act::Gesture(true) => {
            it.begin_gesture("it");
            true
        }
        Act::Gesture(false) => {
            it.end_gesture();
            true
        }
        Act::Undo => it.undo().is_some(),
        Act::Redo => it.redo().is_some(),
    }
}

/// Whether a geometry was read as it was written; normals are made unit vectors when they are read.
fn is_like(read: &Geometry, written: &Geometry) -> bool {
    match (read, written) {
        (Geometry::Plane { point, normal }, Geometry::Plane { point: p, normal: n }) => {
            point == p && normal.abs_diff_eq(n.normalize(), 1e-6)
        }
        (Geometry::Disk { center, normal, radius }, Geometry::Disk { center: c, normal: n, radius: r }) => {
            center == c && normal.abs_diff_eq(n.normalize(), 1e-6) && radius == r
        }
        _ => read == written,
    }
}

/// Whether a light was read as it was written; directions are made unit vectors when they are read.
fn is_like_light(read: &LightEntry, written: &LightEntry) -> bool {
    let unit = |direction: &mut Vec3, other: Vec3| {
        let is_near = direction.abs_diff_eq(other.normalize(), 1e-6);
        *direction = other;
        is_near
    };
    let mut read = *read;
    let is_near = match (&mut read.place, written.place) {
        (LightPlace::Spot { direction, .. }, LightPlace::Spot { direction: other, .. })
        | (LightPlace::Directional { direction, .. }, LightPlace::Directional { direction: other, .. }) => {
            unit(direction, other)
        }
        _ => true,
    };
    is_near && read == *written
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn text_and_scene_agree(form in 0usize..3, acts in prop::collection::vec(act(), 1..25)) {
        let mut it = document(FORMS[form]);
        for act in &acts {
            let before = it.text().to_string();
            let done = perform(&mut it, act);
            // An act that was refused changed nothing.
            prop_assert!(done || it.text() == before, "{act:?}\n{before}\n-- became --\n{}", it.text());
            check(&it);
        }
        let end = it.text().to_string();
        while it.undo().is_some() {
            check(&it);
        }
        prop_assert_eq!(it.text(), FORMS[form]);
        while it.redo().is_some() {}
        prop_assert!(it.can_redo().is_none());
        // Steps undone before the end come back too.
        while it.text() != end && it.undo().is_some() {}
        prop_assert_eq!(it.text(), end);
    }
}
