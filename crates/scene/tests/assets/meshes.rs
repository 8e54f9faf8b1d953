//! Placement, parts and materials of meshes.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use raggio_scene::{AssetOptions, Assets, Counts, Instance, Mesh, Model, Part, Placement, Scene, Vec3};

use crate::assets::files::{Folder, meshes};

const LIGHT: &str = "[environment]\ncolor = [1, 1, 1]\n[materials.red]\n";

/// Place of a mesh's corner (1, 2, 3) in the world.
fn placed(keys: &str) -> DVec3 {
    let folder = Folder::new();
    let scene =
        folder.scene(&format!("{LIGHT}[[shapes]]\nmaterial = \"red\"\nmesh = {{ file = \"triangle.ply\"{keys} }}\n"));
    assert_eq!(scene.warnings, [""; 0]);
    meshes(&scene)[0].1.transform_point3(DVec3::new(1.0, 2.0, 3.0))
}

#[test]
fn a_mesh_with_a_material() {
    let folder = Folder::new();
    let scene = folder.scene(&format!(
        "{LIGHT}[materials.blue]\n[[shapes]]\nmaterial = \"red\"\nsphere = {{ center = [0, 0, 0], radius = 1 }}\n\
         [[shapes]]\nmaterial = \"blue\"\nmesh = {{ file = \"triangle.ply\" }}\n"
    ));
    let shape = &scene.shapes[1];
    assert_eq!((shape.entry, shape.material, scene.materials.len()), (1, 1, 2));
    let [(mesh, world_from_mesh, None)] = meshes(&scene)[..] else { panic!("one mesh without materials of its own") };
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    assert_eq!(world_from_mesh, raggio_scene::DAffine3::IDENTITY);
    assert_eq!((scene.entries[0].shapes.clone(), scene.entries[1].shapes.clone()), (0..1, 1..2));
    let expected = Placement {
        file: "triangle.ply".to_string(),
        translation: Vec3::ZERO,
        rotation_degrees: Vec3::ZERO,
        scale: Vec3::ONE,
    };
    assert_eq!((scene.entries[1].material, scene.entries[1].placement()), (Some(1), Some(&expected)));
}

#[test]
fn it_is_scaled_then_turned_then_moved() {
    assert_eq!(placed(""), DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(placed(", translation = [10, 20, 30]"), DVec3::new(11.0, 22.0, 33.0));
    assert_eq!(placed(", scale = 2"), DVec3::new(2.0, 4.0, 6.0));
    assert_eq!(placed(", scale = [-1, 2, 0.5]"), DVec3::new(-1.0, 4.0, 1.5));
    let near = |keys: &str, x: f64, y: f64, z: f64| {
        let found = placed(keys);
        assert!(found.abs_diff_eq(DVec3::new(x, y, z), 1e-12), "{keys}: {found}");
    };
    near(", rotation_degrees = [0, 0, 90]", -2.0, 1.0, 3.0);
    near(", rotation_degrees = [90, 90, 0]", 2.0, -3.0, -1.0);
    near(", translation = [1, 0, 0], rotation_degrees = [0, 0, 90], scale = [1, 10, 1]", -19.0, 1.0, 3.0);
}

#[test]
fn the_same_file_is_the_same_mesh_however_it_is_written() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("sub")).unwrap();
    let shape = |file: &str| format!("[[shapes]]\nmaterial = \"red\"\nmesh = {{ file = {file:?} }}\n");
    let absolute = folder.path("triangle.ply").display().to_string();
    let names = ["triangle.ply", "./triangle.ply", "sub/../triangle.ply", &absolute];
    let scene = folder.scene(&format!("{LIGHT}{}", names.map(shape).concat()));
    let meshes = meshes(&scene);
    assert_eq!(meshes.len(), 4);
    assert!(meshes.iter().all(|(mesh, ..)| Arc::ptr_eq(mesh, meshes[0].0)));
}

#[test]
fn a_models_own_materials_follow_those_of_the_scene() {
    let folder = Folder::new();
    let scene = folder.scene(&format!("{LIGHT}{}", "[[shapes]]\nmesh = { file = \"parts.obj\" }\n".repeat(2)));
    let names: Vec<&str> = scene.materials.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["red", "parts.obj/red", "parts.obj/blue", "parts.obj/default"]);
    assert_eq!(scene.materials.iter().map(|it| it.imported).collect::<Vec<_>>(), [false, true, true, true]);
    assert!(scene.materials[1..].iter().all(|it| it.principled.is_some()));
    assert_eq!(scene.shapes.iter().map(|it| (it.entry, it.material)).collect::<Vec<_>>(), [(0, 3), (1, 3)]);
    assert!(meshes(&scene).iter().all(|(.., first)| *first == Some(1)));
}

#[test]
fn a_given_material_covers_all_of_a_model() {
    let folder = Folder::new();
    let scene = folder.scene(&format!("{LIGHT}[[shapes]]\nmaterial = \"red\"\nmesh = {{ file = \"parts.obj\" }}\n"));
    assert_eq!((scene.shapes[0].material, scene.materials.len()), (0, 1));
    assert_eq!(meshes(&scene)[0].2, None);
}

#[test]
fn a_model_without_materials_needs_one() {
    let error = Folder::new().error("[materials.red]\n[[shapes]]\nmesh = { file = \"triangle.ply\" }\n");
    let expected = "scene.toml:7:1: `material` is missing in shape 1: `triangle.ply` has no materials of its own";
    assert_eq!(error, expected);
}

#[test]
fn errors_and_warnings_of_a_model_name_it_and_who_named_it() {
    let folder = Folder::new();
    let shape = "[materials.red]\n[environment]\ncolor = [1, 1, 1]\n[[shapes]]\nmaterial = \"red\"\nmesh = { file = \"it.obj\" }\n";
    folder.write("it.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n");
    assert!(folder.error(shape).starts_with("scene.toml:11:17: it.obj:4: "), "{}", folder.error(shape));
    folder.write("it.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n");
    let twice = format!("{shape}{}", &shape[shape.find("[[").unwrap()..]);
    let [warning] = &folder.scene(&twice).warnings[..] else { panic!("one warning for both") };
    let warning = folder.shown(warning);
    assert!(warning.starts_with("scene.toml:11:17: it.obj: 1 "), "{warning}");
}

#[test]
fn a_mesh_without_triangles_is_no_shape() {
    let folder = Folder::new();
    folder.write("empty.obj", "v 0 0 0\n");
    let scene = folder.scene(&format!("{LIGHT}[[shapes]]\nmaterial = \"red\"\nmesh = {{ file = \"empty.obj\" }}\n"));
    assert!(scene.shapes.is_empty());
    assert!(scene.warnings.iter().any(|it| it.contains("empty.obj: ")), "{:?}", scene.warnings);
}

#[test]
fn a_mesh_beyond_what_can_be_computed_is_refused() {
    let folder = Folder::new();
    for keys in ["scale = 1e15", "translation = [0, 1e15, 0]"] {
        let error = folder.error(&format!(
            "[materials.red]\n[[shapes]]\nmaterial = \"red\"\nmesh = {{ file = \"triangle.ply\", {keys} }}\n"
        ));
        let expected = "scene.toml:9:17: triangle.ply: as it is placed here, it is too large or too small: keep all \
                        of it within 1e15 of the origin";
        assert_eq!(error, expected, "{keys}");
    }
}

#[test]
fn what_is_shared_is_counted_once() {
    let folder = Folder::new();
    let scene = folder.scene(&format!(
        "[environment]\nimage = \"pixel.hdr\"\n[materials.red.principled]\nnormal_map = \"pixel.hdr\"\n{}\
         [[shapes]]\nmesh = {{ file = \"parts.obj\" }}\n",
        "[[shapes]]\nmaterial = \"red\"\nmesh = { file = \"triangle.ply\" }\n".repeat(3)
    ));
    assert_eq!(scene.counts(), Counts { triangles: 4, meshes: 2, instances: 4, textures: 1 });
}

#[test]
fn a_broken_file_is_told_wherever_it_is_named() {
    let folder = Folder::new();
    folder.write("broken.ply", "ply\nformat ascii 1.0\n");
    let shape = "[[shapes]]\nmaterial = \"red\"\nmesh = { file = \"broken.ply\" }\n";
    let error = folder.error(&format!("{LIGHT}{shape}{shape}[[shapes]]\nmesh = {{ file = \"triangle.ply\" }}\n"));
    let lines: Vec<&str> = error.lines().collect();
    let [first, second, third] = lines[..] else { panic!("three lines in {error}") };
    let of_model = first.strip_prefix("scene.toml:11:17: broken.ply:").unwrap();
    assert_eq!(second, format!("scene.toml:14:17: broken.ply:{of_model}"));
    assert_eq!(third, "scene.toml:15:1: `material` is missing in shape 3: `triangle.ply` has no materials of its own");
}

#[test]
fn a_time_of_what_stands_still() {
    let folder = Folder::new();
    let text = format!("{LIGHT}[[shapes]]\nmaterial = \"red\"\nmesh = {{ file = \"triangle.ply\", time = 2 }}\n");
    let [warning] = &folder.scene(&text).warnings[..] else { panic!("one warning") };
    assert!(
        warning.ends_with(": `time` in `mesh` of shape 1 does nothing: .ply files have no animations"),
        "{warning}"
    );

    let mut assets = Assets::new(AssetOptions { time_seconds: Some(1.0), ..AssetOptions::default() });
    let model = Scene::load_with(&folder.path("triangle.ply"), &mut assets).unwrap();
    let expected = "a time is given, but nothing in the scene moves: only .gltf and .glb files have animations";
    assert_eq!(model.warnings, [expected]);
}

#[test]
fn a_mesh_in_memory() {
    let folder = Folder::new();
    let body = "[materials.a]\n[[shapes]]\nmaterial = \"a\"\nmesh = { file = \"memory:1\", translation = [0, 0, 5] }\n";
    let mesh = Arc::new(Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        parts: vec![Part { name: "triangle".into(), material: None, triangles: 0..1 }],
        ..Mesh::default()
    });
    let sheared = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z));
    let instance = Instance { name: "triangle".into(), mesh: 0, model_from_mesh: sheared };
    let mut assets = Assets::default();
    let model = Model { meshes: vec![mesh.clone()], instances: vec![instance], ..Model::default() };
    assets.give_model(folder.path("memory:1"), model);
    // Reading again gives the same allocation, so that devices have nothing to do.
    for _ in 0..2 {
        let scene = folder.read(body, &mut assets).unwrap();
        let (held, world_from_mesh, _) = meshes(&scene)[0];
        assert!(Arc::ptr_eq(held, &mesh));
        assert_eq!(world_from_mesh, DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0)) * sheared);
    }
    assets.take_back(&folder.path("memory:1"));
    assert!(folder.read(body, &mut assets).unwrap_err().to_string().contains("memory:1: is not a model"));
}
