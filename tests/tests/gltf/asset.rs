//! A glTF file under construction.

use data_encoding::BASE64;
use serde_json::{Value, json};

pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const F32: u32 = 5126;

/// Corners of the square of side 1 around the origin, facing +Z: bottom left, bottom right, top right, top left.
pub const CORNERS: [[f32; 3]; 4] = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]];
/// Image coordinates of the [`CORNERS`]: the image stands upright on the square.
pub const UPRIGHT: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

/// JSON of the file, and its one buffer.
#[derive(Clone)]
pub struct Asset {
    pub json: Value,
    binary: Vec<u8>,
}

impl Asset {
    /// Makes a file without nodes.
    pub fn empty() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), binary: vec![] }
    }

    /// Makes a square of `material`, as mesh 0 of node 0.
    pub fn square(material: Value) -> Self {
        Self::surface(&CORNERS, &[0, 1, 2, 0, 2, 3], material).with("TEXCOORD_0", "VEC2", UPRIGHT.as_flattened())
    }

    /// Makes a cube of side 1 around the origin, closed and flat.
    pub fn cube(material: Value) -> Self {
        let corners: Vec<[f32; 3]> =
            (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5 } else { -0.5 })).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = faces.map(|[a, b, c, d]| [a, b, c, a, c, d]);
        Self::surface(&corners, triangles.as_flattened(), material)
    }

    fn surface(corners: &[[f32; 3]], indices: &[u16], material: Value) -> Self {
        let mut asset = Self::empty();
        let positions = asset.floats("VEC3", corners.as_flattened());
        let indices = asset.indices(indices);
        let attributes = json!({ "POSITION": positions });
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": 0 });
        asset.push("meshes", json!({ "primitives": [primitive] }));
        asset.push("nodes", json!({ "mesh": 0 }));
        asset.push("materials", material);
        asset
    }

    /// Gives the mesh another attribute.
    pub fn with(mut self, name: &str, kind: &str, values: &[f32]) -> Self {
        let accessor = self.floats(kind, values);
        self.primitive()["attributes"][name] = json!(accessor);
        self
    }

    /// Puts other nodes in place of the file's.
    pub fn nodes(mut self, nodes: Value) -> Self {
        self.json["nodes"] = nodes;
        self
    }

    /// Adds an image of texels in rows as texture 0; `sampler` says how it lies.
    pub fn texture(mut self, rows: &[&[[u8; 4]]], sampler: Value) -> Self {
        let uri = format!("data:image/png;base64,{}", BASE64.encode(&png(rows)));
        let image = self.push("images", json!({ "uri": uri }));
        let sampler = self.push("samplers", sampler);
        self.push("textures", json!({ "source": image, "sampler": sampler }));
        self
    }

    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Adds a value to one of the document's lists; returns its number.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("it is a list");
        list.push(value);
        list.len() - 1
    }

    /// Adds a buffer view of these bytes; returns its number.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|k| *k == kind).map_or(16, |i| i + 1);
        let view = self.view(&values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>());
        let count = values.len() / width;
        self.push("accessors", json!({ "bufferView": view, "componentType": F32, "count": count, "type": kind }))
    }

    pub fn indices(&mut self, values: &[u16]) -> usize {
        let view = self.view(&values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>());
        let count = values.len();
        self.push("accessors", json!({ "bufferView": view, "componentType": U16, "count": count, "type": "SCALAR" }))
    }

    /// Bytes of the file, the buffer as a data URI.
    pub fn bytes(&self) -> Vec<u8> {
        let uri = format!("data:application/octet-stream;base64,{}", BASE64.encode(&self.binary));
        let mut json = self.json.clone();
        let buffer = json!({ "byteLength": self.binary.len(), "uri": uri });
        match json["buffers"].as_array_mut() {
            Some(others) => others.insert(0, buffer),
            None => json["buffers"] = json!([buffer]),
        }
        json.to_string().into_bytes()
    }
}

/// PNG of texels in rows, from the top.
pub fn png(rows: &[&[[u8; 4]]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(vec![]);
    let (width, height) = (rows[0].len() as u32, rows.len() as u32);
    let image = image::RgbaImage::from_raw(width, height, rows.concat().concat()).expect("rows are equally long");
    image.write_to(&mut bytes, image::ImageFormat::Png).expect("memory holds it");
    bytes.into_inner()
}

/// Material that reflects `color` evenly to all sides, and nothing else.
pub fn matte(color: [f32; 3]) -> Value {
    let [red, green, blue] = color;
    json!({
        "pbrMetallicRoughness": { "baseColorFactor": [red, green, blue, 1], "metallicFactor": 0 },
        "extensions": { "KHR_materials_specular": { "specularFactor": 0 } },
    })
}

/// Material that shines with radiance 1 and reflects nothing.
pub fn glowing() -> Value {
    merged(matte([0.0; 3]), json!({ "emissiveFactor": [1, 1, 1] }))
}

/// Merges `more` into `base`, level by level; where both have a value, that of `more` counts.
pub fn merged(mut base: Value, more: Value) -> Value {
    match (&mut base, more) {
        (Value::Object(base), Value::Object(more)) => {
            for (key, value) in more {
                let old = base.remove(&key).unwrap_or(Value::Null);
                base.insert(key, merged(old, value));
            }
        }
        (base, more) => *base = more,
    }
    base
}
