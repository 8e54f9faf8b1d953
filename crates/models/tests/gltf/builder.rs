//! Small glTF files, made as tests need them.

use data_encoding::BASE64;
use raggio_images::Texels;
use raggio_models::{GltfOptions, Mesh, Model, ModelError, Texture, parse_gltf};
use serde_json::{Value, json};

/// A file under construction: its JSON, and its one buffer.
#[derive(Clone)]
pub struct Builder {
    pub json: Value,
    pub binary: Vec<u8>,
}

pub const U8: u32 = 5121;
pub const I8: u32 = 5120;
pub const U16: u32 = 5123;
pub const I16: u32 = 5122;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// Corners of a right triangle in the plane z = 0.
pub const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

pub fn no_files(name: &str, _: u64) -> Result<Vec<u8>, String> {
    Err(format!("is {name}, and there are no files"))
}

impl Builder {
    /// A builder of a file without nodes.
    pub fn empty() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), binary: Vec::new() }
    }

    /// A builder of a file with one node, which has one mesh of one triangle.
    pub fn triangle() -> Self {
        let mut builder = Self::empty();
        let positions = builder.floats("VEC3", CORNERS.as_flattened());
        builder.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
        builder.push("nodes", json!({ "mesh": 0 }));
        builder
    }

    /// A builder of a file with one triangle that has this material.
    pub fn with_material(material: Value) -> Self {
        let mut builder = Self::triangle();
        builder.push("materials", material);
        builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        builder
    }

    /// Adds to one of the document's lists; returns the number.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Adds a buffer view of these bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.binary.len().is_multiple_of(4) {
            self.binary.push(0);
        }
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        self.push("accessors", accessor)
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(kind, F32, values.len() / width, &bytes)
    }

    pub fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor("SCALAR", U16, values.len(), &bytes)
    }

    /// Adds an attribute to the only primitive.
    pub fn attribute(&mut self, name: &str, accessor: usize) -> &mut Self {
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
        self
    }

    /// The file as .gltf, with the buffer as a data URI.
    pub fn gltf(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].is_null() && !self.binary.is_empty() {
            let uri = format!("data:application/octet-stream;base64,{}", BASE64.encode(&self.binary));
            json["buffers"] = json!([{ "byteLength": self.binary.len(), "uri": uri }]);
        }
        json.to_string().into_bytes()
    }

    /// The file as .glb, with the buffer as GLB's own.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].is_null() {
            json["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        }
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let word = |number: usize| (number as u32).to_le_bytes();
        let length = 12 + 8 + json.len() + 8 + binary.len();
        let header = [&b"glTF"[..], &word(2), &word(length)].concat();
        let chunk = |kind: &[u8; 4], data: &[u8]| [&word(data.len()), kind, data].concat();
        [header, chunk(b"JSON", &json), chunk(b"BIN\0", &binary)].concat()
    }

    pub fn try_load(&self, options: &GltfOptions) -> Result<Model, ModelError> {
        parse_gltf(&self.gltf(), "a.gltf", &no_files, options)
    }

    pub fn load(&self) -> Model {
        self.try_load(&GltfOptions::default()).unwrap()
    }

    pub fn load_at(&self, seconds: f64) -> Model {
        self.try_load(&GltfOptions { time_seconds: Some(seconds), ..GltfOptions::default() }).unwrap()
    }

    /// Mesh of the model, which has only one.
    pub fn mesh(&self) -> Mesh {
        let model = self.load();
        assert_eq!(model.meshes.len(), 1);
        (*model.meshes[0]).clone()
    }

    /// Warning of the model, which has only one.
    pub fn warning(&self) -> String {
        let warnings = self.load().warnings;
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        warnings[0].clone()
    }

    pub fn error(&self) -> String {
        self.try_load(&GltfOptions::default()).unwrap_err().to_string()
    }
}

/// A PNG of one row.
pub fn png(texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_raw(texels.len() as u32, 1, texels.as_flattened().to_vec()).unwrap();
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// The texels of an image of 8 bits.
pub fn texels(texture: &Option<Texture>) -> Option<Vec<[u8; 4]>> {
    match &texture.as_ref()?.image.texels {
        Texels::Rgba8(texels) => Some(texels.clone()),
        _ => panic!("the image should have 8 bits"),
    }
}

pub fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let close = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-6);
    assert!(close, "{found:?} should be {expected:?}");
}
