//! KHR_draco_mesh_compression.

use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute};

use super::asset::Asset;
use super::document::Draco;
use super::fault::at;
use crate::error::Fault;

/// Decoded geometry of one primitive.
pub(super) struct Geometry {
    mesh: Mesh,
}

impl Geometry {
    pub(super) fn decode(asset: &Asset<'_>, draco: &Draco, path: &str) -> Result<Self, Fault> {
        let path = format!("{path}.extensions.KHR_draco_mesh_compression");
        let bytes = asset.view(draco.buffer_view, &path)?;
        // Corner tables take some tens of bytes for each face and point while they are decoded.
        let left = asset.budget.left();
        let limits = DecodeLimits::default();
        let limits = limits.with_max_points(left / 64).with_max_faces(left / 128).with_max_decoded_bytes(left / 4);
        let mut mesh = Mesh::new();
        let decoded = MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh);
        decoded.map_err(|error| at(&path, format!("the compressed data cannot be decoded: {error}")))?;
        asset.budget.take(mesh.num_points(), 64, &path)?;
        asset.budget.take(mesh.num_faces(), 128, &path)?;
        for (name, id) in &draco.attributes {
            if mesh.attribute_by_unique_id(*id).is_none() {
                return Err(at(format!("{path}.attributes.{name}"), format!("the data has no attribute of id {id}")));
            }
        }
        Ok(Self { mesh })
    }

    pub(super) fn vertices(&self) -> usize {
        self.mesh.num_points()
    }

    pub(super) fn triangles(&self) -> Vec<[u32; 3]> {
        self.mesh.faces().iter().map(|face| face.map(|point| point.0)).collect()
    }

    /// Number of components that the attribute has for each vertex.
    pub(super) fn width(&self, id: u32) -> usize {
        self.attribute(id).map_or(0, |attribute| usize::from(attribute.num_components()))
    }

    /// Vectors of the attribute, one for each vertex, as stored.
    pub(super) fn floats<const N: usize>(&self, id: u32) -> Vec<[f32; N]> {
        let values = self.attribute(id).map_or_else(Vec::new, |attribute| attribute.read_f32s(self.vertices(), N));
        values.as_chunks().0.to_vec()
    }

    fn attribute(&self, id: u32) -> Option<&PointAttribute> {
        self.mesh.attribute_by_unique_id(id)
    }
}
