//! Primitives: modes, parts, attributes.

use raggio_models::Model;
use serde_json::json;

use crate::gltf::builder::{Builder, CORNERS, U8};

/// A mesh of five vertices in a plane, in the order of `mode`.
fn of_mode(mode: u32, indices: Option<&[u16]>) -> Builder {
    let mut builder = Builder::empty();
    let positions = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.5], [-1.0, 1.0]].map(|[x, y]| [x, y, 0.0f32]);
    let positions = builder.floats("VEC3", positions.as_flattened());
    let mut primitive = json!({ "attributes": { "POSITION": positions }, "mode": mode });
    if let Some(indices) = indices {
        primitive["indices"] = json!(builder.indices(indices));
    }
    builder.push("meshes", json!({ "primitives": [primitive], "name": "five" }));
    builder.push("nodes", json!({ "mesh": 0, "name": "node" }));
    builder
}

#[test]
fn strips_and_fans() {
    assert_eq!(of_mode(5, None).mesh().triangles, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(of_mode(6, None).mesh().triangles, [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
    assert_eq!(of_mode(5, Some(&[4, 0, 1, 2])).mesh().triangles, [[4, 0, 1], [0, 2, 1]]);
    assert_eq!(of_mode(6, Some(&[0, 1, 2, 3])).mesh().triangles, [[1, 2, 0], [2, 3, 0]]);
    assert_eq!(of_mode(4, Some(&[4, 0, 1, 0, 1, 2])).mesh().triangles, [[4, 0, 1], [0, 1, 2]]);
}

#[test]
fn points_and_lines_are_left_out() {
    for mode in 0..4 {
        let model = of_mode(mode, None).load();
        assert!(model.meshes.is_empty() && model.instances.is_empty());
        assert!(model.warnings[0].contains("meshes[0].primitives[0] is left out: points and lines have no surface"));
    }
    assert!(of_mode(7, None).error().contains("meshes[0].primitives[0].mode: the mode is 7: it should be 0 to 6"));
}

#[test]
fn corners_left_over_are_told() {
    let builder = of_mode(4, Some(&[0, 1, 2, 3]));
    assert_eq!(builder.mesh().triangles, [[0, 1, 2]]);
    assert!(builder.warning().contains("4 corners do not make up whole triangles"));
}

#[test]
fn all_attributes() {
    let mut builder = Builder::triangle();
    let normals = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangents = builder.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let uvs = [builder.floats("VEC2", &[0.1, 0.2].repeat(3)), builder.floats("VEC2", &[0.3, 0.4].repeat(3))];
    let colors = builder.accessor("VEC4", U8, 3, &[255, 0, 51, 102].repeat(3));
    builder.attribute("NORMAL", normals).attribute("TANGENT", tangents).attribute("COLOR_0", colors);
    builder.attribute("TEXCOORD_0", uvs[0]).attribute("TEXCOORD_1", uvs[1]);
    let mesh = builder.mesh();
    assert_eq!(mesh.normals.as_deref(), Some(&[[0.0, 0.0, 1.0]; 3][..]));
    assert_eq!(mesh.tangents.as_deref(), Some(&[[1.0, 0.0, 0.0, -1.0]; 3][..]));
    assert_eq!(mesh.uvs[0].as_deref(), Some(&[[0.1, 0.2]; 3][..]));
    assert_eq!(mesh.uvs[1].as_deref(), Some(&[[0.3, 0.4]; 3][..]));
    assert_eq!(mesh.colors.as_deref(), Some(&[[1.0, 0.0, 0.2, 0.4]; 3][..]));
}

#[test]
fn colors_without_alpha_are_opaque() {
    let mut builder = Builder::triangle();
    let colors = builder.floats("VEC3", &[0.1, 0.2, 0.3].repeat(3));
    builder.attribute("COLOR_0", colors);
    assert_eq!(builder.mesh().colors.as_deref(), Some(&[[0.1, 0.2, 0.3, 1.0]; 3][..]));
}

#[test]
fn absent_attributes_are_none_and_tangents_need_normals() {
    let mut builder = Builder::triangle();
    let tangents = builder.floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(3));
    builder.attribute("TANGENT", tangents);
    let mesh = builder.mesh();
    assert!(mesh.normals.is_none() && mesh.tangents.is_none() && mesh.colors.is_none());
    assert_eq!(mesh.uvs, [None, None]);
}

#[test]
fn weights_fit_the_morph_targets() {
    let mut builder = Builder::triangle();
    builder.json["meshes"][0]["weights"] = json!([1]);
    builder.json["nodes"][0]["weights"] = json!([1, 2]);
    assert_eq!(builder.mesh().positions, CORNERS);
    let told = ["meshes[0].weights has 1 weight", "nodes[0].weights has 2 weights"];
    assert_eq!(builder.load().warnings, told.map(|told| format!("{told} for 0 morph targets: the rest is not used")));

    let mut builder = Builder::triangle();
    let deltas = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let target = json!({ "POSITION": deltas });
    builder.json["meshes"][0]["primitives"][0]["targets"] = json!([target, target]);
    builder.json["meshes"][0]["weights"] = json!([0.5]);
    assert_eq!(builder.mesh().positions, CORNERS.map(|[x, y, _]| [x, y, 0.5]));
    assert_eq!(builder.warning(), "meshes[0].weights has 1 weight for 2 morph targets: the rest is 0");
    builder.json["meshes"][0]["weights"] = json!([0.25, 0.5, 9]);
    assert_eq!(builder.mesh().positions, CORNERS.map(|[x, y, _]| [x, y, 0.75]));
}

#[test]
fn attributes_that_are_not_used_are_told() {
    let mut builder = Builder::triangle();
    let uvs = builder.floats("VEC2", &[0.0; 6]);
    builder.attribute("TEXCOORD_2", uvs).attribute("_TEMPERATURE", uvs);
    assert_eq!(builder.warning(), "meshes[0].primitives[0]: the attribute `TEXCOORD_2` is not used");
}

/// A model of two primitives that share their vertices, and a third that has normals and vertices of its own.
fn of_parts() -> Model {
    let mut builder = of_mode(4, Some(&[0, 1, 2]));
    let second = builder.indices(&[2, 3, 4]);
    builder.push("materials", json!({ "name": "red" }));
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": second, "material": 0 });
    let positions = builder.floats("VEC3", CORNERS.as_flattened());
    let normals = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let third = json!({ "attributes": { "POSITION": positions, "NORMAL": normals } });
    let primitives = builder.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.extend([primitive, third]);
    builder.load()
}

#[test]
fn primitives_become_parts() {
    let model = of_parts();
    assert_eq!(model.meshes.len(), 1);
    let mesh = &model.meshes[0];
    assert_eq!(mesh.positions.len(), 8, "the first two share theirs");
    assert_eq!(mesh.triangles, [[0, 1, 2], [2, 3, 4], [5, 6, 7]]);
    let parts: Vec<_> = mesh.parts.iter().map(|part| (&*part.name, part.material, part.triangles.clone())).collect();
    assert_eq!(parts, [("five", None, 0..1), ("five", Some(0), 1..2), ("five", None, 2..3)]);
    let normals = mesh.normals.as_ref().unwrap();
    assert_eq!((normals[0], normals[4], normals[5]), ([0.0; 3], [0.0; 3], [0.0, 0.0, 1.0]));
    assert_eq!(model.materials[0].name, "red");
}

#[test]
fn broken_vertices_are_cleaned_away_and_told() {
    let mut builder = Builder::empty();
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN; 3]];
    let positions = builder.floats("VEC3", positions.as_flattened());
    let indices = builder.indices(&[0, 1, 3, 0, 0, 1, 0, 1, 2]);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.push("nodes", json!({ "mesh": 0 }));
    assert_eq!(builder.mesh().triangles, [[0, 1, 2]]);
    let warning = builder.warning();
    assert!(warning.contains("1 face without area") && warning.contains("1 triangle with a vertex that is not"));
}
