//! Axis-aligned boxes around shapes.

use glam::{DVec3, Vec3};
use raggio_scene::{Geometry, rotation};

/// Lower and upper corner of a box that contains `geometry` with room for rounding; `None` if it has no bounds.
pub fn bounds(geometry: &Geometry) -> Option<(Vec3, Vec3)> {
    let (lower, upper) = match *geometry {
        Geometry::Plane { .. } => return None,
        Geometry::Sphere { center, radius } => {
            let (center, radius) = (center.as_dvec3(), DVec3::splat(f64::from(radius)));
            (center - radius, center + radius)
        }
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            let (a, u, v) = (corner.as_dvec3(), edge_u.as_dvec3(), edge_v.as_dvec3());
            let zero = DVec3::ZERO;
            (a + u.min(zero) + v.min(zero), a + u.max(zero) + v.max(zero))
        }
        Geometry::Box { center, size, rotation_degrees } => {
            let axes = rotation(rotation_degrees);
            let half = size.as_dvec3() * 0.5;
            let reach = axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
            (center.as_dvec3() - reach, center.as_dvec3() + reach)
        }
    };
    // As the kernels round positions: in proportion to the largest number involved.
    let room = DVec3::splat(8.0 * f64::from(f32::EPSILON) * lower.abs().max(upper.abs()).max_element());
    Some(((lower - room).as_vec3(), (upper + room).as_vec3()))
}
