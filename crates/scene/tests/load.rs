//! Files that cannot be read, or hold no text.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{EXAMPLE, reference_scene};
use raggio_scene::{Scene, SceneError};

/// A folder of its own for each test, inside the build's.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("scene-{test}"));
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn error(path: &Path) -> SceneError {
    let error = Scene::load(path).unwrap_err();
    assert_eq!(error.file, path.display().to_string());
    error
}

#[test]
fn the_name_in_messages_is_the_path() {
    let path = folder("named").join("scene.toml");
    fs::write(&path, EXAMPLE.replace("look_at", "lookat")).unwrap();
    let expected = format!("{}:12:1: unknown key `lookat` in [camera]: did you mean `look_at`?", path.display());
    assert_eq!(error(&path).to_string(), expected);
}

#[test]
fn a_file_that_is_not_there() {
    let path = folder("absent").join("absent.toml");
    let expected = format!("{}: there is no such file", path.display());
    assert_eq!(error(&path).to_string(), expected);
    assert_eq!((error(&path).line, error(&path).column), (0, 0));
}

#[test]
fn files_of_other_programs() {
    let folder = folder("foreign");
    let expected = "is neither a scene nor a model that can be read: give a .toml scene or a .gltf, .glb, .ply, .obj or \
                    .stl model";
    for (name, bytes) in [
        ("a.fbx", &b"Kaydara FBX Binary  \0\x1a\0\xe8\x1c"[..]),
        ("a.blend", b"BLENDER-v300"),
        ("a.pbrt", b"LookAt 0 0 0\n"),
        ("a.xml", b"<scene version=\"3.0.0\">\n</scene>\n"),
        ("a.usda", b"#usda 1.0\n"),
        ("a.usdz", b"PK\x03\x04"),
        ("a.PNG", b"\x89PNG\r\n\x1a\n"),
        ("a.json", b""),
    ] {
        let path = folder.join(name);
        fs::write(&path, bytes).unwrap();
        assert_eq!(error(&path).to_string(), format!("{}: {expected}", path.display()));
    }
    let large = folder.join("large.blend");
    fs::File::create(&large).unwrap().set_len((64 << 20) + 1).unwrap();
    assert_eq!(error(&large).message, expected);
    fs::remove_file(&large).unwrap();
    assert_eq!(error(&folder.join("absent.fbx")).message, "there is no such file");
}

#[test]
fn a_scene_by_another_name() {
    let path = folder("renamed").join("scene.txt");
    fs::write(&path, EXAMPLE).unwrap();
    assert_eq!(Scene::load(&path).unwrap(), Scene::parse(EXAMPLE, "scene.toml").unwrap());
    fs::write(&path, EXAMPLE.replace("look_at", "lookat")).unwrap();
    assert_eq!(error(&path).message, "unknown key `lookat` in [camera]: did you mean `look_at`?");
}

#[test]
fn a_folder() {
    let path = folder("folder");
    assert_eq!(error(&path).message, "is a folder: give a `.toml` scene file or a model");
}

#[test]
fn a_file_below_a_file() {
    let path = reference_scene("lamp").join("scene.toml");
    assert!(error(&path).message.starts_with("cannot be read: "));
}

#[test]
fn a_file_beyond_all_size() {
    let path = folder("large").join("large.toml");
    fs::File::create(&path).unwrap().set_len((64 << 20) + 1).unwrap();
    let expected = "is larger than 64 MiB, the most a scene file may have";
    assert_eq!(error(&path).message, expected);
    fs::remove_file(&path).unwrap();
}

#[test]
fn bytes_that_are_not_utf8() {
    let path = folder("latin1").join("latin1.toml");
    fs::write(&path, b"version = 1\n# gr\xfc\xdfe\n").unwrap();
    let error = error(&path);
    assert_eq!((error.line, error.column), (2, 5));
    assert_eq!(error.message, "the byte 0xfc is not valid UTF-8: save the file as UTF-8");
}
