//! Quantized, meshopt and Draco geometry.

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute, PointIndex,
};
use serde_json::{Value, json};

use crate::gltf::builder::{Builder, CORNERS, F32, I8, I16, U8, U16};

#[test]
fn quantized_positions_and_normals() {
    let mut builder = Builder::triangle();
    let words: Vec<u8> = [0i16, 0, 0, 0, 4, 0, 0, 0, 0, 4, 0, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let view = builder.view(&words);
    builder.json["bufferViews"][view]["byteStride"] = json!(8);
    let accessor = json!({ "bufferView": view, "componentType": I16, "count": 3, "type": "VEC3" });
    let positions = builder.push("accessors", accessor);
    let view = builder.view(&[0, 0, 127, 0].repeat(3));
    builder.json["bufferViews"][view]["byteStride"] = json!(4);
    let accessor = json!({ "bufferView": view, "componentType": I8, "count": 3, "type": "VEC3", "normalized": true });
    let normals = builder.push("accessors", accessor);
    builder.attribute("POSITION", positions).attribute("NORMAL", normals);
    builder.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let mesh = builder.mesh();
    assert_eq!(mesh.positions, [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
    assert_eq!(mesh.normals.as_deref(), Some(&[[0.0, 0.0, 1.0]; 3][..]));
}

/// Adds a view of compressed data, whose uncompressed bytes are nowhere.
fn compressed(builder: &mut Builder, extension: &str, bytes: &[u8], count: usize, stride: usize, rest: Value) -> usize {
    let source = builder.view(bytes);
    let source = builder.json["bufferViews"][source].clone();
    let mut details = json!({
        "buffer": 0,
        "byteOffset": source["byteOffset"],
        "byteLength": source["byteLength"],
        "byteStride": stride,
        "count": count,
    });
    details.as_object_mut().unwrap().extend(rest.as_object().unwrap().clone());
    let view = json!({ "buffer": 1, "byteLength": count * stride, "extensions": { extension: details } });
    builder.push("bufferViews", view)
}

/// Finishes the buffers, with a placeholder for the uncompressed data.
fn finish(builder: &mut Builder) {
    let uri = format!("data:;base64,{}", data_encoding::BASE64.encode(&builder.binary));
    builder.json["buffers"] = json!([
        { "byteLength": builder.binary.len(), "uri": uri },
        { "byteLength": 100_000, "extensions": { "EXT_meshopt_compression": { "fallback": true } } },
    ]);
}

const GRID: usize = 16;

fn grid() -> (Vec<[f32; 3]>, Vec<u32>) {
    let side = GRID as u32;
    let positions = (0..side * side).map(|i| [(i % side) as f32, (i / side) as f32, 0.0]).collect();
    let squares = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    let triangles = squares.flat_map(|i| [i, i + 1, i + side, i + 1, i + side + 1, i + side]).collect();
    (positions, triangles)
}

/// A grid whose positions and indices are compressed.
pub fn meshopt_grid(extension: &str) -> Builder {
    let (positions, indices) = grid();
    let mut builder = Builder::empty();
    let vertices = meshopt::encode_vertex_buffer(&positions).unwrap();
    let view = compressed(&mut builder, extension, &vertices, positions.len(), 12, json!({ "mode": "ATTRIBUTES" }));
    let count = positions.len();
    builder.push("accessors", json!({ "bufferView": view, "componentType": F32, "count": count, "type": "VEC3" }));
    let triangles = meshopt::encode_index_buffer(&indices, positions.len()).unwrap();
    let view = compressed(&mut builder, extension, &triangles, indices.len(), 2, json!({ "mode": "TRIANGLES" }));
    let count = indices.len();
    builder.push("accessors", json!({ "bufferView": view, "componentType": U16, "count": count, "type": "SCALAR" }));
    builder.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }));
    builder.push("nodes", json!({ "mesh": 0 }));
    finish(&mut builder);
    builder
}

/// Triangles by their corners, without regard to which comes first: compression may turn them.
fn sorted(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[[u32; 3]; 3]> {
    let corner = |i: u32| positions[i as usize].map(f32::to_bits);
    let turned = |t: &[u32; 3]| {
        let first = (0..3).min_by_key(|i| corner(t[*i])).unwrap();
        [0, 1, 2].map(|i| corner(t[(first + i) % 3]))
    };
    let mut list: Vec<_> = triangles.iter().map(turned).collect();
    list.sort_unstable();
    list
}

#[test]
fn meshopt_attributes_and_triangles() {
    let (positions, indices) = grid();
    for extension in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let mesh = meshopt_grid(extension).mesh();
        assert_eq!(mesh.positions, positions);
        assert_eq!(sorted(&mesh.positions, &mesh.triangles), sorted(&positions, indices.as_chunks().0));
    }
}

#[test]
fn meshopt_sequences() {
    let mut builder = Builder::triangle();
    let bytes = meshopt::encode_index_sequence(&[2, 0, 1], 3).unwrap();
    let view = compressed(&mut builder, "EXT_meshopt_compression", &bytes, 3, 4, json!({ "mode": "INDICES" }));
    let accessor = json!({ "bufferView": view, "componentType": 5125, "count": 3, "type": "SCALAR" });
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(builder.push("accessors", accessor));
    finish(&mut builder);
    assert_eq!(builder.mesh().triangles, [[2, 0, 1]]);
}

/// One attribute of the triangle's corners through a filter.
fn filtered(name: &str, filter: &str, bytes: &[u8], stride: usize, accessor: Value) -> raggio_models::Mesh {
    let mut builder = Builder::triangle();
    let rest = json!({ "mode": "ATTRIBUTES", "filter": filter });
    let view = compressed(&mut builder, "KHR_meshopt_compression", bytes, 3, stride, rest);
    builder.json["bufferViews"][view]["byteStride"] = json!(stride);
    let mut whole = json!({ "bufferView": view, "count": 3 });
    whole.as_object_mut().unwrap().extend(accessor.as_object().unwrap().clone());
    let accessor = builder.push("accessors", whole);
    let normals = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    builder.attribute("NORMAL", normals).attribute(name, accessor);
    finish(&mut builder);
    builder.mesh()
}

fn assert_near(found: &[f32], expected: &[f32], tolerance: f32) {
    let near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= tolerance);
    assert!(near && found.len() == expected.len(), "{found:?} should be {expected:?}");
}

#[test]
fn meshopt_filters() {
    let directions = [[0.6f32, 0.8, 0.0, 1.0], [0.0, -0.6, 0.8, 1.0], [0.0, 0.0, -1.0, 1.0]];
    for (component, stride, tolerance) in [(I8, 4, 1.5 / 127.0), (I16, 8, 1.5 / 32767.0)] {
        let bytes = match stride {
            4 => meshopt::encode_vertex_buffer(&meshopt::encode_filter_oct::<i8>(&directions, 8)).unwrap(),
            _ => meshopt::encode_vertex_buffer(&meshopt::encode_filter_oct::<i16>(&directions, 16)).unwrap(),
        };
        let accessor = json!({ "componentType": component, "type": "VEC4", "normalized": true });
        let mesh = filtered("TANGENT", "OCTAHEDRAL", &bytes, stride, accessor);
        assert_near(mesh.tangents.unwrap().as_flattened(), directions.as_flattened(), tolerance);
    }
    let corners = [[0.5f32, 1024.0, -3.0], [1.0, 0.0, 1e-3], [0.0, 7.0, 1.0]];
    let words = meshopt::encode_filter_exp(&corners, 23, meshopt::EncodeExpMode::Separate);
    let bytes = meshopt::encode_vertex_buffer(&words).unwrap();
    let mesh = filtered("POSITION", "EXPONENTIAL", &bytes, 12, json!({ "componentType": F32, "type": "VEC3" }));
    assert_near(mesh.positions.as_flattened(), corners.as_flattened(), 1e-4);
    let colors = [[1.0f32, 0.0, 0.0, 1.0], [0.2, 0.4, 0.6, 0.8], [0.0, 0.0, 1.0, 0.0]];
    let bytes = meshopt::encode_vertex_buffer(&meshopt::encode_filter_color::<u8>(&colors, 8)).unwrap();
    let accessor = json!({ "componentType": U8, "type": "VEC4", "normalized": true });
    let mesh = filtered("COLOR_0", "COLOR", &bytes, 4, accessor);
    assert_near(mesh.colors.unwrap().as_flattened(), colors.as_flattened(), 2.5 / 255.0);
}

#[test]
fn meshopt_quaternions() {
    let turns = [[0.0f32, 0.0, 0.6, 0.8], [1.0, 0.0, 0.0, 0.0]];
    let bytes = meshopt::encode_vertex_buffer(&meshopt::encode_filter_quat(&turns, 16)).unwrap();
    let mut builder = Builder::triangle();
    let rest = json!({ "mode": "ATTRIBUTES", "filter": "QUATERNION" });
    let view = compressed(&mut builder, "EXT_meshopt_compression", &bytes, 2, 8, rest);
    let accessor = json!({ "bufferView": view, "componentType": I16, "count": 2, "type": "VEC4", "normalized": true });
    let attributes = json!({ "ROTATION": builder.push("accessors", accessor) });
    builder.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    finish(&mut builder);
    let model = builder.load();
    let turned = model.instances[0].model_from_mesh.transform_vector3(glam::DVec3::X);
    // The angle is the double of that whose sine is 0.6.
    assert!((turned - glam::DVec3::new(0.28, 0.96, 0.0)).length() < 1e-4, "{turned}");
    let turned = model.instances[1].model_from_mesh.transform_vector3(glam::DVec3::Y);
    assert!((turned - glam::DVec3::NEG_Y).length() < 1e-4, "{turned}");
}

#[test]
fn meshopt_sizes_are_checked() {
    let extension = "EXT_meshopt_compression";
    for (key, value) in [("count", json!(257)), ("byteStride", json!(6)), ("filter", json!("OCTAHEDRAL"))] {
        let mut builder = meshopt_grid(extension);
        builder.json["bufferViews"][1]["extensions"][extension][key] = value;
        let error = builder.error();
        assert!(error.contains("bufferViews[1].extensions.KHR_meshopt_compression: "), "{error}");
    }
    let mut builder = meshopt_grid(extension);
    builder.json["bufferViews"][1]["extensions"][extension]["byteLength"] = json!(40);
    assert!(builder.error().contains("the compressed data is damaged"), "{}", builder.error());
}

/// The grid with normals, which Draco numbers 0 and 1.
pub fn draco_grid(method: i32) -> Builder {
    let (positions, indices) = grid();
    let mut mesh = Mesh::new();
    let mut add = |kind, width: u8, values: &[f32]| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, width, DataType::Float32, false, positions.len());
        attribute.buffer_mut().update_f32s_le(0, values);
        mesh.add_attribute(attribute);
    };
    add(GeometryAttributeType::Position, 3, positions.as_flattened());
    add(GeometryAttributeType::Generic, 3, &[0.0, 0.0, 1.0].repeat(positions.len()));
    for triangle in indices.as_chunks::<3>().0 {
        mesh.add_face(triangle.map(PointIndex));
    }
    let mut options = EncoderOptions::new();
    options.set_global_int("encoding_method", method);
    let mut bytes = EncoderBuffer::new();
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    encoder.encode(&options, &mut bytes).unwrap();

    let mut builder = Builder::empty();
    let view = builder.view(bytes.data());
    for (kind, component, count) in [("VEC3", F32, positions.len()), ("SCALAR", U16, indices.len())] {
        builder.push("accessors", json!({ "componentType": component, "count": count, "type": kind }));
    }
    let draco = json!({ "bufferView": view, "attributes": { "POSITION": 0, "NORMAL": 1 } });
    let primitive = json!({
        "attributes": { "POSITION": 0, "NORMAL": 0 },
        "indices": 1,
        "extensions": { "KHR_draco_mesh_compression": draco },
    });
    builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.push("nodes", json!({ "mesh": 0 }));
    builder
}

#[test]
fn draco_sequential_and_edgebreaker() {
    let (positions, indices) = grid();
    for method in [0, 1] {
        let mesh = draco_grid(method).mesh();
        assert_eq!(mesh.positions.len(), positions.len());
        assert_eq!(sorted(&mesh.positions, &mesh.triangles), sorted(&positions, indices.as_chunks().0));
        assert!(mesh.normals.unwrap().iter().all(|normal| *normal == [0.0, 0.0, 1.0]));
    }
}

#[test]
fn draco_ids_and_bytes_are_checked() {
    let mut builder = draco_grid(1);
    let path = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
    builder.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] =
        json!(9);
    assert!(builder.error().contains(&format!("{path}.attributes.NORMAL: the data has no attribute of id 9")));
    let mut builder = draco_grid(1);
    builder.json["bufferViews"][0]["byteLength"] = json!(30);
    assert!(builder.error().contains(&format!("{path}: the compressed data cannot be decoded")));
}

#[test]
fn compressed_corners_are_a_triangle() {
    let bytes = meshopt::encode_vertex_buffer(&CORNERS).unwrap();
    let mesh = filtered("POSITION", "NONE", &bytes, 12, json!({ "componentType": F32, "type": "VEC3" }));
    assert_eq!(mesh.positions, CORNERS);
}
