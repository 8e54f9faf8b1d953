//! Morph targets and skins, applied to a mesh at rest.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::asset::Asset;
use super::document::Skin;
use super::fault::at;
use super::mesh::RestMesh;
use super::stream::Stream;
use crate::error::Fault;
use crate::mesh::Mesh;

/// Moves vertices towards the morph targets.
pub(super) fn morph(asset: &Asset<'_>, rest: &mut RestMesh<'_>, weights: &[f32]) -> Result<(), Fault> {
    let RestMesh { mesh, streams } = rest;
    for stream in streams.iter() {
        for (i, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            move_stream(asset, mesh, stream, i, *weight)?;
        }
    }
    Ok(())
}

fn move_stream(asset: &Asset<'_>, mesh: &mut Mesh, stream: &Stream<'_>, i: usize, weight: f32) -> Result<(), Fault> {
    let path = format!("{}.targets[{i}]", stream.path);
    for (name, accessor) in &stream.targets[i] {
        let deltas = |asset: &Asset<'_>| {
            asset.floats_as_stored::<3>(*accessor, stream.used.as_deref(), &format!("{path}.{name}"))
        };
        match name.as_str() {
            "POSITION" => add(&mut mesh.positions[stream.first..], &deltas(asset)?, weight),
            "NORMAL" => add(rest_of(&mut mesh.normals, stream.first), &deltas(asset)?, weight),
            "TANGENT" => add(rest_of(&mut mesh.tangents, stream.first), &deltas(asset)?, weight),
            _ if name.starts_with('_') => {}
            _ => asset
                .warnings
                .push(format!("{path}: the attribute {} is not used", crate::text::quoted(name.as_bytes()))),
        }
    }
    Ok(())
}

fn rest_of<T>(list: &mut Option<Vec<T>>, first: usize) -> &mut [T] {
    list.as_mut().map_or(&mut [], |list| &mut list[first..])
}

/// Adds weighted deltas to vectors; the fourth component, the sign of tangents, stays.
fn add<const N: usize>(values: &mut [[f32; N]], deltas: &[[f32; 3]], weight: f32) {
    for (value, delta) in values.iter_mut().zip(deltas) {
        value.iter_mut().zip(delta).for_each(|(value, delta)| *value += weight * delta);
    }
}

/// Matrices by which joints take the vertices of a skin into the world.
pub(super) fn joint_matrices(asset: &Asset<'_>, skin: usize, worlds: &[DAffine3]) -> Result<Vec<DAffine3>, Fault> {
    let Skin { joints, inverse_bind_matrices } = &asset.document.skins[skin];
    let path = format!("skins[{skin}].inverseBindMatrices");
    let inverses = inverse_bind_matrices.map(|accessor| asset.floats_as_stored::<16>(accessor, None, &path));
    let inverses = inverses.transpose()?;
    asset.budget.take(joints.len(), size_of::<DAffine3>(), &path)?;
    let inverse =
        |i: usize| inverses.as_ref().map_or(DAffine3::IDENTITY, |inverses| affine(&inverses[i].map(f64::from)));
    Ok(joints.iter().enumerate().map(|(i, joint)| worlds[*joint] * inverse(i)).collect())
}

/// Affine map of a matrix in columns; its last row is taken to be 0 0 0 1.
pub(super) fn affine(m: &[f64; 16]) -> DAffine3 {
    DAffine3::from_cols_array(&[m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10], m[12], m[13], m[14]])
}

/// Takes a mesh into the world: each vertex by the mean of its joints' matrices, and by the `node`'s where it has none.
pub(super) fn skin(
    asset: &Asset<'_>,
    rest: &mut RestMesh<'_>,
    matrices: &[DAffine3],
    node: &DAffine3,
) -> Result<(), Fault> {
    let mut mirrored = vec![false; rest.mesh.positions.len()];
    for stream in &rest.streams {
        let blended = blend(asset, stream, matrices, node)?;
        for (vertex, matrix) in (stream.first..).zip(&blended) {
            mirrored[vertex] = matrix.matrix3.determinant() < 0.0;
            transform(&mut rest.mesh, vertex, matrix);
        }
    }
    // A mirror turns what was counter-clockwise round.
    for triangle in &mut rest.mesh.triangles {
        if mirrored[triangle[0] as usize] {
            triangle.swap(1, 2);
        }
    }
    Ok(())
}

/// The matrix of each vertex of a stream; weights that do not add up to one are scaled.
fn blend(
    asset: &Asset<'_>,
    stream: &Stream<'_>,
    matrices: &[DAffine3],
    node: &DAffine3,
) -> Result<Vec<DAffine3>, Fault> {
    let count = stream.vertices(asset);
    asset.budget.take(count, size_of::<(DAffine3, f64)>(), &stream.path)?;
    let mut sums = vec![(DAffine3::ZERO, 0.0); count];
    for set in 0.. {
        let weights = stream.floats::<4>(asset, &format!("WEIGHTS_{set}"))?;
        let joints = stream.integers(asset, &format!("JOINTS_{set}"))?;
        let (Some(weights), Some(joints)) = (weights, joints) else { break };
        for ((sum, weights), joints) in sums.iter_mut().zip(&weights).zip(&joints) {
            for (weight, joint) in weights.iter().zip(joints).filter(|(weight, _)| **weight > 0.0) {
                let matrix = matrices.get(*joint as usize).ok_or_else(|| {
                    let message = format!("names joint {joint}: the skin has {} joints", matrices.len());
                    at(format!("{}.attributes.JOINTS_{set}", stream.path), message)
                })?;
                let weight = f64::from(*weight);
                sum.0 = DAffine3 {
                    matrix3: sum.0.matrix3 + matrix.matrix3 * weight,
                    translation: sum.0.translation + matrix.translation * weight,
                };
                sum.1 += weight;
            }
        }
    }
    let mean = |(sum, weight): (DAffine3, f64)| match weight {
        0.0 => *node,
        _ => DAffine3 { matrix3: sum.matrix3 * weight.recip(), translation: sum.translation * weight.recip() },
    };
    Ok(sums.into_iter().map(mean).collect())
}

fn transform(mesh: &mut Mesh, vertex: usize, matrix: &DAffine3) {
    let linear = matrix.matrix3;
    let determinant = linear.determinant();
    let position = &mut mesh.positions[vertex];
    *position = matrix.transform_point3(DVec3::from(position.map(f64::from))).as_vec3().to_array();
    if let Some(normals) = &mut mesh.normals {
        let normal = cofactors(linear) * DVec3::from(normals[vertex].map(f64::from)) * determinant.signum();
        normals[vertex] = normal.normalize_or_zero().as_vec3().to_array();
    }
    if let Some(tangents) = &mut mesh.tangents {
        let [x, y, z, sign] = tangents[vertex];
        let tangent = (linear * Vec3::new(x, y, z).as_dvec3()).normalize_or_zero().as_vec3();
        tangents[vertex] = tangent.extend(sign * determinant.signum() as f32).to_array();
    }
}

/// Cofactors of a matrix: the inverse transposed times the determinant, which every matrix has.
fn cofactors(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}
