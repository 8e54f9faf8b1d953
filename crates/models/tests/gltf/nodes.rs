//! Placement of things: hierarchy, scenes, instances, lights, cameras.

use std::f32::consts::FRAC_PI_4;
use std::time::Instant;

use glam::{DAffine3, DVec3};
use raggio_models::{GltfOptions, LightKind};
use serde_json::json;

use crate::gltf::builder::{Builder, assert_close};

fn half() -> f64 {
    0.5f64.sqrt()
}

#[test]
fn transforms_of_parents_come_on_top() {
    let mut builder = Builder::triangle();
    builder.json["nodes"] = json!([
        { "name": "leaf", "mesh": 0, "translation": [1, 0, 0] },
        { "name": "turned", "rotation": [0, 0, half(), half()], "scale": [2, 2, 2], "children": [0] },
        { "name": "root", "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1], "children": [1, 3] },
        { "name": "other", "mesh": 0 },
    ]);
    let model = builder.load();
    assert_eq!(model.meshes.len(), 1, "both nodes share it");
    let names: Vec<_> = model.instances.iter().map(|instance| &*instance.name).collect();
    assert_eq!(names, ["leaf", "other"]);
    let at = |i: usize, point: DVec3| model.instances[i].model_from_mesh.transform_point3(point).to_array();
    assert_close(&at(0, DVec3::ZERO), &[10.0, 22.0, 30.0]);
    assert_close(&at(0, DVec3::X), &[10.0, 24.0, 30.0]);
    assert_close(&at(1, DVec3::X), &[11.0, 20.0, 30.0]);
}

#[test]
fn the_scene_says_what_is_seen() {
    let mut builder = Builder::triangle();
    builder.json["nodes"] = json!([{ "mesh": 0, "name": "a" }, { "mesh": 0, "name": "b" }, { "mesh": 0, "name": "c" }]);
    let names = |builder: &Builder, scene| {
        let model = builder.try_load(&GltfOptions { scene, ..GltfOptions::default() }).unwrap();
        model.instances.iter().map(|instance| instance.name.to_string()).collect::<Vec<_>>()
    };
    assert_eq!(names(&builder, None), ["a", "b", "c"]);
    builder.json["scenes"] = json!([{ "nodes": [2] }, { "nodes": [1, 0] }]);
    assert_eq!(names(&builder, None), ["c"]);
    builder.json["scene"] = json!(1);
    assert_eq!(names(&builder, None), ["b", "a"]);
    assert_eq!(names(&builder, Some(0)), ["c"]);
    assert!(builder.warning().contains("the file has 2 scenes"));
    let error = builder.try_load(&GltfOptions { scene: Some(2), ..GltfOptions::default() }).unwrap_err();
    assert!(error.message.contains("scene 2 is wanted: the file has 2"), "{error}");
}

#[test]
fn hidden_nodes_hide_their_children() {
    let mut builder = Builder::triangle();
    builder.json["nodes"] = json!([
        { "mesh": 0, "name": "a" },
        { "mesh": 0, "children": [0], "extensions": { "KHR_node_visibility": { "visible": false } } },
        { "mesh": 0, "name": "c" },
    ]);
    let model = builder.load();
    assert_eq!(model.instances.len(), 1);
    assert_eq!(&*model.instances[0].name, "c");
}

#[test]
fn flattened_instances_are_left_out() {
    let mut builder = Builder::triangle();
    builder.json["nodes"][0]["scale"] = json!([1, 0, 1]);
    let model = builder.load();
    assert!(model.instances.is_empty());
    assert!(model.warnings[0].contains("1 instances are scaled to nothing"));
}

/// A hierarchy of a hundred thousand generations is read, so nothing may recurse.
#[test]
fn deep_hierarchies() {
    let mut builder = Builder::triangle();
    let depth = 100_000;
    let node = |i: usize| json!({ "children": [i + 1], "translation": [1, 0, 0] });
    let mut nodes: Vec<_> = (0..depth).map(node).collect();
    nodes.push(json!({ "mesh": 0 }));
    builder.json["nodes"] = json!(nodes);
    let translation = builder.load().instances[0].model_from_mesh.translation;
    assert_eq!(translation, DVec3::new(100_000.0, 0.0, 0.0));
}

#[test]
fn gpu_instancing() {
    let mut builder = Builder::triangle();
    let translations = builder.floats("VEC3", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let bytes: Vec<u8> = [0i16, 0, 0, 32767, 0, 0, 23170, 23170].iter().flat_map(|x| x.to_le_bytes()).collect();
    let rotations = builder.accessor("VEC4", crate::gltf::builder::I16, 2, &bytes);
    builder.json["accessors"][rotations]["normalized"] = json!(true);
    let scales = builder.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 3.0, 4.0]);
    let attributes = json!({ "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales, "_ID": scales });
    builder.json["nodes"][0] = json!({
        "mesh": 0,
        "translation": [100, 0, 0],
        "extensions": { "EXT_mesh_gpu_instancing": { "attributes": attributes } },
    });
    let model = builder.load();
    assert_eq!((model.instances.len(), model.meshes.len()), (2, 1));
    let point = |i: usize| model.instances[i].model_from_mesh.transform_point3(DVec3::ONE).to_array();
    assert_close(&point(0), &[102.0, 3.0, 4.0]);
    assert_close(&point(1), &[104.0 - 3.0, 5.0 + 2.0, 6.0 + 4.0]);
    assert!(model.warnings.is_empty());
}

#[test]
fn a_million_instances_take_under_two_seconds() {
    let mut builder = Builder::triangle();
    let count = 1_000_000;
    let values: Vec<f32> = (0..3 * count).map(|i| i as f32).collect();
    let translations = builder.floats("VEC3", &values);
    let attributes = json!({ "TRANSLATION": translations });
    builder.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    let bytes = builder.glb();
    let start = Instant::now();
    let model =
        raggio_models::parse_gltf(&bytes, "a.glb", &crate::gltf::builder::no_files, &GltfOptions::default()).unwrap();
    // The time without optimization is ten times as long, on a machine that does other things, too.
    let most_seconds = if cfg!(debug_assertions) { 20.0 } else { 2.0 };
    assert!(start.elapsed().as_secs_f64() < most_seconds, "{:?}", start.elapsed());
    assert_eq!(model.instances.len(), count);
    assert_eq!(model.instances[7].model_from_mesh, DAffine3::from_translation(DVec3::new(21.0, 22.0, 23.0)));
}

fn with_light(light: serde_json::Value) -> Builder {
    let mut builder = Builder::triangle();
    builder.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
    builder.push(
        "nodes",
        json!({
            "translation": [1, 2, 3],
            "rotation": [half(), 0, 0, half()],
            "scale": [2, 2, 2],
            "extensions": { "KHR_lights_punctual": { "light": 0 } },
        }),
    );
    builder
}

#[test]
fn lights() {
    let builder = with_light(json!({ "type": "point", "name": "lamp", "color": [1, 0.5, 0], "intensity": 8 }));
    let light = builder.load().lights[0].clone();
    assert_eq!((light.name.as_str(), light.intensity, light.kind), ("lamp", [8.0, 4.0, 0.0], LightKind::Point));
    assert_eq!(light.position, DVec3::new(1.0, 2.0, 3.0));
    let light = with_light(json!({ "type": "directional" })).load().lights[0].clone();
    assert_eq!((light.intensity, light.kind), ([1.0; 3], LightKind::Directional));
    // The light's -z, turned a quarter about x.
    assert_close(&light.direction.to_array(), &[0.0, 1.0, 0.0]);
    let light = with_light(json!({ "type": "spot", "spot": { "innerConeAngle": 0.25 } })).load().lights[0].clone();
    assert_eq!(light.kind, LightKind::Spot { inner: 0.25, outer: FRAC_PI_4 });
}

#[test]
fn lights_out_of_range() {
    let spot = json!({ "type": "spot", "spot": { "innerConeAngle": 0.9, "outerConeAngle": 0.5 } });
    let error = with_light(spot).error();
    assert!(error.contains("extensions.KHR_lights_punctual.lights[0].spot: the angles are 0.9 and 0.5"), "{error}");
    assert!(
        with_light(json!({ "type": "point", "intensity": -1 })).error().contains("should be finite and not negative")
    );
    assert!(with_light(json!({ "type": "sun" })).error().contains("unknown variant `sun`"));
    assert!(with_light(json!({ "type": "point", "range": 3 })).warning().contains("ranges of lights are not used"));
}

#[test]
fn cameras() {
    let mut builder = Builder::triangle();
    let perspective = json!({ "yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1 });
    builder.json["cameras"] = json!([
        { "name": "eye", "type": "perspective", "perspective": perspective },
        { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 1 } },
    ]);
    builder.push("nodes", json!({ "camera": 0, "translation": [0, 0, 5], "rotation": [0, half(), 0, half()] }));
    builder.push("nodes", json!({ "camera": 1 }));
    let model = builder.load();
    assert_eq!(model.cameras.len(), 1);
    let camera = &model.cameras[0];
    assert_eq!((camera.name.as_str(), camera.vertical_fov, camera.aspect), ("eye", 0.5, Some(1.5)));
    assert_eq!(camera.position, DVec3::new(0.0, 0.0, 5.0));
    assert_close(&camera.forward.to_array(), &[-1.0, 0.0, 0.0]);
    assert_close(&camera.up.to_array(), &[0.0, 1.0, 0.0]);
    assert!(builder.warning().contains("cameras[1] is left out: only perspective cameras"));
    builder.json["cameras"][0]["perspective"]["yfov"] = json!(4);
    assert!(builder.error().contains("cameras[0].perspective.yfov: is 4: it should be between 0 and pi radians"));
}
