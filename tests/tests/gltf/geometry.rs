//! Storage of vertices: in every way it gives one square.

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute, PointIndex,
};
use serde_json::{Value, json};

use crate::gltf::asset::{Asset, CORNERS, F32, I16, U8, U16, glowing};
use crate::gltf::picture::{Shot, within};

fn assert_square(what: &str, asset: &Asset) {
    Shot::default().take(asset).assert_lit(what, within([0.0, 0.0], [1.0, 1.0]));
}

/// Puts the positions of the asset behind this accessor.
fn placed(mut asset: Asset, accessor: Value) -> Asset {
    let accessor = asset.push("accessors", accessor);
    asset.primitive()["attributes"]["POSITION"] = json!(accessor);
    asset
}

/// One corner is elsewhere in the base, and overwritten; or there is no base, and all four are overwritten.
#[test]
fn sparse_accessors() {
    let bytes = |corners: &[[f32; 3]]| corners.concat().iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    for overwritten in [&[1u8][..], &[0, 1, 2, 3]] {
        let mut asset = Asset::square(glowing());
        let mut base = CORNERS;
        base[1] = [1.25, 1.25, 0.0];
        let values: Vec<_> = overwritten.iter().map(|&i| CORNERS[usize::from(i)]).collect();
        let [base, indices, values] =
            [bytes(&base), overwritten.to_vec(), bytes(&values)].map(|bytes| asset.view(&bytes));
        let sparse = json!({
            "count": overwritten.len(),
            "indices": { "bufferView": indices, "componentType": U8 },
            "values": { "bufferView": values },
        });
        let mut accessor = json!({ "componentType": F32, "count": 4, "type": "VEC3", "sparse": sparse });
        if overwritten.len() == 1 {
            accessor["bufferView"] = json!(base);
        }
        assert_square(&format!("{} sparse corners", overwritten.len()), &placed(asset, accessor));
    }
}

#[test]
fn quantized_positions() {
    let mut asset = Asset::square(glowing());
    let signs = CORNERS.map(|[x, y, _]| [(x.signum() * 16384.0) as i16, (y.signum() * 16384.0) as i16, 0, 0]);
    let view = asset.view(&signs.concat().iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>());
    asset.json["bufferViews"][view]["byteStride"] = json!(8);
    let whole = json!({ "bufferView": view, "componentType": I16, "count": 4, "type": "VEC3" });
    let mut normalized = whole.clone();
    normalized["normalized"] = json!(true);
    asset.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    // Positions are whole numbers of 2^-15, or numbers that are 1 at 32767.
    for (what, accessor, unit) in [("whole numbers", whole, 32768.0), ("normalized", normalized, 32768.0 / 32767.0)] {
        let scale = if what == "normalized" { 1.0 / unit } else { 1.0 / 32768.0 };
        let asset = placed(asset.clone(), accessor).nodes(json!([{ "mesh": 0, "scale": [scale, scale, scale] }]));
        assert_square(what, &asset);
    }
}

#[test]
fn meshopt_compression() {
    let vertices = meshopt::encode_vertex_buffer(&CORNERS).expect("vertices are encoded");
    let triangles = meshopt::encode_index_buffer(&[0, 1, 2, 0, 2, 3], 4).expect("triangles are encoded");
    let mut asset = Asset::square(glowing());
    let mut compressed = |bytes: &[u8], mode: &str, count: usize, stride: usize| {
        let source = asset.view(bytes);
        let source = asset.json["bufferViews"][source].clone();
        let details = json!({
            "buffer": 0, "byteOffset": source["byteOffset"], "byteLength": source["byteLength"],
            "mode": mode, "count": count, "byteStride": stride,
        });
        let extensions = json!({ "EXT_meshopt_compression": details });
        asset.push("bufferViews", json!({ "buffer": 1, "byteLength": count * stride, "extensions": extensions }))
    };
    let vertices = compressed(&vertices, "ATTRIBUTES", 4, 12);
    let triangles = compressed(&triangles, "TRIANGLES", 6, 2);
    asset.json["buffers"] =
        json!([{ "byteLength": 1000, "extensions": { "EXT_meshopt_compression": { "fallback": true } } }]);
    asset.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    let accessor = json!({ "bufferView": triangles, "componentType": U16, "count": 6, "type": "SCALAR" });
    let indices = asset.push("accessors", accessor);
    asset.primitive()["indices"] = json!(indices);
    let accessor = json!({ "bufferView": vertices, "componentType": F32, "count": 4, "type": "VEC3" });
    assert_square("meshopt", &placed(asset, accessor));
}

#[test]
fn draco_compression() {
    let mut mesh = Mesh::new();
    let mut attribute = PointAttribute::new();
    attribute.init(GeometryAttributeType::Position, 3, DataType::Float32, false, 4);
    attribute.buffer_mut().update_f32s_le(0, CORNERS.as_flattened());
    mesh.add_attribute(attribute);
    for triangle in [[0, 1, 2], [0, 2, 3]] {
        mesh.add_face(triangle.map(PointIndex));
    }
    let (mut bytes, mut encoder) = (EncoderBuffer::new(), MeshEncoder::new());
    encoder.set_mesh(mesh);
    encoder.encode(&EncoderOptions::new(), &mut bytes).expect("the square is encoded");

    let mut asset = Asset::square(glowing());
    let view = asset.view(bytes.data());
    let positions = asset.push("accessors", json!({ "componentType": F32, "count": 4, "type": "VEC3" }));
    let indices = asset.push("accessors", json!({ "componentType": U16, "count": 6, "type": "SCALAR" }));
    let draco = json!({ "bufferView": view, "attributes": { "POSITION": 0 } });
    let extensions = json!({ "KHR_draco_mesh_compression": draco });
    *asset.primitive() = json!({
        "attributes": { "POSITION": positions }, "indices": indices, "material": 0, "extensions": extensions,
    });
    assert_square("draco", &asset);
}
