//! Boxes around many shapes.

use std::collections::HashMap;
use std::sync::Arc;

use raggio_render::bounds;
use raggio_scene::{DAffine3, Geometry, Mesh, Shape, Vec3};

type Corners = (Vec3, Vec3);

/// Lower and upper corner of a box around all of the shapes that have bounds; `None` if none has. Each mesh is looked
/// at once, however many of the shapes show it.
pub fn extent(shapes: &[Shape]) -> Option<Corners> {
    let mut meshes = HashMap::new();
    let boxes = shapes.iter().filter_map(|shape| match &shape.geometry {
        Geometry::Mesh { mesh, world_from_mesh, .. } => {
            let own = *meshes.entry(Arc::as_ptr(mesh)).or_insert_with(|| in_its_own_space(mesh));
            own.map(|corners| transformed(corners, world_from_mesh))
        }
        other => bounds(other),
    });
    boxes.reduce(|(low, high), (a, b)| (low.min(a), high.max(b)))
}

fn in_its_own_space(mesh: &Arc<Mesh>) -> Option<Corners> {
    let mesh = mesh.clone();
    bounds(&Geometry::Mesh { mesh, world_from_mesh: DAffine3::IDENTITY, first_material: None })
}

fn transformed((low, high): Corners, map: &DAffine3) -> Corners {
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let center = map.transform_point3(0.5 * (low + high));
    let half = 0.5 * (high - low);
    let axes = map.matrix3;
    let reach = axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
    ((center - reach).as_vec3(), (center + reach).as_vec3())
}
