//! Transforms of shapes and of groups.

use glam::{DAffine3, DMat3, DVec3, EulerRot, Vec3};

use super::shapes::below;
use super::{dvec3, vec3};
use crate::assets::can_be_undone;
use crate::fault::{Fault, Step, place, subject};
use crate::file::{Point, ScaleFile, TransformFile};
use crate::number::{LARGEST, SMALLEST};
use crate::scene::{Geometry, Transform, rotation};

/// Largest relative difference between factors that are one: those of a file are rounded, and so are angles.
const EQUAL: f64 = 1e-6;

/// A transform as the file has it, in 64 bits.
pub(super) fn transform(file: &TransformFile, at: &[Step]) -> Result<(Transform, DAffine3), Fault> {
    let scale = scale(file.scale, at)?;
    let (translation, rotation_degrees) = (vec3(file.translation), vec3(file.rotation_degrees));
    let map = map(file.translation, rotation_degrees, scale);
    Ok((Transform { translation, rotation_degrees, scale: scale.as_vec3() }, map))
}

/// Factors along the axes, none of which is 0.
pub(super) fn scale(file: Option<ScaleFile>, at: &[Step]) -> Result<DVec3, Fault> {
    let scale = match file {
        None => DVec3::ONE,
        Some(ScaleFile::Uniform(scale)) => DVec3::splat(scale.0),
        Some(ScaleFile::PerAxis(scale)) => dvec3(scale),
    };
    if scale.abs().min_element() < SMALLEST {
        let at = below(at, "scale");
        let message = format!("{} must not be 0: nothing would be left", subject(&at));
        return Err(Fault::value(at, message));
    }
    Ok(scale)
}

/// Map T + R S p.
pub(super) fn map(translation: Point, rotation_degrees: Vec3, scale: DVec3) -> DAffine3 {
    let matrix3 = rotation(rotation_degrees) * DMat3::from_diagonal(scale);
    DAffine3 { matrix3, translation: dvec3(translation) }
}

/// What becomes of `geometry`; `at` is the transform's place in the file.
pub(super) fn transformed(geometry: &Geometry, map: &DAffine3, at: &[Step]) -> Result<Geometry, Fault> {
    if *map == DAffine3::IDENTITY {
        return Ok(geometry.clone());
    }
    if let Geometry::Mesh { mesh, world_from_mesh, first_material } = geometry {
        let world_from_mesh = *map * *world_from_mesh;
        let (mesh, first_material) = (mesh.clone(), *first_material);
        let is_sound = can_be_undone(&world_from_mesh) && world_from_mesh.translation.abs().max_element() <= LARGEST;
        return is_sound.then_some(Geometry::Mesh { mesh, world_from_mesh, first_material }).ok_or_else(|| beyond(at));
    }
    let Some((turn, factor)) = similarity(map) else {
        let at = below(at, "scale");
        let kind = geometry.key();
        let message = format!(
            "{} must be one factor, greater than 0: a {kind} would not stay a {kind}; only meshes can be stretched and mirrored",
            subject(&at)
        );
        return Err(Fault::value(at, message));
    };
    let point = |p: Vec3| map.transform_point3(p.as_dvec3()).as_vec3();
    let unit = |n: Vec3| (turn * n.as_dvec3()).normalize().as_vec3();
    let length = |x: f32| (factor * f64::from(x)) as f32;
    let edge = |v: Vec3| map.transform_vector3(v.as_dvec3()).as_vec3();
    let placed = match *geometry {
        Geometry::Sphere { center, radius } => Geometry::Sphere { center: point(center), radius: length(radius) },
        Geometry::Plane { point: p, normal } => Geometry::Plane { point: point(p), normal: unit(normal) },
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            Geometry::Rectangle { corner: point(corner), edge_u: edge(edge_u), edge_v: edge(edge_v) }
        }
        Geometry::Disk { center, normal, radius } => {
            Geometry::Disk { center: point(center), normal: unit(normal), radius: length(radius) }
        }
        Geometry::Cylinder { base, top, radius, capped } => {
            Geometry::Cylinder { base: point(base), top: point(top), radius: length(radius), capped }
        }
        Geometry::Cone { base, top, radius, top_radius, capped } => {
            let (radius, top_radius) = (length(radius), length(top_radius));
            Geometry::Cone { base: point(base), top: point(top), radius, top_radius, capped }
        }
        Geometry::Box { center, size, rotation_degrees } => Geometry::Box {
            center: point(center),
            size: (factor * size.as_dvec3()).as_vec3(),
            rotation_degrees: degrees(turn * rotation(rotation_degrees)),
        },
        Geometry::Mesh { .. } => unreachable!("meshes have been placed"),
    };
    if is_in_range(&placed) { Ok(placed) } else { Err(beyond(at)) }
}

/// Turn and factor of a map that keeps the form of everything; `None` of any other.
fn similarity(map: &DAffine3) -> Option<(DMat3, f64)> {
    let lengths = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(DVec3::length);
    let factor = map.matrix3.determinant().cbrt();
    let turn = map.matrix3 * (1.0 / factor);
    let is_one = |x: f64, y: f64| (x - y).abs() <= EQUAL * y.abs();
    let is_turn = (turn.transpose() * turn).abs_diff_eq(DMat3::IDENTITY, EQUAL);
    (factor > 0.0 && is_turn && lengths.into_iter().all(|length| is_one(length, factor))).then_some((turn, factor))
}

/// Angles that make this turn, as [`rotation`] takes them.
fn degrees(turn: DMat3) -> Vec3 {
    let (z, y, x) = turn.to_euler(EulerRot::ZYX);
    DVec3::new(x, y, z).map(f64::to_degrees).as_vec3()
}

/// Whether 32-bit arithmetic can hold the shape.
fn is_in_range(geometry: &Geometry) -> bool {
    let point = |p: Vec3| p.is_finite() && f64::from(p.abs().max_element()) <= LARGEST;
    let length = |x: f32| (SMALLEST..=LARGEST).contains(&f64::from(x));
    let apart = |a: Vec3, b: Vec3| point(a) && point(b) && length(a.distance(b));
    match *geometry {
        Geometry::Sphere { center, radius } | Geometry::Disk { center, radius, .. } => point(center) && length(radius),
        Geometry::Plane { point: p, .. } => point(p),
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            point(corner) && length(edge_u.length()) && length(edge_v.length())
        }
        Geometry::Cylinder { base, top, radius, .. } | Geometry::Cone { base, top, radius, .. } => {
            apart(base, top) && length(radius)
        }
        Geometry::Box { center, size, .. } => point(center) && size.to_array().into_iter().all(length),
        Geometry::Mesh { .. } => true,
    }
}

fn beyond(at: &[Step]) -> Fault {
    let message =
        format!("what is placed {} is too large or too small: keep all of it within 1e15 of the origin", place(at));
    Fault::value(at.to_vec(), message)
}
