//! Hostile bytes never lead to a panic, and whatever is read fits together.

use std::time::{Duration, Instant};

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use raggio_models::{GltfOptions, LightKind, Model, Projection, parse_gltf};
use serde_json::{Value, json};

use crate::gltf::builder::{Builder, U8, no_files, png};
use crate::gltf::compression::{draco_grid, meshopt_grid};

/// Most bytes of a file, few so that damage is found without much memory.
const MOST_BYTES: u64 = 64 << 20;

/// A file with nearly everything in it.
fn rich() -> Builder {
    let mut builder = Builder::with_material(json!({
        "normalTexture": { "index": 0, "extensions": { "KHR_texture_transform": { "rotation": 1 } } },
        "alphaMode": "MASK",
        "extensions": {
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 2 },
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_pbrSpecularGlossiness": { "specularGlossinessTexture": { "index": 0 } },
        },
    }));
    let view = builder.view(&png(&[[1, 2, 3, 4]]));
    builder.push("images", json!({ "bufferView": view }));
    builder.push("textures", json!({ "source": 0, "sampler": 0 }));
    builder.push("samplers", json!({ "wrapS": 33071 }));
    let normals = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let joints = builder.accessor("VEC4", U8, 3, &[0, 1, 0, 0].repeat(3));
    let weights = builder.floats("VEC4", &[0.5, 0.5, 0.0, 0.0].repeat(3));
    let indices = builder.indices(&[0, 1, 2]);
    builder.attribute("NORMAL", normals).attribute("JOINTS_0", joints).attribute("WEIGHTS_0", weights);
    let sparse_indices = builder.view(&[0, 2]);
    let sparse = json!({
        "count": 2, "indices": { "bufferView": sparse_indices, "componentType": U8 }, "values": { "bufferView": 0 },
    });
    let deltas =
        builder.push("accessors", json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse }));
    let times = builder.floats("SCALAR", &[0.0, 1.0]);
    let turns = builder.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let morphs = builder.floats("SCALAR", &[0.0, 1.0]);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    builder.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": deltas, "NORMAL": deltas }]);
    builder.json["meshes"][0]["weights"] = json!([0.5]);
    builder.json["skins"] = json!([{ "joints": [1, 2] }]);
    builder.json["cameras"] =
        json!([{ "perspective": { "yfov": 1, "aspectRatio": 2 } }, { "orthographic": { "xmag": 1, "ymag": 2 } }]);
    builder.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {} }] } });
    builder.json["animations"] = json!([{
        "channels": [
            { "sampler": 0, "target": { "node": 1, "path": "rotation" } },
            { "sampler": 1, "target": { "node": 0, "path": "weights" } },
        ],
        "samplers": [{ "input": times, "output": turns }, { "input": times, "output": morphs, "interpolation": "STEP" }],
    }]);
    builder.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "children": [1] },
        { "children": [2], "camera": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "camera": 1, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, 2, 3] },
        { "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } } } },
    ]);
    builder
}

fn builders() -> Vec<Builder> {
    vec![rich(), draco_grid(0), draco_grid(1), with_binary(meshopt_grid("EXT_meshopt_compression"))]
}

fn seeds() -> Vec<Vec<u8>> {
    builders().iter().map(Builder::glb).chain([rich().gltf()]).collect()
}

/// The file with its first buffer as GLB's own.
fn with_binary(mut builder: Builder) -> Builder {
    builder.json["buffers"][0].as_object_mut().unwrap().remove("uri");
    builder
}

fn check(model: &Model) {
    for mesh in &model.meshes {
        let vertices = mesh.positions.len();
        assert!(mesh.triangles.as_flattened().iter().all(|index| (*index as usize) < vertices));
        assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
        assert!(mesh.normals.as_ref().is_none_or(|list| list.len() == vertices));
        assert!(mesh.tangents.as_ref().is_none_or(|list| list.len() == vertices));
        assert!(mesh.colors.as_ref().is_none_or(|list| list.len() == vertices));
        assert!(mesh.uvs.iter().flatten().all(|list| list.len() == vertices));
        assert_eq!(mesh.parts.iter().map(|part| part.triangles.len()).sum::<usize>(), mesh.triangles.len());
        let materials = model.materials.len();
        assert!(mesh.parts.iter().filter_map(|part| part.material).all(|material| material < materials));
    }
    assert!(model.instances.iter().all(|instance| instance.mesh < model.meshes.len()));
    assert!(model.instances.iter().all(|instance| instance.model_from_mesh.inverse().is_finite()));
    assert!(model.cameras.iter().all(|camera| camera.forward.is_normalized() && camera.up.is_normalized()));
    let is_sound = |camera: &raggio_models::Camera| match camera.projection {
        Projection::Perspective { vertical_fov, aspect } => {
            vertical_fov > 0.0 && aspect.is_none_or(|aspect| aspect > 0.0)
        }
        Projection::Orthographic { xmag, ymag } => xmag > 0.0 && ymag > 0.0,
    };
    assert!(model.cameras.iter().all(is_sound));
    assert!(model.lights.iter().all(|light| light.direction.is_normalized()));
    let is_ordered = |kind| !matches!(kind, LightKind::Spot { inner, outer } if !(0.0 <= inner && inner <= outer));
    assert!(model.lights.iter().all(|light| is_ordered(light.kind)));
    assert!(model.warnings.iter().all(|warning| !warning.chars().any(char::is_control)));
}

fn read_all(bytes: &[u8]) {
    for time_seconds in [None, Some(0.25)] {
        let options = GltfOptions { time_seconds, most_bytes: MOST_BYTES, ..GltfOptions::default() };
        let start = Instant::now();
        match parse_gltf(bytes, "a", &no_files, &options) {
            Ok(model) => check(&model),
            Err(error) => assert!(!error.to_string().chars().any(char::is_control), "{error:?}"),
        }
        // An unoptimized decoder may take longer.
        let most_seconds = if cfg!(debug_assertions) { 10 } else { 1 };
        assert!(start.elapsed() < Duration::from_secs(most_seconds), "{:?}", start.elapsed());
    }
}

#[test]
fn seeds_are_valid() {
    for seed in seeds() {
        let options = GltfOptions { time_seconds: Some(0.25), most_bytes: MOST_BYTES, ..GltfOptions::default() };
        let model = parse_gltf(&seed, "a", &no_files, &options).unwrap();
        assert!(
            !model.instances.is_empty() && model.warnings.iter().all(|w| w.contains("thickness")),
            "{:?}",
            model.warnings
        );
    }
}

#[test]
fn truncated_at_every_length() {
    for seed in seeds() {
        (0..seed.len()).for_each(|length| read_all(&seed[..length]));
    }
}

/// A place, a value for it, and a kind of change.
type Change = (prop::sample::Index, u8, u8);

/// Changes, inserts and takes away bytes.
fn damage(bytes: &mut Vec<u8>, changes: &[Change]) {
    for (index, byte, kind) in changes {
        if bytes.is_empty() {
            return;
        }
        let at = index.index(bytes.len());
        match kind % 4 {
            0 => bytes[at] = *byte,
            1 => bytes[at] ^= 1 << (byte % 8),
            2 => bytes.insert(at, b"0123456789,[]{}\":e-."[usize::from(*byte) % 20]),
            _ => drop(bytes.remove(at)),
        }
    }
}

/// Changes numbers in the document, which stays JSON, and bytes of the buffer: damage of this kind goes deeper.
fn distort(builder: &mut Builder, changes: &[Change]) {
    for (index, byte, kind) in changes {
        if kind % 2 == 0 {
            let at = index.index(builder.binary.len());
            builder.binary[at] = *byte;
            continue;
        }
        let mut numbers = Vec::new();
        collect_numbers(&mut builder.json, &mut numbers);
        let at = index.index(numbers.len());
        let old = numbers[at].as_i64().unwrap_or_default();
        *numbers[at] = match byte % 16 {
            0..8 => json!(byte % 8),
            8 => json!(old + 1),
            9 => json!(old - 1),
            10 => json!(-old),
            11 => json!(old.saturating_mul(1000)),
            12 => json!(u32::MAX),
            13 if byte / 16 % 2 == 0 => json!(null),
            13 => json!(u64::MAX),
            14 => json!(5120 + i64::from(byte / 16) % 7),
            _ => json!(1e308),
        };
    }
}

fn collect_numbers<'a>(value: &'a mut Value, numbers: &mut Vec<&'a mut Value>) {
    match value {
        Value::Number(_) => numbers.push(value),
        Value::Array(list) => list.iter_mut().for_each(|item| collect_numbers(item, numbers)),
        Value::Object(map) => map.values_mut().for_each(|item| collect_numbers(item, numbers)),
        _ => {}
    }
}

/// Mutates for as many seconds as RAGGIO_FUZZ_SECONDS says, or two.
#[test]
fn mutated() {
    let seconds = std::env::var("RAGGIO_FUZZ_SECONDS").ok().and_then(|seconds| seconds.parse().ok()).unwrap_or(2.0);
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let (builders, seeds) = (builders(), seeds());
    let strategy = (any::<prop::sample::Index>(), vec((any::<prop::sample::Index>(), any::<u8>(), any::<u8>()), 1..6));
    let mut cases = 0;
    while Instant::now() < end {
        let mut runner = TestRunner::new(Config { cases: 100, failure_persistence: None, ..Config::default() });
        let outcome = runner.run(&strategy, |(seed, changes)| {
            let mut bytes = seeds[seed.index(seeds.len())].clone();
            damage(&mut bytes, &changes);
            read_all(&bytes);
            let mut builder = builders[seed.index(builders.len())].clone();
            distort(&mut builder, &changes);
            read_all(&builder.glb());
            Ok(())
        });
        outcome.unwrap();
        cases += 200;
    }
    println!("{cases} files read");
}

/// Parts of URIs that lead to other folders, or that are written in more than one way.
const PARTS: [&str; 16] = [
    "..",
    "../",
    "..\\",
    "/",
    "%2e%2e",
    "%2F",
    "%5c",
    "secret.bin",
    "inside",
    "./",
    "file:",
    "//",
    "?",
    "#",
    "sub/",
    "C:",
];

/// No URI reads a file beside the folder of the model, where there is one that would do.
#[test]
fn uris_never_lead_out_of_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside");
    std::fs::create_dir_all(inside.join("sub")).unwrap();
    let mut builder = Builder::triangle();
    std::fs::write(folder.path().join("secret.bin"), &builder.binary).unwrap();
    let absolute = folder.path().canonicalize().unwrap();
    let parts: Vec<String> = PARTS.into_iter().chain(absolute.to_str()).map(str::to_string).collect();
    let path = inside.join("a.gltf");
    let length = builder.binary.len();
    let mut read = |uri: &str, allow_outside| {
        builder.json["buffers"] = json!([{ "byteLength": length, "uri": uri }]);
        std::fs::write(&path, builder.gltf()).unwrap();
        raggio_models::load_gltf(&path, &GltfOptions { allow_outside, ..GltfOptions::default() })
    };
    assert!(read("../secret.bin", true).is_ok());
    let mut runner = TestRunner::new(Config { cases: 2000, failure_persistence: None, ..Config::default() });
    let strategy = vec(prop::sample::select(parts), 1..8);
    let read = std::cell::RefCell::new(read);
    let outcome = runner.run(&strategy, |parts| {
        let uri = parts.concat();
        let error = (*read.borrow_mut())(&uri, false).expect_err(&uri);
        assert!(!error.to_string().chars().any(char::is_control), "{error:?}");
        Ok(())
    });
    outcome.unwrap();
}

proptest! {
    #[test]
    fn arbitrary(bytes in vec(any::<u8>(), 0..300)) {
        read_all(&bytes);
        read_all(&[b"glTF\x02\0\0\0\x80\0\0\0", &bytes[..]].concat());
    }
}
