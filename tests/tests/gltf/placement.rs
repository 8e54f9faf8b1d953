//! Placement of things: nodes, instances, cameras.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;
use raggio_scene::{AssetOptions, Assets, Scene};
use raggio_tests::devices::cpu;
use raggio_tests::render;
use raggio_tests::render::means;
use serde_json::json;

use crate::gltf::asset::{Asset, I16, glowing};
use crate::gltf::picture::{Shot, within};

#[test]
fn nodes_place_their_meshes() {
    let turned = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
    let cases = [
        ("as it is", json!([{ "mesh": 0 }]), [0.0, 0.0], [1.0, 1.0]),
        ("translation", json!([{ "mesh": 0, "translation": [0.5, -0.25, 0] }]), [0.5, -0.25], [1.0, 1.0]),
        ("scale", json!([{ "mesh": 0, "scale": [2, 0.5, 1] }]), [0.0, 0.0], [2.0, 0.5]),
        (
            "rotation after scale",
            json!([{ "mesh": 0, "scale": [2, 0.5, 1], "rotation": turned }]),
            [0.0, 0.0],
            [0.5, 2.0],
        ),
        (
            "matrix, by columns",
            json!([{ "mesh": 0, "matrix": [0, 2, 0, 0, -0.5, 0, 0, 0, 0, 0, 1, 0, 0.5, 0.25, 0, 1] }]),
            [0.5, 0.25],
            [0.5, 2.0],
        ),
        (
            "parents on top of children",
            json!([
                { "children": [1], "translation": [0, 0.5, 0], "rotation": turned },
                { "mesh": 0, "translation": [0.75, 0.25, 0], "scale": [1, 0.5, 1] },
            ]),
            [-0.25, 1.25],
            [0.5, 1.0],
        ),
    ];
    for (what, nodes, center, size) in cases {
        Shot::default().take(&Asset::square(glowing()).nodes(nodes)).assert_lit(what, within(center, size));
    }
}

/// A mirrored body has its inside where it was: what it absorbs tells.
#[test]
fn mirrored_bodies_keep_their_inside() {
    let volume = json!({ "thicknessFactor": 1, "attenuationColor": [0.5, 0.8, 0.2], "attenuationDistance": 0.5 });
    let tinted = json!({
        "pbrMetallicRoughness": { "roughnessFactor": 0, "metallicFactor": 0 },
        "extensions": {
            "KHR_materials_ior": { "ior": 1 },
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": volume,
        },
    });
    for scale in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, -1.0]] {
        let asset = Asset::cube(tinted.clone()).nodes(json!([{ "mesh": 0, "scale": scale }]));
        let picture = Shot { samples: 16, depth: 4, ..Shot::furnace() }.take(&asset);
        // Light goes straight through a side of 1, which is two of the distances after which the colour is left.
        let expected = DVec3::new(0.25, 0.64, 0.04);
        picture.assert_at(&format!("a cube scaled by {scale:?}"), (0.06, 0.06), expected, 2e-3);
    }
}

/// The right half of a triangle becomes its left half, and light still comes from the side of its normals.
#[test]
fn negative_scales_mirror() {
    let triangle = |x: f64, y: f64| x > -0.5 && y > -0.5 && x + y < 0.0;
    let mut asset = Asset::square(glowing());
    let indices = asset.indices(&[0, 1, 3]);
    asset.primitive()["indices"] = json!(indices);
    let shown = |node| Shot::default().take(&asset.clone().nodes(json!([node])));
    let node = json!({ "mesh": 0, "translation": [0.03, 0, 0] });
    shown(node).assert_lit("the triangle", |x, y| triangle(x - 0.03, y));
    let node = json!({ "mesh": 0, "translation": [0.03, 0, 0], "scale": [-1, 1, 1] });
    shown(node).assert_lit("the mirrored triangle", |x, y| triangle(0.03 - x, y));
}

#[test]
fn instances_by_attributes() {
    let mut asset = Asset::square(glowing());
    let translations = asset.floats("VEC3", &[-1.0, 1.0, 0.0, 0.75, -0.75, 0.0]);
    let scales = asset.floats("VEC3", &[0.5, 0.5, 1.0, 1.0, 0.25, 1.0]);
    let bytes: Vec<u8> = [0i16, 0, 0, 32767, 0, 0, 23170, 23170].iter().flat_map(|x| x.to_le_bytes()).collect();
    let view = asset.view(&bytes);
    let accessor = json!({ "bufferView": view, "componentType": I16, "count": 2, "type": "VEC4", "normalized": true });
    let rotations = asset.push("accessors", accessor);
    let attributes = json!({ "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales });
    let extension = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    let asset = asset.nodes(json!([{ "mesh": 0, "extensions": extension }]));
    let (first, second) = (within([-1.0, 1.0], [0.5, 0.5]), within([0.75, -0.75], [0.25, 1.0]));
    Shot::default().take(&asset).assert_lit("instances", |x, y| first(x, y) || second(x, y));
}

#[test]
fn hidden_nodes_are_not_seen() {
    let hidden = json!({ "KHR_node_visibility": { "visible": false } });
    let asset = Asset::square(glowing()).nodes(json!([{ "mesh": 0, "extensions": hidden }]));
    Shot::default().take(&asset).assert_lit("nothing", |_, _| false);
}

/// The file alone is seen through its own camera, which stands to the right and looks along -X.
#[test]
fn cameras_of_the_file() {
    let bright = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 1000 } });
    let mut asset = Asset::square(crate::gltf::asset::merged(glowing(), json!({ "extensions": bright })));
    let sideways = json!([0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2]);
    asset.json["nodes"] = json!([
        { "mesh": 0, "rotation": sideways, "scale": [1, 0.5, 1] },
        { "camera": 0, "rotation": sideways, "translation": [2, 0, 0] },
    ]);
    // Half of the picture's height is 1 at the distance 2.
    let perspective = json!({ "yfov": 2.0 * 0.5f64.atan(), "aspectRatio": 1.5, "znear": 0.1 });
    asset.json["cameras"] = json!([{ "type": "perspective", "perspective": perspective }]);

    let folder = tempfile::tempdir().expect("there is room for temporary files");
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, asset.bytes()).expect("the model is written");
    let mut scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene.render.width * 2, scene.render.height * 3);
    (scene.render.width, scene.render.height, scene.render.filter) = (24, 16, raggio_scene::Filter::Point);
    for (i, radiance) in means(&render(cpu(), &scene, 1)).iter().enumerate() {
        let (x, y) = (((i % 24) as f64 + 0.5) / 8.0 - 1.5, 1.0 - ((i / 24) as f64 + 0.5) / 8.0);
        assert_eq!(radiance.x > 900.0, within([0.0, 0.0], [1.0, 0.5])(x, y), "{radiance} at ({x}, {y})");
    }
}

/// Of a file's cameras one is chosen by name or number; through the orthographic one things are as large far away as near.
#[test]
fn one_of_the_cameras_is_chosen() {
    let bright = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": 1000 } });
    let mut asset = Asset::square(crate::gltf::asset::merged(glowing(), json!({ "extensions": bright })));
    asset.json["nodes"] = json!([
        { "mesh": 0 },
        { "camera": 0, "name": "near", "translation": [0, 0, 2] },
        { "camera": 1, "name": "plan", "translation": [0.25, 0, 50] },
    ]);
    let perspective = json!({ "yfov": 2.0 * 0.5f64.atan(), "aspectRatio": 1.5, "znear": 0.1 });
    let orthographic = json!({ "xmag": 1.5, "ymag": 1, "znear": 0.1, "zfar": 100 });
    asset.json["cameras"] = json!([
        { "type": "perspective", "perspective": perspective },
        { "type": "orthographic", "orthographic": orthographic },
    ]);
    let folder = tempfile::tempdir().expect("there is room for temporary files");
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, asset.bytes()).expect("the model is written");
    let load = |camera: Option<&str>| {
        let camera = camera.map(str::to_owned);
        Scene::load_with(&path, &mut Assets::new(AssetOptions { camera, ..AssetOptions::default() }))
    };
    for (camera, center) in
        [(None, 0.0), (Some("near"), 0.0), (Some("1"), 0.0), (Some("plan"), -0.25), (Some("2"), -0.25)]
    {
        let mut scene = load(camera).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.render.width * 2, scene.render.height * 3);
        (scene.render.width, scene.render.height, scene.render.filter) = (24, 16, raggio_scene::Filter::Point);
        for (i, radiance) in means(&render(cpu(), &scene, 1)).iter().enumerate() {
            let (x, y) = (((i % 24) as f64 + 0.5) / 8.0 - 1.5, 1.0 - ((i / 24) as f64 + 0.5) / 8.0);
            let lit = within([center, 0.0], [1.0, 1.0])(x, y);
            assert_eq!(radiance.x > 900.0, lit, "camera {camera:?}: {radiance} at ({x}, {y})");
        }
    }
    let refused = load(Some("third")).expect_err("there is none").to_string();
    let told =
        "a.gltf: has no camera `third`: give a name or a number of 1 `near` (perspective), 2 `plan` (orthographic)";
    assert!(refused.ends_with(told), "{refused}");
}
