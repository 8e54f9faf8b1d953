//! What the camera is inside of.

use glam::{DAffine3, DVec3};
use raggio_scene::{Geometry, Mesh, Scene, rotation};

/// The dielectric bodies that contain the camera, as indices of shapes, outermost first: in the order in which one would
/// enter them on the way to the camera from behind it.
pub fn media_around(scene: &Scene) -> Vec<u32> {
    let eye = scene.camera.position.as_dvec3();
    let backward = (eye - scene.camera.look_at.as_dvec3()).normalize_or_zero();
    let mut bodies: Vec<(f64, u32)> = scene
        .shapes
        .iter()
        .zip(0..)
        .filter(|(shape, _)| scene.materials[shape.material].is_dielectric())
        .filter_map(|(shape, index)| Some((way_out(&shape.geometry, eye, backward)?, index)))
        .collect();
    bodies.sort_by(|a, b| b.0.total_cmp(&a.0));
    bodies.into_iter().map(|(_, shape)| shape).collect()
}

/// Distance from `point` along `direction` to where one leaves the body; `None` if `point` is outside.
fn way_out(geometry: &Geometry, point: DVec3, direction: DVec3) -> Option<f64> {
    match geometry {
        Geometry::Sphere { center, radius } => {
            let f = point - center.as_dvec3();
            let room = f64::from(*radius).powi(2) - f.length_squared();
            let b = -f.dot(direction);
            (room > 0.0).then(|| b + (b * b + room).sqrt())
        }
        // The half-space behind its normal.
        Geometry::Plane { point: on_plane, normal } => {
            let n = normal.as_dvec3();
            let below = n.dot(on_plane.as_dvec3() - point);
            let rise = n.dot(direction);
            (below > 0.0).then(|| if rise > 0.0 { below / rise } else { f64::INFINITY })
        }
        // A sheet has no inside.
        Geometry::Rectangle { .. } => None,
        Geometry::Box { center, size, rotation_degrees } => {
            let box_from_world = rotation(*rotation_degrees).transpose();
            let local = box_from_world * (point - center.as_dvec3());
            let d = box_from_world * direction;
            let half = size.as_dvec3() * 0.5;
            let out = |x: f64, d: f64, h: f64| if d == 0.0 { f64::INFINITY } else { (h.copysign(d) - x) / d };
            let nearest = out(local.x, d.x, half.x).min(out(local.y, d.y, half.y)).min(out(local.z, d.z, half.z));
            local.abs().cmplt(half).all().then_some(nearest)
        }
        Geometry::Mesh { mesh, world_from_mesh, .. } => way_out_of_mesh(mesh, world_from_mesh, point, direction),
    }
}

/// By the parity of the surfaces ahead: a closed mesh is left once more than it is entered. The last of them counts.
fn way_out_of_mesh(mesh: &Mesh, world_from_mesh: &DAffine3, point: DVec3, direction: DVec3) -> Option<f64> {
    let mesh_from_world = world_from_mesh.inverse();
    let origin = mesh_from_world.transform_point3(point);
    let direction = mesh_from_world.transform_vector3(direction);
    let vertex = |index: u32| glam::Vec3::from(mesh.positions[index as usize]).as_dvec3() - origin;
    let crossing = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(vertex);
        let [u, v, w] = [c.cross(b), a.cross(c), b.cross(a)].map(|edge| edge.dot(direction));
        let ahead = -a.dot((b - a).cross(c - a)) / (u + v + w);
        // Half open, so that a line through an edge of two triangles crosses one of them.
        let inside = (u >= 0.0) == (v >= 0.0) && (v >= 0.0) == (w >= 0.0);
        (inside && ahead > 0.0).then_some(ahead)
    };
    let crossings: Vec<f64> = mesh.triangles.iter().filter_map(crossing).collect();
    (crossings.len() % 2 == 1).then(|| crossings.into_iter().fold(0.0, f64::max))
}
