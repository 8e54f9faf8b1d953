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
fn zeros_after_the_document_are_told() {
    let builder = Builder::triangle();
    let mut bytes = builder.glb();
    let end = bytes.iter().rposition(|byte| *byte == b'}').unwrap() + 1;
    // One more word of the first chunk, with nothing but zeros.
    bytes.splice(end..end, [0; 4]);
    for at in [8, 12] {
        let length = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) + 4;
        bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
    }
    let model = parse_gltf(&bytes, "a.glb", &no_files, &GltfOptions::default());
    let end = bytes[20..].iter().position(|byte| *byte == 0).unwrap();
    assert!(end > 0);
    let model = model.unwrap();
    assert_eq!(model.meshes, builder.load().meshes);
    assert!(model.warnings[0].contains("zeros follow the JSON of the document"), "{:?}", model.warnings);
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

/// A file with a name that is not quite what the URI of its buffer says, in a folder of its own.
fn beside(uri: &str, file: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let mut builder = Builder::triangle();
    let inside = folder.path().join("inside");
    let uri = uri.replace("FOLDER", inside.canonicalize().as_deref().unwrap_or(&inside).to_str().unwrap());
    builder.json["buffers"] = json!([{ "byteLength": builder.binary.len(), "uri": uri }]);
    fs::create_dir_all(inside.join(file).parent().unwrap()).unwrap();
    fs::write(inside.join(file), &builder.binary).unwrap();
    fs::write(inside.join("a.gltf"), builder.gltf()).unwrap();
    (folder, inside.join("a.gltf"))
}

#[test]
fn uris_that_are_odd_but_plain() {
    let told = |uri: &str, file: &str, is_told: bool| {
        let (_folder, path) = beside(uri, file);
        let model = load_gltf(&path, &GltfOptions::default()).unwrap_or_else(|error| panic!("{uri}: {error}"));
        assert_eq!(model.meshes[0].positions, CORNERS, "{uri}");
        assert_eq!(model.warnings.len(), usize::from(is_told), "{uri}: {:?}", model.warnings);
        model.warnings.concat()
    };
    told("a%20b.bin", "a b.bin", false);
    told("./sub/../a.bin", "a.bin", false);
    told("sub/gone/../a.bin", "sub/a.bin", false);
    told("a#b.bin", "a#b.bin", false);
    let query = told("a.bin?version=2", "a.bin", true);
    assert_eq!(query, "the URI `a.bin?version=2` should be a relative reference with escapes: `a.bin` is read");
    told("a.bin#part", "a.bin", true);
    told("100%25.bin", "100%25.bin", true);
    told("sub\\a.bin", "sub/a.bin", true);
    told("sub%5Ca.bin", "sub/a.bin", true);
    told("file:a.bin", "a.bin", true);
}

#[test]
fn file_uris_of_the_folder() {
    for start in ["file://", "file:", "FILE://localhost"] {
        let folder = tempfile::tempdir().unwrap();
        let folder_name = folder.path().canonicalize().unwrap();
        let mut builder = Builder::triangle();
        let uri = format!("{start}{}/a%20b.bin", folder_name.display());
        builder.json["buffers"] = json!([{ "byteLength": builder.binary.len(), "uri": uri }]);
        fs::write(folder.path().join("a b.bin"), &builder.binary).unwrap();
        fs::write(folder.path().join("a.gltf"), builder.gltf()).unwrap();
        let model = load_gltf(&folder.path().join("a.gltf"), &GltfOptions::default()).unwrap();
        assert_eq!((model.meshes[0].positions.as_slice(), model.warnings.len()), (&CORNERS[..], 1), "{uri}");
    }
    let (_folder, path) = beside("file:///etc/hostname", "a.bin");
    let error = load_gltf(&path, &GltfOptions::default()).unwrap_err().to_string();
    assert!(error.contains("`/etc/hostname` is outside the folder of the model"), "{error}");
}

/// Archives carry links and pipes, behind which there may be any file of the machine, or one that never ends.
#[cfg(unix)]
#[test]
fn links_and_pipes_are_not_followed() {
    let refused = |link: &std::path::Path| {
        let (folder, path) = beside("a.bin", "a.bin");
        let inside = path.parent().unwrap();
        fs::rename(inside.join("a.bin"), folder.path().join("outside.bin")).unwrap();
        std::os::unix::fs::symlink(link, inside.join("a.bin")).unwrap();
        let error = load_gltf(&path, &GltfOptions::default()).unwrap_err().to_string();
        let options = GltfOptions { allow_outside: true, ..GltfOptions::default() };
        (error, load_gltf(&path, &options))
    };
    let (error, allowed) = refused(std::path::Path::new("../outside.bin"));
    assert!(error.contains("`a.bin` is a link that leads out of the folder of the model"), "{error}");
    assert!(error.ends_with("unless `--allow-outside` is given"), "{error}");
    assert_eq!(allowed.unwrap().meshes[0].positions, CORNERS);
    let (error, allowed) = refused(std::path::Path::new("/dev/zero"));
    assert!(error.contains("is a link that leads out of the folder"), "{error}");
    assert!(allowed.unwrap_err().to_string().contains("is a device or a pipe: only regular files are read"));

    let (_folder, path) = beside("a.bin", "b.bin");
    let pipe = path.with_file_name("a.bin");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let error = load_gltf(&path, &GltfOptions::default()).unwrap_err().to_string();
    assert!(error.contains("`a.bin` is a device or a pipe: only regular files are read"), "{error}");
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
    let expected = "buffers[0]: `../a.bin` is outside the folder of the model, where files are not read unless \
                    `--allow-outside` is given";
    assert_eq!(error.message, expected);
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
    let mut builder = Builder::with_material(json!({}));
    assert_eq!(textured(&mut builder, json!({ "name": "nothing" })), None);
    assert_eq!(builder.warning(), "image 0, `nothing`, is left out: it should have a `uri` or a `bufferView`");
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
