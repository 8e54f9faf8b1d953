//! Texture coordinates that belong to corners of faces, and colours that belong to faces: a vertex with several becomes
//! several.

use std::collections::hash_map::Entry;

use foldhash::HashMap;

use super::Polygons;
use crate::error::Fault;
use crate::mesh::Mesh;

/// Gives every different triple of vertex, texture coordinates and colour a vertex of its own. All indices have been
/// checked.
pub(super) fn split(polygons: &mut Polygons, mesh: &mut Mesh) -> Result<(), Fault> {
    let (mut uvs, mut colors) = (polygons.uvs.take(), polygons.colors.take());
    if uvs.is_none() && colors.is_none() {
        return Ok(());
    }
    // Strips, which have neither, may follow the faces.
    uvs.iter_mut().for_each(|uvs| uvs.resize(polygons.corners.len(), [0.0; 2]));
    colors.iter_mut().for_each(|colors| colors.resize(polygons.ends.len(), [1.0; 4]));
    let mut numbers = HashMap::default();
    let (mut sources, mut vertex_uvs, mut vertex_colors) = (Vec::new(), Vec::new(), Vec::new());
    let mut start = 0;
    for (face, end) in polygons.ends.iter().enumerate() {
        let color = colors.as_ref().map(|colors| colors[face]);
        for corner in start..*end {
            let uv = uvs.as_ref().map(|uvs| uvs[corner]);
            let source = polygons.corners[corner];
            let key = (source, uv.map(|uv| uv.map(f32::to_bits)), color.map(|color| color.map(f32::to_bits)));
            polygons.corners[corner] = match numbers.entry(key) {
                Entry::Occupied(entry) => *entry.get(),
                Entry::Vacant(entry) => {
                    let number = u32::try_from(sources.len());
                    sources.push(source);
                    vertex_uvs.extend(uv);
                    vertex_colors.extend(color);
                    *entry.insert(number.map_err(|_| Fault::whole("has more corners than a mesh can have vertices"))?)
                }
            };
        }
        start = *end;
    }
    gather(&mut mesh.positions, &sources);
    mesh.normals.iter_mut().for_each(|normals| gather(normals, &sources));
    mesh.colors.iter_mut().for_each(|colors| gather(colors, &sources));
    mesh.uvs.iter_mut().flatten().for_each(|uvs| gather(uvs, &sources));
    if uvs.is_some() {
        mesh.uvs[0] = Some(vertex_uvs);
    }
    if colors.is_some() {
        mesh.colors = Some(vertex_colors);
    }
    Ok(())
}

fn gather<T: Copy>(list: &mut Vec<T>, sources: &[u32]) {
    *list = sources.iter().map(|source| list[*source as usize]).collect();
}
