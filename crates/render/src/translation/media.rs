//! Media around the camera: the dielectric bodies that it is inside of.

use glam::{DAffine3, DVec3, Vec3};
use raggio_scene::{Geometry, Scene, Shape, rotation};

/// A dielectric body: the part of a shape that is of one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Body {
    /// Index of the shape.
    pub shape: u32,
    /// Index of the material.
    pub material: usize,
}

/// The dielectric bodies that contain the camera, outermost first: in the order in which one would enter them on the way
/// to the camera from behind it.
pub fn media_around(scene: &Scene) -> Vec<Body> {
    let eye = scene.camera.position.as_dvec3();
    let backward = (eye - scene.camera.look_at.as_dvec3()).normalize_or_zero();
    let mut bodies = vec![];
    for (shape, index) in scene.shapes.iter().zip(0..) {
        for material in materials(shape).into_iter().filter(|m| scene.materials[*m].is_dielectric()) {
            let distance = way_out(shape, material, eye, backward);
            bodies.extend(distance.map(|distance| (distance, Body { shape: index, material })));
        }
    }
    bodies.sort_by(|a, b| b.0.total_cmp(&a.0));
    bodies.into_iter().map(|(_, body)| body).collect()
}

/// Materials that a shape is made of, each once.
fn materials(shape: &Shape) -> Vec<usize> {
    let Geometry::Mesh { mesh, .. } = &shape.geometry else { return vec![shape.material] };
    let mut materials: Vec<_> = mesh.parts.iter().map(|part| shape.material_of(part)).collect();
    materials.sort_unstable();
    materials.dedup();
    materials
}

/// Distance from `point` along `direction` to where one leaves the body; `None` if `point` is outside.
fn way_out(shape: &Shape, material: usize, point: DVec3, direction: DVec3) -> Option<f64> {
    match &shape.geometry {
        Geometry::Sphere { center, radius } => {
            let f = point - center.as_dvec3();
            let room = f64::from(*radius).powi(2) - f.length_squared();
            let b = -f.dot(direction);
            (room > 0.0).then(|| b + (b * b + room).sqrt())
        }
        // A plane fills the half-space behind its normal.
        Geometry::Plane { point: on_plane, normal } => {
            let n = normal.as_dvec3();
            let below = n.dot(on_plane.as_dvec3() - point);
            let rise = n.dot(direction);
            (below > 0.0).then(|| if rise > 0.0 { below / rise } else { f64::INFINITY })
        }
        // A sheet has no inside.
        Geometry::Rectangle { .. } | Geometry::Disk { .. } => None,
        Geometry::Cylinder { base, top, radius, capped } => {
            way_out_of_cone([*base, *top], [*radius; 2], *capped, point, direction)
        }
        Geometry::Cone { base, top, radius, top_radius, capped } => {
            way_out_of_cone([*base, *top], [*radius, *top_radius], *capped, point, direction)
        }
        Geometry::Box { center, size, rotation_degrees } => {
            let box_from_world = rotation(*rotation_degrees).transpose();
            let local = box_from_world * (point - center.as_dvec3());
            let d = box_from_world * direction;
            let half = size.as_dvec3() * 0.5;
            let out = |x: f64, d: f64, h: f64| if d == 0.0 { f64::INFINITY } else { (h.copysign(d) - x) / d };
            let nearest = out(local.x, d.x, half.x).min(out(local.y, d.y, half.y)).min(out(local.z, d.z, half.z));
            local.abs().cmplt(half).all().then_some(nearest)
        }
        Geometry::Mesh { mesh, world_from_mesh, .. } => {
            let parts = mesh.parts.iter().filter(|part| shape.material_of(part) == material);
            let triangles = parts.flat_map(|part| &mesh.triangles[part.triangles.clone()]);
            way_out_of_mesh(&mesh.positions, triangles, world_from_mesh, point, direction)
        }
    }
}

/// Distance to where one leaves what lies between two circles around the axis between these centres, if disks close it.
fn way_out_of_cone(centers: [Vec3; 2], radii: [f32; 2], capped: bool, point: DVec3, direction: DVec3) -> Option<f64> {
    let [base, top] = centers.map(|center| center.as_dvec3());
    let [radius, top_radius] = radii.map(f64::from);
    let height = (top - base).length();
    let axis = (top - base) / height;
    let slope = (top_radius - radius) / height;
    let from = point - base;
    let (z, rise) = (from.dot(axis), direction.dot(axis));
    let (across, drift) = (from - z * axis, direction - rise * axis);
    let width = radius + slope * z;
    if !capped || z <= 0.0 || z >= height || across.length() >= width {
        return None;
    }
    let ends = if rise == 0.0 { f64::INFINITY } else { (if rise > 0.0 { height - z } else { -z }) / rise };
    // The side is where a t^2 + 2 b t + c = 0; inside c is negative, and the first root ahead is the way out.
    let growth = slope * rise;
    let a = drift.length_squared() - growth * growth;
    let b = drift.dot(across) - growth * width;
    let c = across.length_squared() - width * width;
    let root = (b * b - a * c).max(0.0).sqrt();
    let ahead = [(-b + root) / a, (-b - root) / a, -0.5 * c / b].into_iter().filter(|t| t.is_finite() && *t > 0.0);
    // Where a is not 0 the last of these is no root.
    let side = ahead.take(if a == 0.0 { 3 } else { 2 }).fold(f64::INFINITY, f64::min);
    Some(side.min(ends))
}

/// Distance to where one leaves a body of triangles, by the parity of the surfaces ahead: a closed mesh is left once
/// more than it is entered. The last of them counts.
fn way_out_of_mesh<'a>(
    positions: &[[f32; 3]],
    triangles: impl Iterator<Item = &'a [u32; 3]>,
    world_from_mesh: &DAffine3,
    point: DVec3,
    direction: DVec3,
) -> Option<f64> {
    let mesh_from_world = world_from_mesh.inverse();
    let origin = mesh_from_world.transform_point3(point);
    let direction = mesh_from_world.transform_vector3(direction);
    let vertex = |index: u32| glam::Vec3::from(positions[index as usize]).as_dvec3() - origin;
    let crossing = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(vertex);
        let [u, v, w] = [c.cross(b), a.cross(c), b.cross(a)].map(|edge| edge.dot(direction));
        let ahead = -a.dot((b - a).cross(c - a)) / (u + v + w);
        // Half open, so that a line through an edge of two triangles crosses one of them.
        let inside = (u >= 0.0) == (v >= 0.0) && (v >= 0.0) == (w >= 0.0);
        (inside && ahead > 0.0).then_some(ahead)
    };
    let crossings: Vec<f64> = triangles.filter_map(crossing).collect();
    (crossings.len() % 2 == 1).then(|| crossings.into_iter().fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use raggio_scene::{Material, Mesh, Part, Principled};

    use super::*;

    /// Two tetrahedra about the camera in one mesh: glass around stone.
    #[test]
    fn bodies_of_a_mesh_are_those_of_its_parts() {
        let corners = [[0.0, 0.0, 3.0], [3.0, 0.0, -1.0], [-2.0, 3.0, -1.0], [-2.0, -3.0, -1.0]];
        let positions =
            [1.0, 2.0].iter().flat_map(|size| corners.map(|corner| corner.map(|x: f32| x * size))).collect();
        let faces = |first: u32| [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].map(|face| face.map(|i: u32| i + first));
        let triangles = [faces(0), faces(4)].concat();
        let part = |material, triangles| Part { name: "".into(), material: Some(material), triangles };
        let mesh = Mesh { positions, triangles, parts: vec![part(0, 0..4), part(1, 4..8)], ..Mesh::default() };
        let principled = |transmission| Some(Arc::new(Principled { transmission, ..Principled::default() }));
        let material = |transmission| Material { principled: principled(transmission), ..Material::default() };
        let view = "version = 1\n[camera]\nposition = [0, 0, 0]\nlook_at = [0.1, 0.2, -1]\nvertical_fov_degrees = 40\n";
        let mut scene = Scene::parse(view, "test").expect("a scene");
        scene.materials = vec![material(1.0), material(0.0), material(1.0)];
        let geometry =
            Geometry::Mesh { mesh: Arc::new(mesh), world_from_mesh: DAffine3::IDENTITY, first_material: Some(1) };
        scene.shapes = vec![Shape { entry: 0, material: 0, geometry }];
        assert_eq!(media_around(&scene), [Body { shape: 0, material: 2 }]);
        scene.camera.position = Vec3::X * 20.0;
        assert_eq!(media_around(&scene), []);
    }
}
