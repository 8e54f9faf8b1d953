//! Scenes that show a model.

use std::path::Path;

use glam::DVec3;
use raggio_scene::{AssetOptions, Assets, Environment, Geometry, Scene, scene_text};

use crate::assets::files::{Folder, TRIANGLE_PLY, meshes};
use crate::common::check_invariants;

/// A box from `min` to `max`, as an OBJ.
fn cuboid(min: DVec3, max: DVec3) -> String {
    let corner = |i: usize| DVec3::new([min, max][i & 1].x, [min, max][i >> 1 & 1].y, [min, max][i >> 2 & 1].z);
    let vertices: String = (0..8).map(corner).map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    format!("{vertices}f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n")
}

fn shown(path: &Path, assets: &mut Assets) -> Scene {
    let scene = Scene::load_with(path, assets).unwrap();
    check_invariants(&scene);
    scene
}

/// The largest distance of a vertex from the picture's middle, across and upwards; 1 is the edge.
fn extent(scene: &Scene) -> [f64; 2] {
    let camera = &scene.camera;
    let position = camera.position.as_dvec3();
    let forward = (camera.look_at.as_dvec3() - position).normalize();
    let right = forward.cross(camera.up.as_dvec3()).normalize();
    let up = right.cross(forward);
    let tangent = camera.half_height();
    let aspect = f64::from(scene.render.width) / f64::from(scene.render.height);
    let mut extent = [0.0f64; 2];
    for (mesh, world_from_mesh, _) in meshes(scene) {
        for vertex in &mesh.positions {
            let towards = world_from_mesh.transform_point3(DVec3::from(vertex.map(f64::from))) - position;
            let depth = towards.dot(forward);
            assert!(depth > 0.0, "behind the camera");
            let seen = [towards.dot(right) / (depth * tangent * aspect), towards.dot(up) / (depth * tangent)];
            extent = [extent[0].max(seen[0].abs()), extent[1].max(seen[1].abs())];
        }
    }
    extent
}

/// Checks that all of the model is in the picture, and fills most of it in one direction.
fn assert_framed(scene: &Scene) {
    let [across, upwards] = extent(scene);
    assert!(across <= 1.0 && upwards <= 1.0, "{across} {upwards}");
    assert!(across.max(upwards) > 0.75, "{across} {upwards}");
}

/// Checks that the ground is below the model, by next to nothing.
fn assert_grounded(scene: &Scene, lowest: f64, largest: f64) {
    let planes = scene.shapes.iter().filter_map(|shape| match shape.geometry {
        Geometry::Plane { point, normal } => Some((point, normal)),
        _ => None,
    });
    let [(point, normal)] = planes.collect::<Vec<_>>()[..] else { panic!("one ground") };
    assert_eq!(normal.as_dvec3(), DVec3::Y);
    let gap = lowest - f64::from(point.y);
    assert!(gap > 0.0 && gap < 1e-3 * largest, "{gap}");
}

#[test]
fn models_of_every_size_and_place_are_framed_and_grounded() {
    let folder = Folder::new();
    let unit = DVec3::ONE;
    for (min, max) in [
        (-unit, unit),
        (-1e-6 * unit, 1e-6 * unit),
        (-1e6 * unit, 1e6 * unit),
        (DVec3::new(-10.0, 0.0, -0.1), DVec3::new(10.0, 0.2, 0.1)),
        (DVec3::new(-0.1, 0.0, -0.1), DVec3::new(0.1, 20.0, 0.1)),
        (DVec3::new(0.0, 0.0, -30.0), DVec3::new(1.0, 1.0, 30.0)),
        (DVec3::new(1000.0, -500.0, 300.0), DVec3::new(1001.0, -499.0, 301.0)),
        (DVec3::new(-1.0, 2.0, -1.0), DVec3::new(1.0, 2.0, 1.0)),
        (DVec3::new(3.0, -1.0, -1.0), DVec3::new(3.0, 1.0, 1.0)),
    ] {
        folder.write("box.obj", cuboid(min, max));
        let scene = shown(&folder.path("box.obj"), &mut Assets::default());
        assert_framed(&scene);
        assert_grounded(&scene, min.y, (max - min).max_element().max(2.5e-3 * min.abs().max_element()));
        let above = scene.camera.position.as_dvec3() - 0.5 * (min + max);
        assert!(above.min_element() > 0.0, "in front of it, to the right, above: {above}");
    }
}

#[test]
fn models_are_framed_for_the_picture_that_is_asked_for() {
    let folder = Folder::new();
    folder.write("box.obj", cuboid(DVec3::new(-3.0, -1.0, -1.0), DVec3::new(3.0, 1.0, 1.0)));
    for picture in [[300, 300], [200, 900], [1600, 400]] {
        let mut assets = Assets::new(AssetOptions { picture: Some(picture), ..AssetOptions::default() });
        let scene = shown(&folder.path("box.obj"), &mut assets);
        assert_eq!([scene.render.width, scene.render.height], picture);
        assert_framed(&scene);
    }
}

#[test]
fn the_sky_lights_it_and_nothing_is_warned_of() {
    let folder = Folder::new();
    let scene = shown(&folder.path("triangle.ply"), &mut Assets::default());
    let Environment::Gradient { horizon, zenith } = scene.environment else { panic!("a gradient") };
    assert!(zenith.min_element() > horizon.max_element());
    assert_eq!(scene.warnings, [""; 0]);
    assert_eq!((scene.render.width, scene.render.height), (1280, 720));
}

#[test]
fn a_model_keeps_its_materials_and_gets_one_if_it_has_none() {
    let folder = Folder::new();
    let own = shown(&folder.path("parts.obj"), &mut Assets::default());
    let names: Vec<&str> = own.materials.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["ground", "parts.obj/red", "parts.obj/blue", "parts.obj/default"]);
    let bare = shown(&folder.path("triangle.ply"), &mut Assets::default());
    let names: Vec<&str> = bare.materials.iter().map(|it| it.name.as_str()).collect();
    assert_eq!(names, ["ground", "clay"]);
    assert_eq!(bare.shapes[1].material, 1);
}

#[test]
fn what_printers_build_stands_upright() {
    let folder = Folder::new();
    // A triangle from the origin along x and z, where z is upwards.
    let corner = |x: f32, y: f32, z: f32| [x, y, z].map(f32::to_le_bytes).concat();
    let corners = [corner(0.0, 0.0, 0.0), corner(1.0, 0.0, 0.0), corner(0.0, 0.0, 3.0)].concat();
    folder.write("it.stl", [&[0; 80][..], &1u32.to_le_bytes(), &[0; 12], &corners, &[0; 2]].concat());
    let scene = shown(&folder.path("it.stl"), &mut Assets::default());
    assert_framed(&scene);
    assert_grounded(&scene, 0.0, 3.0);
    let (_, world_from_mesh, _) = meshes(&scene)[0];
    assert!(world_from_mesh.transform_vector3(DVec3::Z).abs_diff_eq(DVec3::Y, 1e-12));
}

#[test]
fn its_text_is_a_scene_of_its_own() {
    let folder = Folder::new();
    let name = "it \"\u{7f}\u{fc}.ply";
    folder.write(name, TRIANGLE_PLY);
    let mut assets = Assets::default();
    let text = scene_text(&folder.path(name), &mut assets).unwrap();
    let parsed = Scene::parse_with(&text, &folder.path("saved.toml"), &mut assets).unwrap();
    assert_eq!(parsed, shown(&folder.path(name), &mut Assets::default()));
}

#[test]
fn what_cannot_be_shown_is_said_of_the_model() {
    let folder = Folder::new();
    let error = |name: &str| folder.shown(&Scene::load(&folder.path(name)).unwrap_err().to_string());
    assert_eq!(error("absent.glb"), "absent.glb: there is no such file");
    folder.write("points.obj", "v 1 2 3\n");
    assert_eq!(error("points.obj"), "points.obj: has no triangles, so there is nothing to be seen");
    folder.write("point.obj", "v 1 2 3\nv 1 2 3\nf 1 2 2\n");
    assert_eq!(error("point.obj"), "point.obj: has no triangles, so there is nothing to be seen");
    folder.write("wrong.obj", "v 0 0 0\nf x 1 1\n");
    assert!(error("wrong.obj").starts_with("wrong.obj:2: "), "{}", error("wrong.obj"));
    folder.write("cut.ply", "ply\n");
    assert!(error("cut.ply").starts_with("cut.ply:"), "{}", error("cut.ply"));
    folder.write("far.obj", "v 0 0 0\nv 1e20 0 0\nv 0 1e20 0\nf 1 2 3\n");
    assert_eq!(error("far.obj"), "far.obj: is too large: keep all of it within 1e14 of the origin");
}

#[test]
fn warnings_name_the_model_alone() {
    let folder = Folder::new();
    folder.write("it.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 2\n");
    let scene = shown(&folder.path("it.obj"), &mut Assets::default());
    let [warning] = &scene.warnings[..] else { panic!("one warning") };
    assert!(warning.starts_with("it.obj: 1 "), "{warning}");
}
