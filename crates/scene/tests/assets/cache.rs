//! Files that are read again when a scene is, and files that are not.

use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use raggio_scene::{Assets, Environment, Scene};

use crate::assets::files::{Folder, TRIANGLE_PLY, meshes};

const BODY: &str = "[environment]
image = \"pixel.hdr\"
[materials.red]
[[shapes]]
material = \"red\"
mesh = { file = \"triangle.ply\" }
";

fn files(assets: &Assets) -> Vec<PathBuf> {
    let mut files: Vec<_> = assets.files().map(PathBuf::from).collect();
    files.sort();
    files
}

fn canonical(folder: &Folder, names: &[&str]) -> Vec<PathBuf> {
    names.iter().map(|name| folder.path(name).canonicalize().unwrap()).collect()
}

fn share_everything(a: &Scene, b: &Scene) -> bool {
    let (Environment::Image { image: a_sky, .. }, Environment::Image { image: b_sky, .. }) =
        (&a.environment, &b.environment)
    else {
        panic!("images");
    };
    Arc::ptr_eq(a_sky, b_sky) && Arc::ptr_eq(meshes(a)[0].0, meshes(b)[0].0)
}

#[test]
fn a_text_that_is_read_again_reads_no_file_again() {
    let folder = Folder::new();
    let mut assets = Assets::default();
    let first = folder.read(BODY, &mut assets).unwrap();
    assert_eq!(files(&assets), canonical(&folder, &["pixel.hdr", "triangle.ply"]));
    // The files are not even looked for.
    fs::remove_file(folder.path("pixel.hdr")).unwrap();
    fs::remove_file(folder.path("triangle.ply")).unwrap();
    let second = folder.read(&BODY.replace("red", "blue"), &mut assets).unwrap();
    assert!(share_everything(&first, &second));
    let error = folder.read(BODY, &mut Assets::default()).unwrap_err();
    assert!(error.message.ends_with("there is no such file"), "{error}");
}

#[test]
fn what_is_no_longer_named_is_forgotten() {
    let folder = Folder::new();
    let mut assets = Assets::default();
    let scene = folder.read(BODY, &mut assets).unwrap();
    let mesh = Arc::downgrade(meshes(&scene)[0].0);
    drop(scene);
    assert!(mesh.upgrade().is_some());
    folder.read("[environment]\nimage = \"pixel.hdr\"\n", &mut assets).unwrap();
    assert!(mesh.upgrade().is_none());
    assert_eq!(files(&assets), canonical(&folder, &["pixel.hdr"]));
}

#[test]
fn a_text_that_is_wrong_makes_nothing_forgotten() {
    let folder = Folder::new();
    let mut assets = Assets::default();
    let first = folder.read(BODY, &mut assets).unwrap();
    folder.read(&BODY.replace("red\"", "rad\""), &mut assets).unwrap_err();
    assert!(share_everything(&first, &folder.read(BODY, &mut assets).unwrap()));
}

#[test]
fn a_changed_file_is_read_again_after_a_refresh() {
    let folder = Folder::new();
    let mut assets = Assets::default();
    let first = folder.read(BODY, &mut assets).unwrap();
    assert!(!assets.refresh());
    assert!(share_everything(&first, &folder.read(BODY, &mut assets).unwrap()));

    folder.write("triangle.ply", TRIANGLE_PLY.replace("0 2 0\n", "0 3.5 0\n"));
    let stale = folder.read(BODY, &mut assets).unwrap();
    assert!(share_everything(&first, &stale));
    assert!(assets.refresh());
    let fresh = folder.read(BODY, &mut assets).unwrap();
    assert_eq!(meshes(&fresh)[0].0.positions[2], [0.0, 3.5, 0.0]);
    assert!(!assets.refresh());
}

#[test]
fn a_file_of_its_own_time_is_changed_too() {
    let folder = Folder::new();
    let mut assets = Assets::default();
    folder.read(BODY, &mut assets).unwrap();
    // The new text has the old one's length, but a later time.
    folder.write("triangle.ply", TRIANGLE_PLY.replace("0 2 0\n", "0 3 0\n"));
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(5);
    fs::File::options().append(true).open(folder.path("triangle.ply")).unwrap().set_modified(later).unwrap();
    assert!(assets.refresh());
    let scene = folder.read(BODY, &mut assets).unwrap();
    assert_eq!(meshes(&scene)[0].0.positions[2], [0.0, 3.0, 0.0]);
}

#[test]
fn a_file_that_is_gone_is_missed_after_a_refresh() {
    let folder = Folder::new();
    let mut assets = Assets::default();
    folder.read(BODY, &mut assets).unwrap();
    fs::remove_file(folder.path("triangle.ply")).unwrap();
    assert!(assets.refresh());
    let error = folder.read(BODY, &mut assets).unwrap_err();
    assert_eq!(folder.shown(&error.to_string()), "scene.toml:11:17: triangle.ply: there is no such file");
    // Whoever asks only after a refresh must learn that there is still something to read.
    folder.write("triangle.ply", TRIANGLE_PLY);
    assert!(assets.refresh());
    folder.read(BODY, &mut assets).unwrap();
    assert!(!assets.refresh());
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_elsewhere_is_followed_after_a_refresh() {
    let folder = Folder::new();
    folder.write("other.ply", TRIANGLE_PLY.replace("0 2 0\n", "0 4 0\n"));
    let link = |to: &str| {
        let _ = fs::remove_file(folder.path("link.ply"));
        std::os::unix::fs::symlink(folder.path(to), folder.path("link.ply")).unwrap();
    };
    link("triangle.ply");
    let body = BODY.replace("triangle.ply", "link.ply");
    let mut assets = Assets::default();
    folder.read(&body, &mut assets).unwrap();
    link("other.ply");
    assets.refresh();
    let scene = folder.read(&body, &mut assets).unwrap();
    assert_eq!(meshes(&scene)[0].0.positions[2], [0.0, 4.0, 0.0]);
}

/// Names of the watched files, in order.
fn watched(folder: &Folder, assets: &Assets) -> Vec<String> {
    let root = folder.path("").canonicalize().unwrap();
    let mut names: Vec<_> =
        assets.watched_files().map(|path| path.strip_prefix(&root).unwrap().display().to_string()).collect();
    names.sort();
    names
}

#[test]
fn a_model_is_read_again_when_a_file_that_it_names_changes_comes_or_goes() {
    let folder = Folder::new();
    let mut assets = Assets::default();
    let body = "[environment]\ncolor = [1, 1, 1]\n[[shapes]]\nmesh = { file = \"parts.obj\" }\n";
    let mut red = |what: &str, is_stale: bool| {
        assert_eq!(assets.refresh(), is_stale, "{what}");
        let scene = folder.read(body, &mut assets).unwrap();
        assert!(!assets.refresh(), "{what}");
        let named = scene.materials.iter().find(|material| material.name == "parts.obj/red");
        let surface = named.map(|material| material.principled.clone().unwrap());
        (surface, watched(&folder, &assets))
    };
    let library = |blue: f32, image: &str| format!("newmtl red\nKd 1 0 {blue}\n{image}\nnewmtl blue\nKd 0 0 1\n");
    let (first, files) = red("at first", false);
    assert_eq!(
        (first.unwrap().base_color, files),
        ([1.0, 0.0, 0.0], vec!["parts.mtl".into(), "parts.obj".to_string()])
    );

    folder.write("parts.mtl", library(0.25, ""));
    assert_eq!(red("another colour", true).0.unwrap().base_color, [1.0, 0.0, 0.25]);

    // An image that is not there yet, and then is, is another, and is gone.
    folder.write("parts.mtl", library(0.25, "map_Kd new.hdr"));
    let (surface, files) = red("an image that is missing", true);
    assert!(surface.unwrap().base_color_texture.is_none());
    assert_eq!(files, ["new.hdr", "parts.mtl", "parts.obj"]);
    for side in [1, 3usize] {
        let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {side} +X {side}\n");
        folder.write("new.hdr", [header.as_bytes(), &[0x80; 4].repeat(side * side)].concat());
        let (surface, files) = red(&format!("an image of {side} x {side}"), true);
        assert_eq!(surface.unwrap().base_color_texture.clone().unwrap().image.width as usize, side);
        assert_eq!(files, ["new.hdr", "parts.mtl", "parts.obj"]);
    }
    fs::remove_file(folder.path("new.hdr")).unwrap();
    assert!(red("no image", true).0.unwrap().base_color_texture.is_none());
    fs::remove_file(folder.path("parts.mtl")).unwrap();
    let (_, files) = red("no library", true);
    assert_eq!(files, ["parts.mtl", "parts.obj"]);
    folder.write("parts.mtl", library(0.5, ""));
    assert_eq!(red("the library is back", true).0.unwrap().base_color, [1.0, 0.0, 0.5]);
}
