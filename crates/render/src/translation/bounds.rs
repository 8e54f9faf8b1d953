//! Axis-aligned boxes around shapes.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use raggio_scene::{Geometry, Mesh, rotation};

use crate::translation::hierarchy::Bounds;

/// Lower and upper corner of a box that contains `geometry` with room for rounding; `None` if it has no bounds.
pub fn bounds(geometry: &Geometry) -> Option<(Vec3, Vec3)> {
    shape_bounds(geometry, mesh_bounds).map(|Bounds(lower, upper)| (lower, upper))
}

/// Box that contains `geometry` with room for rounding, by known bounds of meshes; `None` if it has no bounds.
pub(crate) fn shape_bounds(geometry: &Geometry, mesh_bounds: impl FnOnce(&Arc<Mesh>) -> Bounds) -> Option<Bounds> {
    let mut rounding = 8.0 * f64::from(f32::EPSILON);
    let (lower, upper) = match geometry {
        Geometry::Plane { .. } => return None,
        Geometry::Sphere { center, radius } => {
            let (center, radius) = (center.as_dvec3(), DVec3::splat(f64::from(*radius)));
            (center - radius, center + radius)
        }
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            let (a, u, v) = (corner.as_dvec3(), edge_u.as_dvec3(), edge_v.as_dvec3());
            let zero = DVec3::ZERO;
            (a + u.min(zero) + v.min(zero), a + u.max(zero) + v.max(zero))
        }
        Geometry::Disk { center, normal, radius } => {
            let reach = f64::from(*radius) * across(normal.as_dvec3());
            (center.as_dvec3() - reach, center.as_dvec3() + reach)
        }
        // The shape is the hull of its two circles.
        Geometry::Cylinder { base, top, radius, .. } => hull([(*base, *radius), (*top, *radius)]),
        Geometry::Cone { base, top, radius, top_radius, .. } => hull([(*base, *radius), (*top, *top_radius)]),
        Geometry::Box { center, size, rotation_degrees } => {
            let axes = rotation(*rotation_degrees);
            let half = size.as_dvec3() * 0.5;
            let reach = axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
            (center.as_dvec3() - reach, center.as_dvec3() + reach)
        }
        Geometry::Mesh { mesh, world_from_mesh, .. } => {
            let Bounds(lower, upper) = mesh_bounds(mesh);
            let center = world_from_mesh.transform_point3((lower.as_dvec3() + upper.as_dvec3()) * 0.5);
            let half = (upper.as_dvec3() - lower.as_dvec3()) * 0.5;
            let axes = world_from_mesh.matrix3;
            let reach = axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
            let scale = f64::from(instance_scale(Bounds(lower, upper), world_from_mesh));
            rounding = rounding.max(rounding * scale / (center.abs() + reach).max_element());
            (center - reach, center + reach)
        }
    };
    // Positions are rounded by the kernels in proportion to the largest number involved.
    let room = DVec3::splat(rounding * lower.abs().max(upper.abs()).max_element());
    Some(Bounds((lower - room).as_vec3(), (upper + room).as_vec3()))
}

/// Reach of a unit circle around the unit vector `axis` along x, y and z: the sine of the axis' angle with each, of the other
/// components, for one near 1 says nothing of it.
fn across(axis: DVec3) -> DVec3 {
    let [x, y, z] = axis.to_array();
    DVec3::new(y.hypot(z), z.hypot(x), x.hypot(y))
}

/// Box around two circles, each with its centre and its radius, around the axis between these.
fn hull(circles: [(Vec3, f32); 2]) -> (DVec3, DVec3) {
    let [base, top] = circles.map(|(center, _)| center.as_dvec3());
    let across = across((top - base).normalize());
    let boxes = circles.map(|(center, radius)| (center.as_dvec3(), f64::from(radius) * across));
    let [(a, b), (c, d)] = boxes.map(|(center, reach)| (center - reach, center + reach));
    (a.min(c), b.max(d))
}

/// Box around all vertices of `mesh` that a triangle uses.
pub(crate) fn mesh_bounds(mesh: &Arc<Mesh>) -> Bounds {
    let corners = mesh.triangles.iter().flatten().map(|&index| Vec3::from(mesh.positions[index as usize]));
    corners.fold(Bounds::EMPTY, |Bounds(lower, upper), p| Bounds(lower.min(p), upper.max(p)))
}

/// Scale of the rounding errors of an instance's points: the sum of the numbers that a coordinate is computed from,
/// times what a map and its inverse make of a rounding error between them.
pub(crate) fn instance_scale(Bounds(lower, upper): Bounds, world_from_mesh: &DAffine3) -> f32 {
    let farthest = lower.as_dvec3().abs().max(upper.as_dvec3().abs());
    let map = world_from_mesh.matrix3.abs();
    let sum = map * farthest + world_from_mesh.translation.abs();
    let both = map * world_from_mesh.matrix3.inverse().abs();
    // Turns alone come to less than 3.
    let stretch = ((both * DVec3::ONE).max_element() / 3.0).max(1.0);
    (sum.max_element() * stretch) as f32
}
