//! Sources of bytes: .gltf, .glb, files, data URIs.

use std::fs;

use raggio_models::{GltfOptions, LoadOptions, load, load_gltf, parse_gltf};
use serde_json::json;

use crate::gltf::builder::{Builder, CORNERS, no_files, png, texels};

#[test]
fn gltf_and_glb_are_the_same() {
    let builder = Builder::triangle();
    let model = builder.load();
    assert_eq!(model.meshes[0].positions, CORNERS);
    assert_eq!(model.meshes[0].triangles, [[0, 1, 2]]);
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    assert_eq!(parse_gltf(&builder.glb(), "a.glb", &no_files, &GltfOptions::default()).unwrap(), model);
}

#[test]
fn bytes_after_a_glb_and_other_chunks_are_ignored() {
    let builder = Builder::triangle();
    let mut bytes = builder.glb();
    bytes.extend([1, 2, 3]);
    assert_eq!(parse_gltf(&bytes, "a.glb", &no_files, &GltfOptions::default()).unwrap(), builder.load());
    bytes.truncate(bytes.len() - 3);
    bytes.extend([4, 0, 0, 0, b'O', b'D', b'D', b'!', 9, 9, 9, 9]);
    let length = bytes.len() as u32;
    bytes[8..12].copy_from_slice(&length.to_le_bytes());
    assert_eq!(parse_gltf(&bytes, "a.glb", &no_files, &GltfOptions::default()).unwrap(), builder.load());
}

#[test]
fn a_byte_order_mark_is_ignored() {
    let builder = Builder::triangle();
    let bytes = [&b"\xef\xbb\xbf"[..], &builder.gltf()].concat();
    assert_eq!(parse_gltf(&bytes, "a.gltf", &no_files, &GltfOptions::default()).unwrap(), builder.load());
}

#[test]
fn names_of_files_are_decoded() {
    let mut builder = Builder::triangle();
    let length = builder.binary.len();
    builder.json["buffers"] = json!([{ "byteLength": length, "uri": "a%20b/%C3%A4.bin" }]);
    let binary = builder.binary.clone();
    let files = |name: &str, _: u64| match name {
        "a b/ä.bin" => Ok(binary.clone()),
        _ => Err("does not exist".to_string()),
    };
    let model = parse_gltf(&builder.gltf(), "a.gltf", &files, &GltfOptions::default()).unwrap();
    assert_eq!(model.meshes[0].positions, CORNERS);
}

#[test]
fn data_uris_need_not_be_base64() {
    let mut builder = Builder::triangle();
    let length = builder.binary.len();
    let escaped: String = builder.binary.iter().map(|byte| format!("%{byte:02x}")).collect();
    builder.json["buffers"] = json!([{ "byteLength": length, "uri": format!("data:,{escaped}") }]);
    assert_eq!(builder.mesh().positions, CORNERS);
}

#[test]
fn files_outside_the_folder_are_refused_unless_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let mut builder = Builder::triangle();
    let length = builder.binary.len();
    builder.json["buffers"] = json!([{ "byteLength": length, "uri": "../a.bin" }]);
    fs::create_dir(folder.path().join("inside")).unwrap();
    fs::write(folder.path().join("a.bin"), &builder.binary).unwrap();
    let path = folder.path().join("inside/a.gltf");
    fs::write(&path, builder.gltf()).unwrap();
    let error = load_gltf(&path, &GltfOptions::default()).unwrap_err();
    assert!(error.message.contains("buffers[0]: `../a.bin` is outside the folder"), "{error}");
    let options = GltfOptions { allow_outside: true, ..GltfOptions::default() };
    assert_eq!(load_gltf(&path, &options).unwrap().meshes[0].positions, CORNERS);
    fs::write(folder.path().join("inside/b.bin"), &builder.binary).unwrap();
    fs::write(&path, String::from_utf8(builder.gltf()).unwrap().replace("../a.bin", "b.bin")).unwrap();
    assert_eq!(load_gltf(&path, &GltfOptions::default()).unwrap().meshes[0].positions, CORNERS);
}

#[test]
fn models_of_any_format_are_loaded_by_their_extension() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.GLB");
    fs::write(&path, Builder::triangle().glb()).unwrap();
    assert_eq!(load(&path, &LoadOptions::default()).unwrap(), Builder::triangle().load());
}

#[test]
fn limits_on_bytes_hold() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    fs::write(&path, Builder::triangle().glb()).unwrap();
    let options = GltfOptions { most_bytes: 100, ..GltfOptions::default() };
    assert!(load_gltf(&path, &options).unwrap_err().message.contains("larger than 100 bytes"));
}

fn textured(builder: &mut Builder, image: serde_json::Value) -> Option<Vec<[u8; 4]>> {
    builder.push("images", image);
    builder.push("textures", json!({ "source": 0 }));
    builder.json["materials"][0] = json!({ "emissiveTexture": { "index": 0 } });
    texels(&builder.load().materials[0].surface.emissive_texture)
}

#[test]
fn images_from_views_and_data_uris() {
    let two = vec![[1, 2, 3, 4], [5, 6, 7, 8]];
    let file = png(&two);
    let mut builder = Builder::with_material(json!({}));
    let view = builder.view(&file);
    let image = json!({ "bufferView": view, "mimeType": "image/png" });
    assert_eq!(textured(&mut builder, image), Some(two.clone()));
    let uri = format!("data:image/png;base64,{}", data_encoding::BASE64.encode(&file));
    let mut builder = Builder::with_material(json!({}));
    assert_eq!(textured(&mut builder, json!({ "uri": uri })), Some(two));
}

#[test]
fn images_that_cannot_be_read_are_warnings() {
    let mut builder = Builder::with_material(json!({}));
    assert_eq!(textured(&mut builder, json!({ "uri": "gone.png", "name": "gone" })), None);
    assert!(builder.warning().contains("image 0, `gone`, is left out: `gone.png` is gone.png, and"));
    let mut builder = Builder::with_material(json!({}));
    assert_eq!(textured(&mut builder, json!({ "uri": "data:,no" })), None);
    assert!(builder.warning().contains("image 0 is left out: it is not an image that can be read"));
}

#[test]
fn newer_formats_of_images_come_first_and_the_old_one_steps_in() {
    let mut builder = Builder::with_material(json!({ "emissiveTexture": { "index": 0 } }));
    let files = [png(&[[1; 4]]), png(&[[2; 4]]), b"damaged".to_vec()];
    for file in files {
        let view = builder.view(&file);
        builder.push("images", json!({ "bufferView": view }));
    }
    builder.push("textures", json!({ "source": 0, "extensions": { "EXT_texture_webp": { "source": 1 } } }));
    let first = |builder: &Builder| texels(&builder.load().materials[0].surface.emissive_texture);
    assert_eq!(first(&builder), Some(vec![[2; 4]]));
    builder.json["textures"][0] = json!({ "source": 0, "extensions": { "KHR_texture_basisu": { "source": 2 } } });
    assert_eq!(first(&builder), Some(vec![[1; 4]]));
    assert!(builder.warning().contains("image 2 is left out"));
}

#[test]
fn images_of_the_same_bytes_are_decoded_once() {
    let mut builder =
        Builder::with_material(json!({ "emissiveTexture": { "index": 0 }, "normalTexture": { "index": 1 } }));
    let view = builder.view(&png(&[[9; 4]]));
    for i in 0..2 {
        builder.push("images", json!({ "bufferView": view }));
        builder.push("textures", json!({ "source": i }));
    }
    let surface = builder.load().materials[0].surface.clone();
    let (a, b) = (surface.emissive_texture.unwrap(), surface.normal_texture.unwrap());
    assert!(std::sync::Arc::ptr_eq(&a.image, &b.image));
}
