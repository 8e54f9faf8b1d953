//! Invalid files give an error that names the place and says what would be right, at once, and without much memory.

use std::time::{Duration, Instant};

use raggio_models::{GltfOptions, Place, parse_gltf};
use serde_json::{Value, json};

use crate::gltf::builder::{Builder, F32, no_files};

/// The triangle with the value at a JSON pointer replaced.
fn changed(pointer: &str, value: Value) -> Builder {
    let mut builder = Builder::triangle();
    set(&mut builder.json, pointer, value);
    builder
}

fn set(json: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = json.pointer_mut(parent).unwrap();
    match key.parse::<usize>() {
        Ok(index) if parent.is_array() => parent[index] = value,
        _ => parent[key] = value,
    }
}

/// Changes, each with a part of its message.
fn cases() -> Vec<(&'static str, Value, &'static str)> {
    let huge = json!(u64::MAX);
    let node = |node: Value| json!([node]);
    vec![
        ("/asset", json!(null), "asset: is missing"),
        ("/asset/version", json!("1.0"), "a.gltf: is glTF 1.0: 2.0 is read"),
        ("/asset/minVersion", json!("2.1"), "a.gltf: is glTF 2.1: 2.0 is read"),
        ("/asset/version", json!("two"), "asset.version: is `two`: it should be `2.0`"),
        ("/asset/version", json!(2), "asset.version: invalid type"),
        ("/extensionsRequired", json!(["EXT_x\u{7}"]), r"needs the extension `EXT_x\u{7}`, which is not supported"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(1), "attributes.POSITION: is 1: it should be below 1"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(-1), "invalid value"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(0.5),
            "meshes[0].primitives[0].attributes.POSITION: invalid",
        ),
        ("/meshes/0/primitives/0/indices", json!(9), "meshes[0].primitives[0].indices: is 9: it should be below 1"),
        ("/meshes/0/primitives/0/material", json!(0), "meshes[0].primitives[0].material: is 0"),
        ("/meshes/0/primitives/0/targets", json!([{ "POSITION": 5 }]), "targets[0].POSITION: is 5"),
        ("/meshes/0/primitives", json!(null), "meshes[0]: missing field `primitives`"),
        ("/nodes/0/mesh", json!(1), "nodes[0].mesh: is 1: it should be below 1"),
        ("/nodes/0/skin", json!(0), "nodes[0].skin: is 0"),
        ("/nodes/0/camera", json!(0), "nodes[0].camera: is 0"),
        ("/nodes/0/children", json!([1]), "nodes[0].children: is 1"),
        ("/nodes/0/children", json!([0]), "nodes[0]: is its own ancestor"),
        ("/nodes/0/children", json!([null]), "nodes[0].children[0]: invalid type: null"),
        ("/nodes/0/rotation", json!([0, 0, 1]), "nodes[0].rotation: invalid length 3"),
        ("/nodes/0/translation", json!([1e308, 1e308, 1e308]), ""),
        ("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "the last row of `matrix`"),
        ("/nodes/0/extensions", json!({ "KHR_lights_punctual": { "light": 0 } }), "KHR_lights_punctual.light: is 0"),
        (
            "/nodes/0/extensions",
            json!({ "EXT_mesh_gpu_instancing": { "attributes": { "SCALE": 7 } } }),
            "EXT_mesh_gpu_instancing.attributes.SCALE: is 7",
        ),
        ("/nodes", node(json!({ "children": [0, 0] })), "nodes[0]: is its own ancestor"),
        ("/nodes", json!([{}, { "children": [2] }, { "children": [1] }]), "nodes[1]: is its own ancestor"),
        ("/scene", json!(0), "document.scene: is 0"),
        ("/scenes", json!([{ "nodes": [1] }]), "scenes[0].nodes: is 1"),
        ("/accessors/0/bufferView", json!(1), "accessors[0].bufferView: is 1"),
        ("/accessors/0/count", json!(4), "accessors[0]: 4 elements of 12 bytes"),
        ("/accessors/0/count", huge.clone(), "within the 36 bytes that there are"),
        ("/accessors/0/count", json!(1u64 << 62), "within the 36 bytes that there are"),
        ("/accessors/0/byteOffset", json!(4), "12 bytes apart from byte 4 on"),
        ("/accessors/0/byteOffset", huge.clone(), "within the 36 bytes"),
        ("/accessors/0/componentType", json!(5124), "accessors[0].componentType: the component type is 5124"),
        ("/accessors/0/componentType", json!(5121), ""),
        ("/accessors/0/type", json!("VEC5"), "accessors[0].type: unknown variant `VEC5`"),
        ("/accessors/0/type", json!("SCALAR"), "attributes.POSITION: accessor 0 is Scalar: it should be Vec3"),
        ("/bufferViews/0/buffer", json!(1), "bufferViews[0].buffer: is 1"),
        ("/bufferViews/0/byteLength", json!(37), "bufferViews[0]: 1 elements of 37 bytes"),
        ("/bufferViews/0/byteLength", huge.clone(), "within the 36 bytes"),
        ("/bufferViews/0/byteOffset", huge.clone(), "within the 36 bytes"),
        ("/bufferViews/0/byteStride", json!(8), "an element has 12 bytes: the view's `byteStride` is only 8"),
        ("/bufferViews/0/byteStride", json!(13), "3 elements of 12 bytes, 13 bytes apart from byte 0 on"),
        ("/bufferViews/0/byteStride", huge.clone(), "within the 36 bytes"),
        ("/buffers", json!([{ "byteLength": 36 }]), "buffer 0 should have data: it has no `uri`"),
        ("/buffers", json!([{ "byteLength": 36, "uri": "data:,a" }]), "buffers[0]: should have 36 bytes"),
        ("/buffers", json!([{ "byteLength": 36, "uri": "data:;base64,%%" }]), "the data URI should be base64"),
        ("/buffers", json!([{ "byteLength": 36, "uri": "data:a" }]), "the data URI should have a comma"),
        ("/buffers", json!([{ "byteLength": 36, "uri": "http://a/b" }]), "is not a file: give a relative path"),
        (
            "/buffers",
            json!([{ "byteLength": 36, "uri": "file:///etc/passwd" }]),
            "`/etc/passwd` is /etc/passwd, and there",
        ),
        ("/buffers", json!([{ "byteLength": 36, "uri": "%ff" }]), "should be UTF-8 when decoded"),
        ("/images", json!([{ "bufferView": 3 }]), "images[0].bufferView: is 3"),
        ("/textures", json!([{ "source": 0 }]), "textures[0].source: is 0"),
        ("/textures", json!([{ "sampler": 0 }]), "textures[0].sampler: is 0"),
        (
            "/materials",
            json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 7 } } }]),
            "materials[0].pbrMetallicRoughness.baseColorTexture.index: is 7: it should be below 0",
        ),
        ("/materials", json!([{ "occlusionTexture": { "index": 7 } }]), "materials[0].occlusionTexture.index: is 7"),
        ("/materials", json!([{ "alphaMode": "SOLID" }]), "materials[0].alphaMode: unknown variant `SOLID`"),
        ("/samplers", json!([{ "wrapS": -1 }]), "samplers[0].wrapS: invalid value"),
        ("/skins", json!([{ "joints": [4] }]), "skins[0].joints: is 4"),
        (
            "/animations",
            json!([{ "channels": [{ "sampler": 0, "target": { "path": "scale" } }], "samplers": [] }]),
            "animations[0].channels[0].sampler: is 0",
        ),
        (
            "/animations",
            json!([{ "channels": [], "samplers": [{ "input": 0, "output": 8 }] }]),
            "animations[0].samplers[0].output: is 8",
        ),
    ]
}

#[test]
fn each_is_told() {
    for (pointer, value, message) in cases() {
        let builder = changed(pointer, value.clone());
        let start = Instant::now();
        let result = builder.try_load(&GltfOptions::default());
        assert!(start.elapsed() < Duration::from_secs(1), "{pointer} {value}");
        if message.is_empty() {
            assert!(result.is_ok(), "{pointer} {value}: {result:?}");
            continue;
        }
        let error = result.expect_err(&format!("{pointer} {value}")).to_string();
        assert!(error.starts_with("a.gltf"), "{error}");
        assert!(error.contains(message), "{error} should contain {message}");
    }
}

/// Files of glTF 1.0 have maps where those of 2.0 have lists, so that they cannot be read as far as to their version.
#[test]
fn old_versions_are_told_before_all_else() {
    let error =
        |text: &str| parse_gltf(text.as_bytes(), "a.gltf", &no_files, &GltfOptions::default()).unwrap_err().to_string();
    let old = r#"{"asset":{"version":"1.0"},"accessors":{},"scenes":{}}"#;
    assert_eq!(error(old), "a.gltf: is glTF 1.0: 2.0 is read");
    assert_eq!(error(&old.replace("\"1.0\"", "1.1")), "a.gltf: is glTF 1.1: 2.0 is read");
    assert_eq!(error(&old.replace("1.0", "0.8")), "a.gltf: is glTF 0.8: 2.0 is read");
    assert!(error(&old.replace("1.0", "2.0")).contains("a.gltf:1: accessors: invalid type: map"));
}

#[test]
fn utf_16_is_told() {
    let text = String::from_utf8(Builder::triangle().gltf()).unwrap();
    let units = |mark: Option<u16>| mark.into_iter().chain(text.encode_utf16()).collect::<Vec<_>>();
    for mark in [None, Some(0xfeff)] {
        for bytes in [
            units(mark).iter().flat_map(|unit| unit.to_le_bytes()).collect::<Vec<_>>(),
            units(mark).iter().flat_map(|unit| unit.to_be_bytes()).collect(),
        ] {
            let error = parse_gltf(&bytes, "a.gltf", &no_files, &GltfOptions::default()).unwrap_err().to_string();
            assert_eq!(error, "a.gltf: is written in UTF-16: glTF is UTF-8, save it as that");
        }
    }
}

#[test]
fn syntax_errors_name_the_line() {
    let error = parse_gltf(b"{\n\"asset\": {\n]", "a.gltf", &no_files, &GltfOptions::default()).unwrap_err();
    assert_eq!(error.place, Place::Line(3));
    let deep = "[".repeat(100_000);
    parse_gltf(deep.as_bytes(), "a.gltf", &no_files, &GltfOptions::default()).unwrap_err();
    let deep = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{}", "{\"a\":".repeat(100_000));
    parse_gltf(deep.as_bytes(), "a.gltf", &no_files, &GltfOptions::default()).unwrap_err();
}

#[test]
fn errors_name_their_place() {
    let error = |members: &str| {
        let text =
            format!("{{\n\"asset\": {{ \"version\": \"2.0\", \"generator\": \"a \\\" ]}} b\" }},\n{members}\n}}");
        let error = parse_gltf(text.as_bytes(), "a.gltf", &no_files, &GltfOptions::default()).unwrap_err();
        assert!(matches!(error.place, Place::Line(_)), "{error}");
        error.to_string()
    };
    for (members, place) in [
        // A number where a name should be, and the other way round; first, last and alone in their object.
        (r#""nodes": [{}, { "name": 5, "mesh": 0 }]"#, "a.gltf:3: nodes[1].name: "),
        (r#""nodes": [{}, { "mesh": 0, "name": 5 }]"#, "a.gltf:3: nodes[1].name: "),
        (r#""nodes": [{}, { "mesh": "x" }]"#, "a.gltf:3: nodes[1].mesh: "),
        // Whatever is another kind of value.
        (r#""nodes": [{ "name": { "a": 1 } }]"#, "a.gltf:3: nodes[0].name: "),
        (r#""nodes": [{ "mesh": [1] }]"#, "a.gltf:3: nodes[0].mesh: "),
        ("\"nodes\":\n\n5", "a.gltf:5: nodes: "),
        // Members that are missing, before and after others of the same list.
        (r#""bufferViews": [{ "buffer": 0 }, {}]"#, "a.gltf:3: bufferViews[0]: "),
        (r#""bufferViews": [{ "buffer": 0, "byteLength": 4 }, { "byteLength": 4 }]"#, "a.gltf:3: bufferViews[1]: "),
        // Lists that are too short.
        (r#""nodes": [{ "translation": [1, 2] }]"#, "a.gltf:3: nodes[0].translation: "),
        // Numbers that stand for something.
        (
            r#""meshes": [{ "primitives": [{ "mode": 9, "attributes": {} }] }]"#,
            "a.gltf:3: meshes[0].primitives[0].mode: ",
        ),
        (
            "\"accessors\": [\n{ \"count\": 1, \"type\": \"VEC3\", \"componentType\": 1 }\n]",
            "a.gltf:4: accessors[0].componentType: ",
        ),
    ] {
        let found = error(members);
        assert!(found.contains(place), "{members}: {found}");
    }
}

#[test]
fn headers_and_chunks_of_glb() {
    let whole = Builder::triangle().glb();
    let error = |bytes: &[u8]| parse_gltf(bytes, "a.glb", &no_files, &GltfOptions::default()).unwrap_err().to_string();
    let with = |at: usize, word: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        error(&bytes)
    };
    assert!(error(b"glTF").contains("the file ends inside the 12 bytes of its header"));
    assert!(with(4, 1).contains("byte 4: is GLB of version 1: version 2, of glTF 2.0, is read"));
    assert!(with(8, u32::MAX).contains("byte 8: the file should have 4294967295 bytes"));
    assert!(with(8, 11).contains("the file should have 11 bytes"));
    assert!(with(8, 12).contains("byte 12: there is no JSON chunk"));
    assert!(with(8, 17).contains("byte 12: a chunk should have 8 bytes"));
    assert!(with(12, u32::MAX).contains("byte 12: the chunk says that it has 4294967295 bytes"));
    assert!(with(16, 0).contains("byte 12: the first chunk should be of type JSON"));
}

#[test]
fn memory_without_bytes_is_refused() {
    let huge = json!({ "componentType": F32, "count": 200_000_000, "type": "VEC3" });
    let error = changed("/accessors/0", huge).error();
    assert!(error.contains("meshes[0].primitives[0]: asks for 800000000 bytes of memory: at most"), "{error}");
}

/// Many meshes over one buffer ask for much more than the file has.
#[test]
fn memory_by_repetition_is_refused() {
    let mut builder = Builder::empty();
    let positions = builder.floats("VEC3", &vec![1.0; 3 << 20]);
    for mesh in 0..10_000 {
        builder.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
        builder.push("nodes", json!({ "mesh": mesh }));
    }
    let options = GltfOptions { most_bytes: 256 << 20, ..GltfOptions::default() };
    let error = parse_gltf(&builder.glb(), "a.glb", &no_files, &options).unwrap_err();
    assert!(error.message.contains("bytes of memory: at most"), "{error}");
}

#[test]
fn memory_for_materials_is_refused() {
    let mut builder = Builder::triangle();
    builder.json["materials"] = Value::Array(vec![json!({}); 100_000]);
    let options = GltfOptions { most_bytes: 64 << 20, ..GltfOptions::default() };
    let error = builder.try_load(&options).unwrap_err();
    assert!(error.message.starts_with("materials: asks for"), "{error}");
}

/// Comparing each primitive with each would take minutes.
#[test]
fn very_many_primitives_take_little_time() {
    let mut builder = Builder::empty();
    let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let count = 30_000;
    let primitive = |builder: &mut Builder| {
        let accessor = json!({ "bufferView": 0, "componentType": F32, "count": 3, "type": "VEC3" });
        json!({ "attributes": { "POSITION": builder.push("accessors", accessor) } })
    };
    builder.floats("VEC3", &corners);
    let primitives: Vec<_> = (0..count).map(|_| primitive(&mut builder)).collect();
    builder.push("meshes", json!({ "primitives": primitives }));
    builder.push("nodes", json!({ "mesh": 0 }));
    let bytes = builder.gltf();
    let start = Instant::now();
    let model = parse_gltf(&bytes, "a.gltf", &no_files, &GltfOptions::default()).unwrap();
    let most_seconds = if cfg!(debug_assertions) { 10.0 } else { 1.0 };
    assert!(start.elapsed().as_secs_f64() < most_seconds, "{:?}", start.elapsed());
    assert_eq!(model.meshes[0].parts.len(), count);
}

#[test]
fn a_flood_of_warnings_is_counted() {
    let mut builder = Builder::triangle();
    let material = json!({ "pbrMetallicRoughness": { "metallicFactor": 2 } });
    builder.json["materials"] = Value::Array(vec![material; 5000]);
    let warnings = builder.load().warnings;
    assert_eq!((warnings.len(), warnings[100].as_str()), (101, "4900 more warnings are not shown"));
}
