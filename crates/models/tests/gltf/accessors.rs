//! Accessors of every component type, with strides and with sparse elements.

use serde_json::json;

use crate::gltf::builder::{Builder, CORNERS, F32, I8, I16, U8, U16, U32};

/// Texture coordinates of the triangle's corners, from these bytes.
fn uvs(component: u32, normalized: bool, bytes: &[u8]) -> Vec<[f32; 2]> {
    let mut builder = Builder::triangle();
    let accessor = builder.accessor("VEC2", component, 3, bytes);
    builder.json["accessors"][accessor]["normalized"] = json!(normalized);
    builder.attribute("TEXCOORD_0", accessor);
    builder.mesh().uvs[0].clone().unwrap()
}

#[test]
fn component_types() {
    let unsigned = [0, 255, 51, 128, 1, 2];
    assert_eq!(uvs(U8, false, &unsigned), [[0.0, 255.0], [51.0, 128.0], [1.0, 2.0]]);
    assert_eq!(uvs(U8, true, &unsigned)[..2], [[0.0, 1.0], [0.2, 128.0 / 255.0]]);
    let signed = [0x80, 0x81, 127, 0, 255, 1];
    assert_eq!(uvs(I8, false, &signed), [[-128.0, -127.0], [127.0, 0.0], [-1.0, 1.0]]);
    assert_eq!(uvs(I8, true, &signed), [[-1.0, -1.0], [1.0, 0.0], [-1.0 / 127.0, 1.0 / 127.0]]);
    let words: Vec<u8> = [0u16, 65535, 13107, 1, 2, 3].iter().flat_map(|word| word.to_le_bytes()).collect();
    assert_eq!(uvs(U16, true, &words)[..2], [[0.0, 1.0], [0.2, 1.0 / 65535.0]]);
    let words: Vec<u8> = [-32768i16, 32767, -32767, 0, 2, 3].iter().flat_map(|word| word.to_le_bytes()).collect();
    assert_eq!(uvs(I16, true, &words)[..2], [[-1.0, 1.0], [-1.0, 0.0]]);
    assert_eq!(uvs(I16, false, &words)[0], [-32768.0, 32767.0]);
    let words: Vec<u8> = [7u32, 70000, 0, 0, 0, 0].iter().flat_map(|word| word.to_le_bytes()).collect();
    assert_eq!(uvs(U32, false, &words)[0], [7.0, 70000.0]);
}

#[test]
fn indices_of_every_type() {
    for (component, bytes) in
        [(U8, vec![0, 2, 1]), (U16, vec![0, 0, 2, 0, 1, 0]), (U32, vec![0, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0])]
    {
        let mut builder = Builder::triangle();
        let indices = builder.accessor("SCALAR", component, 3, &bytes);
        builder.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        assert_eq!(builder.mesh().triangles, [[0, 2, 1]]);
    }
    let mut builder = Builder::triangle();
    let indices = builder.accessor("SCALAR", I16, 3, &[0; 6]);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    assert!(builder.error().contains("meshes[0].primitives[0].indices: accessor 1 should have unsigned integers"));
}

#[test]
fn interleaved_vertices() {
    let mut builder = Builder::triangle();
    let mut bytes = Vec::new();
    for (i, corner) in CORNERS.iter().enumerate() {
        bytes.extend(corner.iter().flat_map(|x| (2.0 * x).to_le_bytes()));
        bytes.extend([i as u8, 7, 0, 0]);
    }
    let view = builder.view(&bytes);
    builder.json["bufferViews"][view]["byteStride"] = json!(16);
    let positions =
        builder.push("accessors", json!({ "bufferView": view, "componentType": F32, "count": 3, "type": "VEC3" }));
    let uv = json!({ "bufferView": view, "byteOffset": 12, "componentType": U8, "count": 3, "type": "VEC2" });
    let uv = builder.push("accessors", uv);
    builder.attribute("POSITION", positions).attribute("TEXCOORD_1", uv);
    let mesh = builder.mesh();
    assert_eq!(mesh.positions, CORNERS.map(|corner| corner.map(|x| 2.0 * x)));
    assert_eq!(mesh.uvs[1].as_deref(), Some(&[[0.0, 7.0], [1.0, 7.0], [2.0, 7.0]][..]));
}

/// Some programs write 0 where elements follow each other without gaps, and strides that glTF does not allow.
#[test]
fn odd_strides() {
    let mut builder = Builder::triangle();
    let indices = builder.indices(&[0, 2, 1]);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    for view in 0..2 {
        builder.json["bufferViews"][view]["byteStride"] = json!(0);
    }
    let mesh = builder.mesh();
    assert_eq!((mesh.positions.as_slice(), mesh.triangles.as_slice()), (&CORNERS[..], &[[0, 2, 1]][..]));
    let told = |view: usize| format!("bufferViews[{view}].byteStride is 0: the elements are read without gaps");
    assert_eq!(builder.load().warnings, [told(0), told(1)]);

    builder.json["bufferViews"][0].as_object_mut().unwrap().remove("byteStride");
    builder.json["bufferViews"][1]["byteStride"] = json!(2);
    assert_eq!(builder.mesh().triangles, [[0, 2, 1]]);
    let expected = "bufferViews[1].byteStride is 2: it should be a multiple of 4 up to 252, and is used as it is";
    assert_eq!(builder.warning(), expected);
}

fn make_sparse(builder: &mut Builder, accessor: usize, indices: &[u8], values: &[f32]) {
    let count = indices.len();
    let indices = builder.view(indices);
    let values = builder.view(&values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>());
    builder.json["accessors"][accessor]["sparse"] = json!({
        "count": count,
        "indices": { "bufferView": indices, "componentType": U8 },
        "values": { "bufferView": values },
    });
}

#[test]
fn sparse_elements_replace_others() {
    let mut builder = Builder::triangle();
    make_sparse(&mut builder, 0, &[0, 2], &[5.0, 6.0, 7.0, 8.0, 9.0, 1.0]);
    assert_eq!(builder.mesh().positions, [[5.0, 6.0, 7.0], CORNERS[1], [8.0, 9.0, 1.0]]);
}

#[test]
fn sparse_elements_replace_zeros() {
    let mut builder = Builder::triangle();
    let uv = builder.push("accessors", json!({ "componentType": F32, "count": 3, "type": "VEC2" }));
    builder.attribute("TEXCOORD_0", uv);
    assert_eq!(builder.mesh().uvs[0].as_deref(), Some(&[[0.0; 2]; 3][..]));
    make_sparse(&mut builder, uv, &[1], &[0.5, 0.25]);
    assert_eq!(builder.mesh().uvs[0].as_deref(), Some(&[[0.0, 0.0], [0.5, 0.25], [0.0, 0.0]][..]));
}

/// Sparse elements have to be found among the vertices in use, the only ones of many that are read.
#[test]
fn sparse_elements_of_vertices_in_use() {
    let mut builder = Builder::empty();
    let values: Vec<f32> = (0..300).map(|i| (i * i) as f32).collect();
    let positions = builder.floats("VEC3", &values);
    make_sparse(&mut builder, positions, &[3, 40, 90], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
    let indices = builder.indices(&[90, 7, 40]);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    builder.push("meshes", json!({ "primitives": [primitive] }));
    builder.push("nodes", json!({ "mesh": 0 }));
    let mesh = builder.mesh();
    assert_eq!(mesh.positions, [[441.0, 484.0, 529.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]);
    assert_eq!(mesh.triangles, [[2, 0, 1]]);
}

#[test]
fn sparse_indices_increase_and_stay_in_range() {
    for indices in [[2, 1], [1, 1], [0, 3]] {
        let mut builder = Builder::triangle();
        make_sparse(&mut builder, 0, &indices, &[0.0; 6]);
        let error = builder.error();
        assert!(error.contains("accessors[0].sparse.indices: index number 1 is"), "{error}");
        assert!(error.contains("the indices should increase and stay below 3"), "{error}");
    }
}
