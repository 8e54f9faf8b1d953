//! Opening, saving, reloading.

use std::fs;
use std::path::{Path, PathBuf};

use raggio_scene::{Projection, Scene};
use raggio_viewer::document::Document;

use crate::document::{HEADERS, INLINE, ball, check};

fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"));
    let files =
        ["notes", "reference"].map(|sub| fs::read_dir(folder.join(sub)).unwrap().map(|file| file.unwrap().path()));
    files.into_iter().flatten().chain([folder.join("showcase.toml")]).collect()
}

#[test]
fn a_scene_saved_unchanged_is_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("it.toml");
    for scene in scenes() {
        let bytes = fs::read(&scene).unwrap();
        fs::write(&path, &bytes).unwrap();
        let mut it = Document::open(&path).unwrap();
        assert!(!it.is_modified());
        it.save().unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }
}

#[test]
fn an_edit_of_a_real_scene_changes_one_line() {
    for scene in scenes() {
        let mut it = Document::open(&scene).unwrap();
        let before = it.text().to_string();
        let mut camera = it.scene().camera.clone();
        let Projection::Perspective { vertical_fov_degrees } = &mut camera.projection else { panic!("{camera:?}") };
        *vertical_fov_degrees += 0.5;
        assert!(it.set_camera(&camera).unwrap());
        let changed = before.lines().zip(it.text().lines()).filter(|(old, new)| old != new).count();
        assert_eq!((changed, before.lines().count()), (1, it.text().lines().count()), "{}", scene.display());
        it.undo();
        assert_eq!(it.text(), before);
        assert!(!it.is_modified());
    }
}

#[test]
fn errors_are_those_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [
        ("wrong.toml", Some(b"version = 2".as_slice())),
        ("latin.toml", Some(b"version = 1 # \xe9")),
        ("mesh.glb", Some(b"")),
        ("missing.toml", None),
    ] {
        let path = folder.path().join(name);
        if let Some(bytes) = bytes {
            fs::write(&path, bytes).unwrap()
        }
        assert_eq!(Document::open(&path).unwrap_err(), Scene::load(&path).unwrap_err());
    }
}

#[test]
fn saving_makes_it_unmodified() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("it.toml");
    fs::write(&path, HEADERS).unwrap();
    let mut it = Document::open(&path).unwrap();
    it.set_shape(0, &ball([0.0; 3], 1.0), 0).unwrap();
    assert!(it.is_modified());
    it.save().unwrap();
    assert!(!it.is_modified() && !it.changed_on_disk());
    assert_eq!(fs::read_to_string(&path).unwrap(), it.text());
    it.undo();
    assert!(it.is_modified());

    let other = folder.path().join("other.toml");
    it.save_as(&other).unwrap();
    assert_eq!((it.path(), it.is_modified()), (other.as_path(), false));
    assert_eq!(fs::read_to_string(&other).unwrap(), HEADERS);
    check(&it);

    let nowhere = folder.path().join("none/it.toml");
    let error = it.save_as(&nowhere).unwrap_err().to_string();
    assert!(error.starts_with(&format!("{}: cannot be written: ", nowhere.display())), "{error}");
    assert_eq!(it.path(), other);
}

#[test]
fn reloading_is_a_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("it.toml");
    fs::write(&path, HEADERS).unwrap();
    let mut it = Document::open(&path).unwrap();
    it.set_shape(0, &ball([0.0; 3], 1.0), 0).unwrap();
    let edited = it.text().to_string();
    assert!(!it.reload().unwrap() && it.is_modified());

    fs::write(&path, INLINE).unwrap();
    assert!(it.changed_on_disk());
    assert!(it.reload().unwrap() && !it.is_modified() && !it.changed_on_disk());
    assert_eq!(it.text(), INLINE);
    check(&it);

    fs::write(&path, "version = ").unwrap();
    assert!(it.reload().is_err() && it.changed_on_disk());
    assert_eq!(it.text(), INLINE);

    assert_eq!(it.undo().as_deref(), Some("reload"));
    assert_eq!(it.text(), edited);
    fs::remove_file(&path).unwrap();
    assert!(!it.changed_on_disk() && it.reload().is_err());
}

#[test]
fn a_text_of_its_own_is_modified_until_saved() {
    let folder = tempfile::tempdir().unwrap();
    let mut it = Document::from_text(HEADERS, &folder.path().join("new.toml")).unwrap();
    assert!(it.is_modified() && !it.changed_on_disk());
    it.save().unwrap();
    assert!(!it.is_modified());
}
