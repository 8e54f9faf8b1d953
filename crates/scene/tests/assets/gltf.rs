//! glTF models bring materials, lights, cameras and animations beside their triangles.

use glam::DVec3;
use raggio_scene::{AssetOptions, Assets, Environment, LightKind, Scene, Vec3};

use crate::assets::files::{Folder, meshes};

/// Two triangles of one mesh, the second 5 to the right and twice as large; a red material, and a primitive without; a
/// point light and a camera; an animation that moves the first triangle up by 3 within a second.
const MODEL: &str = r#"{
  "asset": { "version": "2.0" },
  "extensionsUsed": ["KHR_lights_punctual"],
  "extensions": { "KHR_lights_punctual": { "lights": [
    { "type": "point", "intensity": 7, "color": [1, 0.5, 0] },
    { "type": "directional", "intensity": 3 }
  ] } },
  "scene": 0,
  "scenes": [{ "nodes": [0, 1, 2, 3, 4] }],
  "nodes": [
    { "mesh": 0 },
    { "mesh": 0, "translation": [5, 0, 0], "scale": [2, 2, 2] },
    { "translation": [0, 4, 0], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
    { "translation": [0, 1, 9], "camera": 0 },
    { "extensions": { "KHR_lights_punctual": { "light": 1 } } }
  ],
  "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.0, "aspectRatio": 2.0, "znear": 0.1 } }],
  "materials": [{ "name": "red", "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0 } }],
  "meshes": [{ "primitives": [
    { "attributes": { "POSITION": 0 }, "material": 0 },
    { "attributes": { "POSITION": 0 } }
  ] }],
  "animations": [{
    "samplers": [{ "input": 1, "output": 2 }],
    "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }]
  }],
  "buffers": [{ "byteLength": 68, "uri": "model.bin" }],
  "bufferViews": [{ "buffer": 0, "byteLength": 68 }],
  "accessors": [
    { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 0] },
    { "bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] },
    { "bufferView": 0, "byteOffset": 44, "componentType": 5126, "count": 2, "type": "VEC3" }
  ]
}"#;

const SHAPE: &str = "[environment]\ncolor = [1, 1, 1]\n[[shapes]]\n";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("model.gltf", MODEL);
    let floats = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0];
    folder.write("model.bin", floats.map(f32::to_le_bytes).concat());
    folder
}

fn heights(scene: &Scene) -> Vec<f64> {
    meshes(scene).iter().map(|(_, world_from_mesh, _)| world_from_mesh.translation.y).collect()
}

#[test]
fn each_instance_is_a_shape() {
    let scene = folder().scene(&format!("{SHAPE}mesh = {{ file = \"model.gltf\", translation = [0, 0, 10] }}\n"));
    let names: Vec<&str> = scene.materials.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["model.gltf/red", "model.gltf/default"]);
    assert_eq!((scene.shapes.len(), scene.entries[0].shapes.clone()), (2, 0..2));
    assert!(scene.shapes.iter().all(|shape| (shape.entry, shape.material) == (0, 1)));
    let [(a, first, Some(0)), (b, second, Some(0))] = meshes(&scene)[..] else {
        panic!("two with their own materials")
    };
    assert!(std::sync::Arc::ptr_eq(a, b));
    assert_eq!(first.transform_point3(DVec3::ONE), DVec3::new(1.0, 1.0, 11.0));
    assert_eq!(second.transform_point3(DVec3::ONE), DVec3::new(7.0, 2.0, 12.0));
}

#[test]
fn its_lights_are_placed_and_scaled_with_it() {
    let keys = "rotation_degrees = [0, 0, 90], scale = 10, translation = [0, 0, 1]";
    let scene = folder().scene(&format!("{SHAPE}mesh = {{ file = \"model.gltf\", {keys} }}\n"));
    let [point, sun] = &scene.lights[..] else { panic!("two lights") };
    assert_eq!((point.kind, sun.kind), (LightKind::Point, LightKind::Directional));
    assert!(point.position.abs_diff_eq(DVec3::new(-40.0, 0.0, 1.0), 1e-9), "{}", point.position);
    // A light ten times as far from everything has to be a hundred times as strong.
    assert!(Vec3::from(point.intensity).abs_diff_eq(Vec3::new(700.0, 350.0, 0.0), 1e-3), "{:?}", point.intensity);
    assert_eq!(sun.intensity, [3.0; 3]);
    assert!(sun.direction.abs_diff_eq(DVec3::NEG_Z, 1e-12), "{}", sun.direction);
}

#[test]
fn the_time_is_the_scenes_unless_somebody_says_another() {
    let folder = folder();
    let shape = |time: &str| format!("[[shapes]]\nmesh = {{ file = \"model.gltf\"{time} }}\n");
    let body = format!("[environment]\ncolor = [1, 1, 1]\n{}{}", shape(""), shape(", time = 0.5"));
    let scene = folder.scene(&body);
    assert_eq!(heights(&scene), [0.0, 0.0, 1.5, 0.0]);
    let mut assets = Assets::new(AssetOptions { time_seconds: Some(1.0), ..AssetOptions::default() });
    let scene = folder.read(&body, &mut assets).unwrap();
    assert_eq!(heights(&scene), [3.0, 0.0, 3.0, 0.0]);
    assert_eq!(assets.files().count(), 1);
}

/// A sequence goes on from each model's own time, and shares with the frame before what has not changed.
#[test]
fn a_sequence_goes_on_from_the_times() {
    let folder = folder();
    folder.write("still.gltf", MODEL.replace("animations", "extras"));
    let shape = |file: &str, time: &str| format!("[[shapes]]\nmesh = {{ file = \"{file}.gltf\"{time} }}\n");
    let shapes = [shape("model", ""), shape("model", ", time = 0.5"), shape("still", "")].concat();
    let body = format!("[environment]\ncolor = [1, 1, 1]\n{shapes}");
    let mut assets = Assets::new(AssetOptions { elapsed_seconds: Some(0.0), ..AssetOptions::default() });
    let first = folder.read(&body, &mut assets).unwrap();
    assert_eq!(heights(&first), [0.0, 0.0, 1.5, 0.0, 0.0, 0.0]);
    assets.set_elapsed(0.25);
    let second = folder.read(&body, &mut assets).unwrap();
    assert_eq!(heights(&second), [0.75, 0.0, 2.25, 0.0, 0.0, 0.0]);
    for (before, after) in meshes(&first).iter().zip(meshes(&second)) {
        assert!(std::sync::Arc::ptr_eq(before.0, after.0));
    }
    let [Some(before), Some(after)] = [&first, &second].map(|scene| scene.materials[0].principled.as_ref()) else {
        panic!("a material of the model's")
    };
    assert!(std::sync::Arc::ptr_eq(before, after));
    let at_rest = assets.files().count();
    assets.set_elapsed(-1.0);
    assert_eq!(heights(&folder.read(&body, &mut assets).unwrap()), [0.0; 6]);
    assert_eq!(assets.files().count(), at_rest - 1, "both are at their beginning, and the other frames are forgotten");
}

/// Ground and sky of a model that is shown alone stay where they are, and so does a camera that is not its own.
#[test]
fn a_sequence_of_a_model_alone_keeps_its_surroundings() {
    let folder = folder();
    let camera = r#"{ "mesh": 0, "name": "moved" },"#;
    folder.write("own.gltf", MODEL.replace("{ \"mesh\": 0 },", camera).replace("\"node\": 0", "\"node\": 3"));
    folder.write("bare.gltf", MODEL.replace(r#", "camera": 0"#, ""));
    let at = |file: &str, elapsed: f64| {
        let mut assets = Assets::new(AssetOptions { elapsed_seconds: Some(elapsed), ..AssetOptions::default() });
        Scene::load_with(&folder.path(file), &mut assets).unwrap()
    };
    let [first, second] = [0.0, 0.5].map(|elapsed| at("bare.gltf", elapsed));
    assert_eq!(first.camera, second.camera);
    assert_eq!(first.shapes[0], second.shapes[0]);
    assert_ne!(first.shapes[1], second.shapes[1]);
    let [first, second] = [0.0, 0.5].map(|elapsed| at("own.gltf", elapsed));
    assert_eq!(second.camera.position - first.camera.position, Vec3::new(0.0, 1.5, 0.0));
    assert_eq!(first.shapes[0], second.shapes[0]);
}

#[test]
fn a_time_of_a_model_without_animations() {
    let folder = folder();
    folder.write("still.gltf", MODEL.replace("animations", "extras"));
    let still = "[[shapes]]\nmesh = { file = \"still.gltf\", time = 2 }\n";
    let [warning] = &folder.scene(still).warnings[..] else { panic!("one warning") };
    assert_eq!(
        folder.shown(warning),
        "scene.toml:7:31: `time` in `mesh` of shape 1 does nothing: still.gltf has no animations"
    );
    let timed = || Assets::new(AssetOptions { time_seconds: Some(1.0), ..AssetOptions::default() });
    let shown = Scene::load_with(&folder.path("still.gltf"), &mut timed()).unwrap();
    let expected = "a time is given, but nothing in the scene moves: its .gltf and .glb files have no animations";
    assert_eq!(shown.warnings, [expected]);
    // One that moves is enough for a time to make sense.
    let both = format!("{still}[[shapes]]\nmesh = {{ file = \"model.gltf\" }}\n");
    assert_eq!(folder.read(&both, &mut timed()).unwrap().warnings, [""; 0]);
}

#[test]
fn files_that_a_model_names_are_those_of_the_scene() {
    let folder = folder();
    let mut assets = Assets::default();
    folder.read(&format!("{SHAPE}mesh = {{ file = \"model.gltf\" }}\n"), &mut assets).unwrap();
    let mut files: Vec<_> = assets.all_files().map(std::path::Path::to_path_buf).collect();
    files.sort();
    assert_eq!(files, ["model.bin", "model.gltf"].map(|name| folder.path(name).canonicalize().unwrap()));
}

#[test]
fn a_model_may_name_no_file_outside_its_folder_unless_it_is_allowed_to() {
    let folder = folder();
    std::fs::create_dir(folder.path("sub")).unwrap();
    folder.write("sub/model.gltf", MODEL.replace("model.bin", "../model.bin"));
    let body = format!("{SHAPE}mesh = {{ file = \"sub/model.gltf\" }}\n");
    let error = folder.error(&body);
    assert!(error.starts_with("scene.toml:9:17: sub/model.gltf: buffers[0]: `../model.bin` is outside"), "{error}");
    let mut assets = Assets::new(AssetOptions { allow_outside: true, ..AssetOptions::default() });
    assert_eq!(folder.read(&body, &mut assets).unwrap().shapes.len(), 2);
}

#[test]
fn it_is_shown_by_its_own_camera_and_lights() {
    let folder = folder();
    let mut assets = Assets::new(AssetOptions { time_seconds: Some(1.0), ..AssetOptions::default() });
    let scene = Scene::load_with(&folder.path("model.gltf"), &mut assets).unwrap();
    let camera = &scene.camera;
    assert_eq!((camera.position, camera.up), (Vec3::new(0.0, 1.0, 9.0), Vec3::Y));
    assert!((camera.half_height() - 0.5f64.tan()).abs() < 1e-6);
    let towards = (camera.look_at - camera.position).normalize();
    assert!(towards.abs_diff_eq(Vec3::NEG_Z, 1e-6), "{towards}");
    assert_eq!((scene.render.width, scene.render.height), (1440, 720));
    assert_eq!(heights(&scene), [3.0, 0.0]);
    let Environment::Gradient { zenith, .. } = scene.environment else { panic!("a gradient") };
    assert!(zenith.max_element() < 0.2, "{zenith}");
    assert_eq!(scene.lights.len(), 2);
    assert!(scene.materials.iter().any(|it| it.name == "model.gltf/red" && it.imported));
}

#[test]
fn a_buffer_that_changes_is_read_again() {
    let folder = folder();
    let mut assets = Assets::default();
    let body = format!("{SHAPE}mesh = {{ file = \"model.gltf\" }}\n");
    let corner = |scene: &Scene| meshes(scene)[0].0.positions[2];
    assert_eq!(corner(&folder.read(&body, &mut assets).unwrap()), [0.0, 2.0, 0.0]);
    let mut bytes = std::fs::read(folder.path("model.bin")).unwrap();
    bytes[28..32].copy_from_slice(&2.5f32.to_le_bytes());
    // A file of the same length: what tells is the time at which it was written.
    std::thread::sleep(std::time::Duration::from_millis(20));
    folder.write("model.bin", bytes);
    assert!(assets.refresh());
    assert_eq!(corner(&folder.read(&body, &mut assets).unwrap()), [0.0, 2.5, 0.0]);
    // Without the buffer there is no model; it is one again once the buffer is back.
    let bytes = std::fs::read(folder.path("model.bin")).unwrap();
    std::fs::remove_file(folder.path("model.bin")).unwrap();
    assert!(assets.refresh());
    assert!(folder.read(&body, &mut assets).unwrap_err().to_string().contains("model.bin"));
    folder.write("model.bin", bytes);
    assert!(assets.refresh());
    assert_eq!(corner(&folder.read(&body, &mut assets).unwrap()), [0.0, 2.5, 0.0]);
}
