//! Placement of things: hierarchy, scenes, instances, lights, cameras.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
use std::time::Instant;

use glam::{DAffine3, DVec3};
use raggio_models::{GltfOptions, LightKind, Projection};
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
fn nodes_that_are_listed_twice_are_shown_once() {
    let mut builder = Builder::triangle();
    builder.json["nodes"] = json!([
        { "name": "parent", "mesh": 0, "children": [1, 1], "translation": [1, 0, 0] },
        { "name": "child", "mesh": 0, "translation": [1, 0, 0] },
        { "name": "other", "mesh": 0, "children": [1] },
    ]);
    let shown = |builder: &Builder| {
        let places = builder.load().instances;
        places.iter().map(|it| (it.name.to_string(), it.model_from_mesh.translation.x)).collect::<Vec<_>>()
    };
    let all = [("parent".to_string(), 1.0), ("child".to_string(), 2.0), ("other".to_string(), 0.0)];
    assert_eq!(shown(&builder), all);
    let told = |parent: usize| {
        format!("nodes[{parent}].children lists node 1, a child of node 0 already: it is shown there alone")
    };
    assert_eq!(builder.load().warnings, [told(0), told(2)]);

    builder.json["nodes"][0]["children"] = json!([1]);
    builder.json["nodes"][2] = json!({ "name": "other", "mesh": 0 });
    builder.json["scenes"] = json!([{ "nodes": [0, 1, 2, 2] }]);
    assert_eq!(shown(&builder), all);
    let told = |node: usize| {
        format!("scenes[0].nodes lists node {node}, which is listed twice or a child of another: it is shown once")
    };
    assert_eq!(builder.load().warnings, [told(1), told(2)]);
    builder.json["scenes"] = json!([{ "nodes": [1] }]);
    assert_eq!(shown(&builder), [("child".to_string(), 2.0)]);
}

#[test]
fn rotations_without_length_turn_nothing() {
    let mut builder = Builder::triangle();
    builder.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    builder.json["nodes"][0]["translation"] = json!([1, 2, 3]);
    let place = builder.load().instances[0].model_from_mesh;
    assert_eq!(place, DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0)));
    let message = "should be a unit quaternion and is [0.0, 0.0, 0.0, 0.0]: nothing is turned";
    assert_eq!(builder.warning(), format!("nodes[0].rotation {message}"));

    let mut builder = Builder::triangle();
    let rotations = builder.floats("VEC4", &[0.0; 4]);
    let attributes = json!({ "ROTATION": rotations });
    builder.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    assert_eq!(builder.load().instances[0].model_from_mesh, DAffine3::IDENTITY);
    let path = "nodes[0].extensions.EXT_mesh_gpu_instancing: the rotation of instance 0";
    assert_eq!(builder.warning(), format!("{path} {message}"));
}

#[test]
fn a_matrix_wins_over_what_stands_beside_it() {
    let mut builder = Builder::triangle();
    builder.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1]);
    builder.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    let place = builder.load().instances[0].model_from_mesh;
    assert_eq!(place, DAffine3::from_translation(DVec3::new(10.0, 20.0, 30.0)));
    let expected = "nodes[0] has a `translation`, `rotation` or `scale` beside its `matrix`: the matrix alone is used";
    assert_eq!(builder.warning(), expected);
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
    assert!(model.warnings[0].contains("1 instance is scaled to nothing"));
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

/// A spot whose angles are equal has a hard edge, and is what three.js writes unless it is told otherwise.
#[test]
fn spots_with_hard_edges() {
    let spot = |inner: f64, outer: f64| {
        with_light(json!({ "type": "spot", "spot": { "innerConeAngle": inner, "outerConeAngle": outer } }))
    };
    let kind = |builder: &Builder| builder.load().lights[0].kind;
    let told = |builder: &Builder, used: &str| {
        let path = "extensions.KHR_lights_punctual.lights[0].spot";
        let expected = format!("{path}: the angles are {used} are used, for 0 <= inner <= outer <= pi / 2");
        assert_eq!(builder.warning(), expected);
    };
    let equal = spot(0.5, 0.5);
    assert_eq!(kind(&equal), LightKind::Spot { inner: 0.5, outer: 0.5 });
    assert_eq!(equal.load().warnings, [""; 0]);
    let crossed = spot(0.9, 0.5);
    assert_eq!(kind(&crossed), LightKind::Spot { inner: 0.5, outer: 0.5 });
    told(&crossed, "0.9 and 0.5: 0.5 and 0.5");
    let wide = spot(0.25, 3.0);
    assert_eq!(kind(&wide), LightKind::Spot { inner: 0.25, outer: FRAC_PI_2 });
    told(&wide, "0.25 and 3: 0.25 and 1.5707964");
    assert_eq!(kind(&spot(-1.0, 0.5)), LightKind::Spot { inner: 0.0, outer: 0.5 });
    assert_eq!(spot(0.0, 1.570_796_5).load().warnings, [""; 0], "a right angle that is rounded up");
}

#[test]
fn lights_out_of_range() {
    let negative = with_light(json!({ "type": "point", "intensity": -1 }));
    assert!(negative.load().lights.is_empty());
    assert!(
        negative.warning().contains("lights[0] is left out: its intensity is [-1.0, -1.0, -1.0], and should be finite")
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
        { "name": "plan", "type": "orthographic", "orthographic": { "xmag": 3, "ymag": 2, "znear": 0, "zfar": 1 } },
    ]);
    builder.push("nodes", json!({ "camera": 0, "translation": [0, 0, 5], "rotation": [0, half(), 0, half()] }));
    builder.push("nodes", json!({ "camera": 1, "rotation": [-half(), 0, 0, half()] }));
    builder.push("nodes", json!({ "name": "second", "camera": 0 }));
    let model = builder.load();
    assert_eq!(model.cameras.iter().map(|camera| camera.name.as_str()).collect::<Vec<_>>(), ["eye", "plan", "second"]);
    let camera = &model.cameras[0];
    assert_eq!(camera.projection, Projection::Perspective { vertical_fov: 0.5, aspect: Some(1.5) });
    assert_eq!(camera.aspect(), Some(1.5));
    assert_eq!(camera.position, DVec3::new(0.0, 0.0, 5.0));
    assert_close(&camera.forward.to_array(), &[-1.0, 0.0, 0.0]);
    assert_close(&camera.up.to_array(), &[0.0, 1.0, 0.0]);
    let plan = &model.cameras[1];
    assert_eq!((plan.projection, plan.aspect()), (Projection::Orthographic { xmag: 3.0, ymag: 2.0 }, Some(1.5)));
    assert_close(&plan.forward.to_array(), &[0.0, -1.0, 0.0]);
    assert_close(&plan.up.to_array(), &[0.0, 0.0, -1.0]);
    assert_eq!(model.warnings, [""; 0]);
}

#[test]
fn cameras_out_of_range() {
    let camera = |camera: serde_json::Value| {
        let mut builder = Builder::triangle();
        builder.push("cameras", camera);
        builder.push("nodes", json!({ "camera": 0 }));
        builder
    };
    let projection = |builder: &Builder| builder.load().cameras.first().map(|camera| camera.projection);
    for yfov in [0.0, -1.0, 4.0] {
        let builder = camera(json!({ "perspective": { "yfov": yfov } }));
        let expected = Projection::Perspective { vertical_fov: FRAC_PI_4, aspect: None };
        assert_eq!(projection(&builder), Some(expected));
        let message = format!("yfov is {yfov}, and should be between 0 and pi radians: 0.7853982 is used");
        assert_eq!(builder.warning(), format!("cameras[0].perspective.{message}"));
    }
    let flat = camera(json!({ "perspective": { "yfov": 1, "aspectRatio": 0 } }));
    assert_eq!(projection(&flat), Some(Projection::Perspective { vertical_fov: 1.0, aspect: None }));
    assert!(flat.warning().contains("aspectRatio is 0, and should be positive and finite: it is not used"));
    let mirrored = camera(json!({ "orthographic": { "xmag": -2, "ymag": 1 } }));
    assert_eq!(projection(&mirrored), Some(Projection::Orthographic { xmag: 2.0, ymag: 1.0 }));
    assert!(mirrored.warning().contains("`xmag` and `ymag` are -2 and 1: their signs are not used"));
    let empty = camera(json!({ "orthographic": { "xmag": 0, "ymag": 1 } }));
    assert_eq!(projection(&empty), None);
    assert!(empty.warning().contains("cameras[0] is left out: `xmag` and `ymag` are 0 and 1"));
    let neither = camera(json!({ "type": "perspective" }));
    assert_eq!(projection(&neither), None);
    assert!(neither.warning().contains("cameras[0] is left out: it should be `perspective` or `orthographic`"));
}
