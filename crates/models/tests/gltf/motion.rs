//! Animations, morph targets, skins.

use std::sync::Arc;

use glam::DVec3;
use raggio_models::{GltfOptions, GltfSequence, LoadOptions, Model, load};
use serde_json::json;

use crate::gltf::builder::{Builder, CORNERS, I8, U8, assert_close, png};

/// The triangle's node with a property animated by two keys at 1 and 3 seconds.
fn animated(path: &str, interpolation: &str, kind: &str, values: &[f32]) -> Builder {
    let mut builder = Builder::triangle();
    animate(&mut builder, path, interpolation, kind, values);
    builder
}

fn animate(builder: &mut Builder, path: &str, interpolation: &str, kind: &str, values: &[f32]) {
    let input = builder.floats("SCALAR", &[1.0, 3.0]);
    let output = builder.floats(kind, values);
    let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": path } });
    builder.push("animations", json!({ "name": "clip", "channels": [channel], "samplers": [sampler] }));
}

/// Point to which the animated node takes a point.
fn moved(builder: &Builder, seconds: f64, point: DVec3) -> [f64; 3] {
    builder.load_at(seconds).instances[0].model_from_mesh.transform_point3(point).to_array()
}

#[test]
fn without_a_time_nothing_moves() {
    let builder = animated("translation", "LINEAR", "VEC3", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    let model = builder.load();
    assert_eq!(model.instances[0].model_from_mesh, glam::DAffine3::IDENTITY);
    assert!(model.warnings[0].contains("the file has 1 animation, which needs a time"));
}

#[test]
fn linear_and_step_translation() {
    let values = [10.0, 0.0, 0.0, 20.0, 4.0, 0.0];
    let builder = animated("translation", "LINEAR", "VEC3", &values);
    for (seconds, x, y) in [(0.0, 10.0, 0.0), (1.0, 10.0, 0.0), (2.5, 17.5, 3.0), (3.0, 20.0, 4.0), (9.0, 20.0, 4.0)] {
        assert_close(&moved(&builder, seconds, DVec3::ZERO), &[x, y, 0.0]);
    }
    assert!(builder.load_at(0.0).warnings.is_empty());
    let builder = animated("translation", "STEP", "VEC3", &values);
    for (seconds, x) in [(0.0, 10.0), (2.99, 10.0), (3.0, 20.0), (4.0, 20.0)] {
        assert_close(&moved(&builder, seconds, DVec3::ZERO)[..1], &[x]);
    }
}

#[test]
fn cubic_splines() {
    // Each key has in-tangent, value, out-tangent; Hermite's cubic is by hand, at a quarter of the two seconds.
    let values =
        [[9.0, 9.0, 9.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [-4.0, 0.0, 0.0], [5.0, 0.0, 0.0], [9.0, 9.0, 9.0]];
    let builder = animated("translation", "CUBICSPLINE", "VEC3", values.as_flattened());
    let expected = 0.84375 * 1.0 + 2.0 * 0.140_625 * 2.0 + 0.15625 * 5.0 + 2.0 * -0.046_875 * -4.0;
    assert_close(&moved(&builder, 1.5, DVec3::ZERO), &[expected, 0.0, 0.0]);
    assert_close(&moved(&builder, 0.0, DVec3::ZERO), &[1.0, 0.0, 0.0]);
    assert_close(&moved(&builder, 7.0, DVec3::ZERO), &[5.0, 0.0, 0.0]);
}

#[test]
fn rotations_take_the_short_way_at_even_speed() {
    let half = 0.5f32.sqrt();
    // The second key is a quarter turn about z, with the sign that would send a careless reader the long way round.
    let builder = animated("rotation", "LINEAR", "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half, -half]);
    let (sine, cosine) = std::f64::consts::FRAC_PI_8.sin_cos();
    assert_close(&moved(&builder, 1.5, DVec3::X), &[cosine, sine, 0.0]);
    let mut builder = Builder::triangle();
    let input = builder.floats("SCALAR", &[0.0]);
    let output = builder.accessor("VEC4", I8, 1, &[0, 0, 127, 0]);
    builder.json["accessors"][output]["normalized"] = json!(true);
    let sampler = json!({ "input": input, "output": output });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "rotation" } });
    builder.push("animations", json!({ "channels": [channel], "samplers": [sampler] }));
    assert_close(&moved(&builder, 0.0, DVec3::X), &[-1.0, 0.0, 0.0]);
}

#[test]
fn what_is_not_animated_stays() {
    let mut builder = animated("scale", "LINEAR", "VEC3", &[1.0, 1.0, 1.0, 3.0, 1.0, 1.0]);
    builder.json["nodes"][0]["translation"] = json!([0, 5, 0]);
    assert_close(&moved(&builder, 2.0, DVec3::ONE), &[2.0, 6.0, 1.0]);
    builder.json["nodes"][0] = json!({ "mesh": 0, "matrix": [7, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1] });
    assert_close(&moved(&builder, 2.0, DVec3::ONE), &[2.0, 6.0, 1.0]);
}

#[test]
fn of_animations_that_contend_the_first_counts() {
    let mut builder = animated("translation", "STEP", "VEC3", &[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    animate(&mut builder, "translation", "STEP", "VEC3", &[2.0; 6]);
    animate(&mut builder, "scale", "STEP", "VEC3", &[3.0; 6]);
    assert_close(&moved(&builder, 1.0, DVec3::ONE), &[4.0, 3.0, 3.0]);
    let warnings = builder.load_at(1.0).warnings;
    assert_eq!(warnings, ["animation 1, `clip`, is left out: another one moves the same nodes"]);
}

#[test]
fn animation_pointers_are_told() {
    let mut builder = animated("pointer", "STEP", "VEC3", &[2.0; 6]);
    builder.json["animations"][0]["channels"][0]["target"] = json!({ "path": "pointer" });
    assert!(builder.load_at(0.0).warnings[0].contains("KHR_animation_pointer"));
}

#[test]
fn keys_are_checked() {
    let error = |builder: &Builder| {
        let options = raggio_models::GltfOptions { time_seconds: Some(2.0), ..Default::default() };
        builder.try_load(&options).unwrap_err().message
    };
    let few = animated("translation", "LINEAR", "VEC3", &[1.0; 3]);
    assert!(error(&few).contains("animations[0].channels[0]: the output should have 2 elements for 2 keys"));
    let kind = animated("translation", "LINEAR", "VEC4", &[1.0; 8]);
    assert!(error(&kind).contains("of 3 numbers"), "{}", error(&kind));
    let mut disorder = animated("translation", "LINEAR", "VEC3", &[1.0; 6]);
    let input = disorder.floats("SCALAR", &[3.0, 1.0]);
    disorder.json["animations"][0]["samplers"][0]["input"] = json!(input);
    assert!(error(&disorder).contains("the times of the keys should increase"));
}

#[test]
fn rotations_without_length_turn_nothing() {
    for interpolation in ["LINEAR", "STEP"] {
        let model = animated("rotation", interpolation, "VEC4", &[0.0; 8]).load_at(2.0);
        assert_eq!(model.instances[0].model_from_mesh.matrix3, glam::DMat3::IDENTITY);
        let message = "a rotation should be a unit quaternion and is [0.0, 0.0, 0.0, 0.0]: nothing is turned";
        assert_eq!(model.warnings, [format!("animations[0].channels[0]: {message}")]);
    }
}

/// The triangle with two morph targets; the second is sparse.
fn morphed() -> Builder {
    let mut builder = Builder::triangle();
    let normals = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangents = builder.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    builder.attribute("NORMAL", normals).attribute("TANGENT", tangents);
    let positions = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let normal_deltas = builder.floats("VEC3", &[2.0, 0.0, 0.0].repeat(3));
    let tangent_deltas = builder.floats("VEC3", &[0.0, 4.0, 0.0].repeat(3));
    let indices = builder.view(&[1]);
    let values = builder.view(&[[0u8, 0, 0, 65], [0; 4], [0; 4]].concat());
    let sparse = json!({
        "count": 1, "indices": { "bufferView": indices, "componentType": U8 }, "values": { "bufferView": values },
    });
    let accessor = json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse });
    let second = builder.push("accessors", accessor);
    let first = json!({ "POSITION": positions, "NORMAL": normal_deltas, "TANGENT": tangent_deltas });
    builder.json["meshes"][0]["primitives"][0]["targets"] = json!([first, { "POSITION": second }]);
    builder
}

#[test]
fn morph_targets_by_weights() {
    let mut builder = morphed();
    assert_eq!(builder.mesh().positions, CORNERS);
    builder.json["meshes"][0]["weights"] = json!([0.5, 0.25]);
    let mesh = builder.mesh();
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.5], [3.0, 0.0, 0.5], [0.0, 1.0, 0.5]]);
    assert_eq!(mesh.normals.unwrap()[0], [1.0, 0.0, 1.0]);
    assert_eq!(mesh.tangents.unwrap()[0], [1.0, 2.0, 0.0, -1.0]);
    builder.json["nodes"] = json!([{ "mesh": 0, "weights": [0, 1] }, { "mesh": 0 }, { "mesh": 0, "weights": [0, 1] }]);
    let model = builder.load();
    assert_eq!(model.meshes.len(), 2, "nodes with the same weights share a mesh");
    let meshes: Vec<usize> = model.instances.iter().map(|instance| instance.mesh).collect();
    assert_eq!(meshes, [0, 1, 0]);
    assert_eq!(model.meshes[0].positions[1], [9.0, 0.0, 0.0]);
    assert_eq!(model.meshes[1].positions[1], [3.0, 0.0, 0.5]);
}

#[test]
fn animated_weights() {
    for (interpolation, values) in [
        ("LINEAR", vec![0.0, 0.0, 1.0, 0.5]),
        ("CUBICSPLINE", vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.0]),
    ] {
        let mut builder = morphed();
        animate(&mut builder, "weights", interpolation, "SCALAR", &values);
        let model = builder.load_at(2.0);
        assert_eq!(model.meshes[0].positions[1], [3.0, 0.0, 0.5]);
    }
}

#[test]
fn weights_are_counted() {
    let mut builder = morphed();
    builder.json["nodes"][0]["weights"] = json!([1]);
    assert_eq!(builder.mesh().positions[0], [0.0, 0.0, 1.0]);
    assert_eq!(builder.warning(), "nodes[0].weights has 1 weight for 2 morph targets: the rest is 0");
}

/// A triangle whose first corner hangs on one joint, the second on another, and the third on both.
fn skinned() -> Builder {
    let mut builder = Builder::triangle();
    let normals = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let joints = builder.accessor("VEC4", U8, 3, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = builder.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25, 0.75, 0.0, 0.0]);
    builder.attribute("JOINTS_0", joints).attribute("WEIGHTS_0", weights).attribute("NORMAL", normals);
    let mut inverses = [[0.0f32; 16]; 2];
    for (inverse, x) in inverses.iter_mut().zip([0.0, -1.0]) {
        [0, 5, 10, 15].iter().for_each(|i| inverse[*i] = 1.0);
        inverse[12] = x;
    }
    let inverses = builder.floats("MAT4", inverses.as_flattened());
    builder.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": inverses }]);
    builder.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "name": "skinned", "translation": [77, 0, 0] },
        { "translation": [0, 0, 5], "children": [2] },
        { "translation": [1, 0, 0] },
    ]);
    builder
}

#[test]
fn skins_put_vertices_into_the_world() {
    let mut builder = skinned();
    let model = builder.load();
    assert_eq!(model.instances[0].model_from_mesh, glam::DAffine3::IDENTITY, "the node's own place does not count");
    assert_eq!(model.meshes[0].positions, CORNERS.map(|[x, y, _]| [x, y, 5.0]));
    // The second joint turns by a half about z, in its own place.
    builder.json["nodes"][2]["rotation"] = json!([0, 0, 1, 0]);
    let mesh = builder.mesh();
    let expected = [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [1.5, -0.5, 5.0]].map(|p: [f32; 3]| p.map(f64::from));
    // The third corner is a quarter of (0, 1) and three of (2, -1).
    let found: Vec<f64> = mesh.positions.as_flattened().iter().map(|x| f64::from(*x)).collect();
    assert_close(&found, expected.as_flattened());
    builder.json["nodes"][2]["rotation"] = json!([1, 0, 0, 0]);
    let normals = builder.mesh().normals.unwrap();
    assert_eq!((normals[0], normals[1]), ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]));
}

#[test]
fn mirrored_skeletons_turn_triangles_round() {
    let mut builder = skinned();
    builder.json["nodes"][1]["scale"] = json!([1, 1, -1]);
    let mesh = builder.mesh();
    assert_eq!(mesh.triangles, [[0, 2, 1]]);
    assert_eq!(mesh.normals.unwrap(), [[0.0, 0.0, -1.0]; 3]);
}

#[test]
fn skinned_nodes_have_their_own_meshes() {
    let mut builder = skinned();
    builder.push("nodes", json!({ "mesh": 0, "skin": 0 }));
    builder.push("nodes", json!({ "mesh": 0 }));
    let model = builder.load();
    assert_eq!((model.meshes.len(), model.instances.len()), (3, 3));
    assert_eq!(model.meshes[2].positions, CORNERS);
}

#[test]
fn joints_are_checked_and_meshes_may_lack_them() {
    let mut builder = skinned();
    builder.json["skins"][0]["joints"] = json!([1]);
    let error = builder.error();
    assert!(
        error.contains("meshes[0].primitives[0].attributes.JOINTS_0: names joint 1: the skin has 1 joints"),
        "{error}"
    );
    builder.json["skins"][0]["joints"] = json!([1, 2, 0]);
    assert!(builder.error().contains("skins[0].inverseBindMatrices: has 2 matrices"));
    let mut builder = skinned();
    builder.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0 });
    assert_eq!(builder.mesh().positions[0], [77.0, 0.0, 0.0]);
}

/// The file as it is at each moment when it is read anew, from one that is kept open.
#[test]
fn sequences_are_stills_one_after_the_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut moving = animated("translation", "LINEAR", "VEC3", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    moving.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }));
    moving.push("textures", json!({ "source": 0 }));
    moving.push("images", json!({ "uri": "texels.png" }));
    moving.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    // Warnings of each kind: of the mesh, its material and the scene.
    moving.attribute("UNKNOWN", 0);
    moving.json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = json!(3);
    moving.push("nodes", json!({ "mesh": 0, "scale": [0, 0, 0] }));
    let mut morphing = morphed();
    animate(&mut morphing, "weights", "LINEAR", "SCALAR", &[0.0, 0.0, 1.0, 0.5]);
    let mut walking = skinned();
    animate(&mut walking, "translation", "LINEAR", "VEC3", &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    walking.json["animations"][0]["channels"][0]["target"]["node"] = json!(2);
    walking.push("nodes", json!({ "mesh": 0 }));
    for (name, builder) in [("moving", moving), ("morphing", morphing), ("walking", walking)] {
        for (ending, bytes) in [("gltf", builder.gltf()), ("glb", builder.glb())] {
            let path = folder.path().join(format!("{name}.{ending}"));
            std::fs::write(&path, bytes).expect("a file");
            let texels = folder.path().join("texels.png");
            std::fs::write(&texels, png(&[[1, 2, 3, 255]])).expect("a file");
            let times = [None, Some(0.0), Some(1.5), Some(2.5), Some(2.0), Some(1.5)];
            let still = |time_seconds| load(&path, &LoadOptions { time_seconds, ..LoadOptions::default() }).unwrap();
            let expected = times.map(still);
            let mut sequence = GltfSequence::open(&path, &GltfOptions::default()).unwrap();
            let mut models: Vec<Model> = vec![];
            for time in times {
                models.push(sequence.at(time).unwrap());
                // Nothing is read again.
                let _ = std::fs::remove_file(&texels).and_then(|()| std::fs::write(&path, "no glTF any more"));
            }
            for ((time, found), expected) in times.iter().zip(&models).zip(&expected) {
                assert_eq!(found, expected, "{name}.{ending} at {time:?}");
            }
            let still_mesh = |model: &Model| model.meshes.last().cloned().expect("a mesh");
            if name != "morphing" {
                assert!(models.iter().all(|model| Arc::ptr_eq(&still_mesh(model), &still_mesh(&models[0]))));
            } else {
                assert!(models[2].meshes != models[3].meshes);
            }
            if name == "moving" {
                let image = |model: &Model| model.materials[0].surface.base_color_texture.clone().unwrap().image;
                assert!(models.iter().all(|model| Arc::ptr_eq(&image(model), &image(&models[0]))));
                assert!(models[0].warnings.len() >= 4, "{:?}", models[0].warnings);
            }
        }
    }
}
