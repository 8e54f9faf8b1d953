//! Models: opened, moved, painted, read again.

use std::fs;

use raggio_scene::{Geometry, Placement, Vec3};
use raggio_viewer::document::Document;

use crate::document::with;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n";
const RED_TRIANGLE: &str = "mtllib it.mtl\nv 0 0 0\nv 1 0 0\nv 0 2 0\nusemtl red\nf 1 2 3\n";

const SCENE: &str = r#"version = 1
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[materials.clay]
[[shapes]]
mesh = { file = "it.obj" } # the model
[[shapes]]
material = "clay"
sphere = { center = [0, 0, 0], radius = 1 }
"#;

/// A folder with a model that has a material, and a scene with the model.
fn opened() -> (tempfile::TempDir, Document) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("it.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    fs::write(folder.path().join("it.obj"), RED_TRIANGLE).unwrap();
    fs::write(folder.path().join("it.toml"), SCENE).unwrap();
    let document = Document::open(&folder.path().join("it.toml")).unwrap();
    (folder, document)
}

fn placement(it: &Document) -> Placement {
    it.scene().entries[0].placement().cloned().unwrap()
}

/// Position of the model's corner (0, 2, 0) in the scene.
fn corner(it: &Document) -> Vec3 {
    let Geometry::Mesh { mesh, world_from_mesh, .. } = &it.scene().shapes[0].geometry else { panic!("a mesh") };
    world_from_mesh.transform_point3(Vec3::from(mesh.positions[2]).as_dvec3()).as_vec3()
}

#[test]
fn a_model_is_moved_where_the_file_says_it() {
    let (_folder, mut it) = opened();
    let moved = Placement { translation: Vec3::new(1.0, 2.5, 3.0), ..placement(&it) };
    assert!(it.set_model(0, &moved, None).unwrap());
    let expected = with(SCENE, r#""it.obj" }"#, r#""it.obj", translation = [1, 2.5, 3] }"#);
    assert_eq!((it.text(), it.can_undo()), (expected.as_str(), Some("move mesh")));
    assert_eq!((placement(&it), corner(&it)), (moved.clone(), Vec3::new(1.0, 4.5, 3.0)));
    assert!(!it.set_model(0, &moved, None).unwrap());

    let large = Placement { scale: Vec3::splat(2.0), ..moved };
    it.set_model(0, &large, None).unwrap();
    assert!(it.text().contains("translation = [1, 2.5, 3], scale = 2 } # the model"), "{}", it.text());
    let stretched = Placement { scale: Vec3::new(-1.0, 2.0, 1.0), ..large.clone() };
    it.set_model(0, &stretched, None).unwrap();
    assert!(it.text().contains("scale = [-1, 2, 1] } # the model"), "{}", it.text());
    assert_eq!(placement(&it), stretched);
    it.set_model(0, &large, None).unwrap();
    assert!(it.text().contains("scale = 2 } # the model"), "{}", it.text());

    let flat = Placement { scale: Vec3::new(1.0, 0.0, 1.0), ..large };
    assert!(it.set_model(0, &flat, None).unwrap_err().to_string().contains("must not be 0"));
    while it.undo().is_some() {}
    assert_eq!(it.text(), SCENE);
}

#[test]
fn a_model_is_painted_and_gets_its_own_materials_back() {
    let (_folder, mut it) = opened();
    let names = |it: &Document| it.scene().materials.iter().map(|material| material.name.clone()).collect::<Vec<_>>();
    assert_eq!((names(&it), it.scene().entries[0].material), (vec!["clay".into(), "it.obj/red".into()], None));
    let place = placement(&it);
    assert!(it.set_model(0, &place, Some(0)).unwrap());
    assert_eq!((names(&it), it.scene().entries[0].material), (vec!["clay".into()], Some(0)));
    assert!(it.set_model(0, &place, None).unwrap());
    assert_eq!(it.scene().entries[0].material, None);
    assert_eq!(it.can_undo(), Some("paint mesh"));
    let imported = it.scene().materials[1].clone();
    assert!(!it.set_material(1, &imported).unwrap());
    assert!(it.set_model(0, &place, Some(1)).is_err());
}

#[test]
fn shapes_are_counted_as_in_the_file() {
    let (folder, mut it) = opened();
    // A model that becomes no shape at all.
    fs::write(folder.path().join("empty.obj"), "v 0 0 0\n").unwrap();
    let shape = "material = \"clay\", mesh = { file = \"empty.obj\" }";
    let text = SCENE.replacen("mesh = { file = \"it.obj\" } # the model", &shape.replace(", mesh", "\nmesh"), 1);
    fs::write(folder.path().join("it.toml"), text).unwrap();
    assert!(it.reload().unwrap());
    assert_eq!((it.scene().shapes.len(), it.scene().entries.len()), (1, 2));
    let ball = Geometry::Sphere { center: Vec3::ONE, radius: 3.0 };
    assert!(it.set_shape(1, &ball, 0).unwrap());
    assert_eq!(it.scene().shapes[0].geometry, ball);
    assert_eq!(it.duplicate_shape(1).unwrap(), 2);
    assert!(it.remove_shape(0).unwrap());
    assert_eq!(it.can_undo(), Some("remove mesh"));
    assert_eq!(it.scene().shapes.len(), 2);
    assert!(it.set_shape(2, &ball, 0).is_err());
}

#[test]
fn a_model_is_opened_as_a_scene_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("it.obj");
    fs::write(&model, TRIANGLE).unwrap();
    let mut it = Document::open(&model).unwrap();
    let scene = folder.path().join("it.toml");
    assert_eq!((it.path(), it.is_modified(), it.changed_on_disk()), (scene.as_path(), false, false));
    assert!(!it.reload().unwrap());
    let moved = Placement { translation: Vec3::X, ..it.scene().entries[1].placement().cloned().unwrap() };
    let clay = it.scene().entries[1].material;
    it.set_model(1, &moved, clay).unwrap();
    assert!(it.is_modified());
    assert_eq!(it.source(), model);
    it.save().unwrap();
    assert_eq!(it.source(), scene);
    assert_eq!(Document::open(&scene).unwrap().scene(), it.scene());
    // A file that is there is not written over.
    assert_eq!(Document::open(&model).unwrap().path(), folder.path().join("it_2.toml"));
}

#[test]
fn a_model_that_changes_is_read_again() {
    let (folder, mut it) = opened();
    assert!(!it.assets_changed() && !it.reload().unwrap());
    let model = folder.path().join("it.obj");
    fs::write(&model, RED_TRIANGLE.replace("v 0 2 0", "v 0 2.75 0")).unwrap();
    assert!(it.assets_changed());
    assert!(it.reload().unwrap() && !it.assets_changed());
    assert_eq!((corner(&it), it.text(), it.can_undo()), (Vec3::Y * 2.75, SCENE, None));

    // A model that is being written is no reason to forget what it was, nor to miss what it becomes.
    fs::write(&model, "f 1 2 3\n").unwrap();
    assert!(it.reload().is_err());
    assert_eq!(corner(&it), Vec3::Y * 2.75);
    fs::write(&model, RED_TRIANGLE).unwrap();
    assert!(it.assets_changed() && it.reload().unwrap());
    assert_eq!(corner(&it), Vec3::Y * 2.0);
}

#[test]
fn a_scene_is_not_saved_where_it_would_not_find_its_models() {
    let (folder, mut it) = opened();
    let elsewhere = folder.path().join("sub/it.toml");
    fs::create_dir(folder.path().join("sub")).unwrap();
    let error = it.save_as(&elsewhere).unwrap_err().to_string();
    assert!(error.ends_with("it.toml:8:17: it.obj: there is no such file"), "{error}");
    assert!(!elsewhere.exists());
    assert_eq!(it.path(), folder.path().join("it.toml"));
}

#[test]
fn a_scene_is_not_saved_over_what_it_is_made_of() {
    let (folder, mut it) = opened();
    let model = fs::read(folder.path().join("it.obj")).unwrap();
    let error = it.save_as(&folder.path().join("it.obj")).unwrap_err().to_string();
    assert!(error.contains("it.obj: cannot be written: it would replace what is read, "), "{error}");
    assert_eq!(fs::read(folder.path().join("it.obj")).unwrap(), model);
    assert_eq!(it.path(), folder.path().join("it.toml"));
    it.save().unwrap();
}

#[test]
fn a_step_whose_model_is_gone_is_not_undone() {
    let (folder, mut it) = opened();
    it.remove_shape(0).unwrap();
    let after = it.text().to_string();
    fs::remove_file(folder.path().join("it.obj")).unwrap();
    assert_eq!(it.undo(), None);
    assert_eq!((it.text(), it.can_undo()), (after.as_str(), Some("remove mesh")));
    fs::write(folder.path().join("it.obj"), RED_TRIANGLE).unwrap();
    assert_eq!(it.undo().as_deref(), Some("remove mesh"));
    assert_eq!(it.text(), SCENE);
}
