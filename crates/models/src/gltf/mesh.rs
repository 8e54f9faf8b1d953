//! A glTF mesh at rest: its primitives become the parts of one mesh.

use std::collections::HashMap;
use std::sync::Arc;

use super::asset::Asset;
use super::document::{Mode, Primitive};
use super::fault::at;
use super::stream::Stream;
use crate::error::Fault;
use crate::mesh::{Mesh, Part};

/// A mesh that is not cleaned yet, with the sources of its vertices.
pub(super) struct RestMesh<'a> {
    pub mesh: Mesh,
    pub streams: Vec<Stream<'a>>,
}

/// A primitive of triangles.
struct Piece {
    material: Option<usize>,
    /// Index into the streams.
    stream: usize,
    triangles: Vec<[u32; 3]>,
}

impl<'a> RestMesh<'a> {
    pub(super) fn load(asset: &'a Asset<'_>, number: usize) -> Result<Self, Fault> {
        let mut streams = Vec::new();
        let mut pieces = Vec::new();
        let mut shared = HashMap::new();
        for (i, primitive) in asset.document.meshes[number].primitives.iter().enumerate() {
            let path = format!("meshes[{number}].primitives[{i}]");
            if is_left_out(asset, primitive, &path) {
                continue;
            }
            warn_of_attributes(asset, primitive, &path);
            let key = Stream::key(primitive);
            let stream = key.and_then(|key| shared.get(&key).copied()).unwrap_or(streams.len());
            if stream == streams.len() {
                streams.push(Stream::new(asset, primitive, path.clone())?);
                key.map(|key| shared.insert(key, stream));
            }
            let triangles = triangles(asset, primitive, &streams[stream], &path)?;
            pieces.push(Piece { material: primitive.material, stream, triangles });
        }
        let mut rest = Self { mesh: Mesh::default(), streams };
        rest.add_vertices(asset, &pieces)?;
        rest.add_triangles(asset, number, &pieces)?;
        Ok(rest)
    }

    fn add_vertices(&mut self, asset: &Asset<'_>, pieces: &[Piece]) -> Result<(), Fault> {
        let mesh = &mut self.mesh;
        let mut triangles: Vec<Vec<&[[u32; 3]]>> = vec![Vec::new(); self.streams.len()];
        pieces.iter().for_each(|piece| triangles[piece.stream].push(&piece.triangles));
        for (stream, triangles) in self.streams.iter_mut().zip(&triangles) {
            stream.keep_used(asset, triangles);
            stream.first = mesh.positions.len();
            let (first, count) = (stream.first, stream.vertices(asset));
            mesh.positions.extend(stream.floats::<3>(asset, "POSITION")?.unwrap_or_default());
            let normals = stream.floats::<3>(asset, "NORMAL")?;
            // glTF has them ignored where there are no normals.
            let tangents = normals.as_ref().map(|_| stream.floats::<4>(asset, "TANGENT")).transpose()?.flatten();
            append(&mut mesh.normals, normals, first, count, [0.0; 3]);
            append(&mut mesh.tangents, tangents, first, count, [0.0; 4]);
            append(&mut mesh.uvs[0], stream.floats(asset, "TEXCOORD_0")?, first, count, [0.0; 2]);
            append(&mut mesh.uvs[1], stream.floats(asset, "TEXCOORD_1")?, first, count, [0.0; 2]);
            append(&mut mesh.colors, colors(asset, stream)?, first, count, [1.0; 4]);
        }
        Ok(())
    }

    fn add_triangles(&mut self, asset: &Asset<'_>, number: usize, pieces: &[Piece]) -> Result<(), Fault> {
        let name: Arc<str> = asset.document.meshes[number].name.as_str().into();
        let path = || format!("meshes[{number}]");
        if u32::try_from(self.mesh.positions.len()).is_err() {
            return Err(at(path(), format!("has more than {} vertices, the most that a mesh may have", u32::MAX)));
        }
        for piece in pieces {
            let start = self.mesh.triangles.len();
            let stream = &self.streams[piece.stream];
            asset.budget.take(piece.triangles.len(), size_of::<[u32; 3]>(), path())?;
            let renumbered = piece.triangles.iter().map(|triangle| triangle.map(|v| stream.renumbered(v) as u32));
            self.mesh.triangles.extend(renumbered);
            let triangles = start..self.mesh.triangles.len();
            self.mesh.parts.push(Part { name: name.clone(), material: piece.material, triangles });
        }
        Ok(())
    }
}

fn is_left_out(asset: &Asset<'_>, primitive: &Primitive, path: &str) -> bool {
    let reason = if primitive.mode == Mode::PointsOrLines {
        "points and lines have no surface"
    } else if !primitive.attributes.contains_key("POSITION") {
        "it has no positions"
    } else {
        return false;
    };
    asset.warnings.push(format!("{path} is left out: {reason}"));
    true
}

/// Warns of attributes that are not used, except those of applications, which begin with an underscore.
fn warn_of_attributes(asset: &Asset<'_>, primitive: &Primitive, path: &str) {
    let used = ["POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"];
    let is_used = |name: &str| used.contains(&name) || ["JOINTS_", "WEIGHTS_", "_"].iter().any(|p| name.starts_with(p));
    for name in primitive.attributes.keys().filter(|name| !is_used(name)) {
        let name = crate::text::quoted(name.as_bytes());
        asset.warnings.push(format!("{path}: the attribute {name} is not used"));
    }
}

/// Appends a stream's values of an attribute to the list; `neutral` fills in for streams that lack it.
fn append<T: Copy>(list: &mut Option<Vec<T>>, added: Option<Vec<T>>, before: usize, count: usize, neutral: T) {
    if list.is_none() && added.is_none() {
        return;
    }
    let list = list.get_or_insert_with(|| vec![neutral; before]);
    list.extend(added.unwrap_or_default());
    list.resize(before + count, neutral);
}

fn colors(asset: &Asset<'_>, stream: &Stream<'_>) -> Result<Option<Vec<[f32; 4]>>, Fault> {
    if stream.width(asset, "COLOR_0") == 3 {
        let colors = stream.floats::<3>(asset, "COLOR_0")?;
        return Ok(colors.map(|colors| colors.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect()));
    }
    stream.floats::<4>(asset, "COLOR_0")
}

fn triangles(
    asset: &Asset<'_>,
    primitive: &Primitive,
    stream: &Stream<'_>,
    path: &str,
) -> Result<Vec<[u32; 3]>, Fault> {
    let vertices = stream.source_vertices(asset);
    if let Some(triangles) = stream.compressed_triangles() {
        check_indices(triangles.as_flattened(), vertices, path)?;
        return Ok(triangles);
    }
    let indices: Vec<u32> = match primitive.indices {
        Some(accessor) => {
            let path = format!("{path}.indices");
            let indices =
                asset.integers::<1>(accessor, None, &path)?.into_iter().map(|[index]| index).collect::<Vec<_>>();
            check_indices(&indices, vertices, &path)?;
            indices
        }
        None => {
            asset.budget.take(vertices, size_of::<u32>(), path)?;
            (0..vertices as u32).collect()
        }
    };
    asset.budget.take(indices.len(), size_of::<[u32; 3]>(), path)?;
    let is_odd = primitive.mode == Mode::Triangles && !indices.len().is_multiple_of(3);
    if is_odd || indices.len() < 3 {
        let count = indices.len();
        asset.warnings.push(format!("{path}: {count} corners do not make up whole triangles; the rest is left out"));
    }
    Ok(assembled(primitive.mode, &indices))
}

fn check_indices(indices: &[u32], vertices: usize, path: &str) -> Result<(), Fault> {
    let Some(number) = indices.iter().position(|index| *index as usize >= vertices) else { return Ok(()) };
    let index = indices[number];
    Err(at(path, format!("index number {number} is {index}: with {vertices} vertices it should be below {vertices}")))
}

fn assembled(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::PointsOrLines => Vec::new(),
        Mode::Triangles => indices.as_chunks().0.to_vec(),
        // Every other triangle is turned round, so that all face one side.
        Mode::Strip => {
            let turned = |(i, three): (usize, &[u32])| [three[0], three[1 + i % 2], three[2 - i % 2]];
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::Fan => {
            let rim = indices.get(1..).unwrap_or_default();
            rim.windows(2).map(|pair| [pair[0], pair[1], indices[0]]).collect()
        }
    }
}
