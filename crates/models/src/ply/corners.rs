//! Texture coordinates that belong to corners of faces: a vertex with several becomes several.

use std::collections::hash_map::Entry;

use foldhash::HashMap;

use super::Polygons;
use crate::error::Fault;
use crate::mesh::Mesh;

/// Gives every different pair of vertex and texture coordinates a vertex of its own. All indices have been checked.
pub(super) fn split(polygons: &mut Polygons, mesh: &mut Mesh) -> Result<(), Fault> {
    let Some(mut uvs) = polygons.uvs.take() else { return Ok(()) };
    // Strips, which have no coordinates, may follow the faces.
    uvs.resize(polygons.corners.len(), [0.0; 2]);
    let mut numbers = HashMap::default();
    let (mut sources, mut vertex_uvs) = (Vec::new(), Vec::new());
    for (corner, uv) in polygons.corners.iter_mut().zip(uvs) {
        let source = *corner;
        *corner = match numbers.entry((source, uv.map(f32::to_bits))) {
            Entry::Occupied(entry) => *entry.get(),
            Entry::Vacant(entry) => {
                let number = u32::try_from(sources.len());
                sources.push(source);
                vertex_uvs.push(uv);
                *entry.insert(number.map_err(|_| Fault::whole("has more corners than a mesh can have vertices"))?)
            }
        };
    }
    gather(&mut mesh.positions, &sources);
    mesh.normals.iter_mut().for_each(|normals| gather(normals, &sources));
    mesh.colors.iter_mut().for_each(|colors| gather(colors, &sources));
    mesh.uvs[1].iter_mut().for_each(|uvs| gather(uvs, &sources));
    mesh.uvs[0] = Some(vertex_uvs);
    Ok(())
}

fn gather<T: Copy>(list: &mut Vec<T>, sources: &[u32]) {
    *list = sources.iter().map(|source| list[*source as usize]).collect();
}
