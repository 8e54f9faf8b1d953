//! Shapes, each in the list of its kind.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use raggio_kernels::{
    Box as DeviceBox, Instance, NONE, Plane, Rectangle, Round, SceneBuffers, ShapeKind, ShapeReference, Sphere,
};
use raggio_scene::{Geometry, Material, Shape, axes_around, rotation};

use super::materials::has_holes;
use crate::translation::bounds::instance_scale;
use crate::translation::meshes::Meshes;

/// Lists of shapes, one for each kind.
#[derive(Default)]
pub(super) struct Shapes<'a> {
    materials: &'a [Material],
    spheres: Vec<Sphere>,
    planes: Vec<Plane>,
    rectangles: Vec<Rectangle>,
    boxes: Vec<DeviceBox>,
    rounds: Vec<Round>,
    instances: Vec<Instance>,
}

impl<'a> Shapes<'a> {
    /// Empty lists, for shapes that are made of `materials`.
    pub fn new(materials: &'a [Material]) -> Self {
        Self { materials, ..Self::default() }
    }

    /// Appends `shape`, whose mesh, if it is one, is among `meshes`.
    pub fn add(&mut self, shape: &Shape, meshes: &Meshes) -> ShapeReference {
        let holes = |material: usize| u32::from(has_holes(&self.materials[material]));
        let reference = |kind: ShapeKind, index: u32| ShapeReference {
            kind: kind as u32,
            index,
            has_holes: holes(shape.material),
            ..ShapeReference::default()
        };
        let material = shape.material as u32;
        match &shape.geometry {
            Geometry::Sphere { center, radius } => {
                let sphere = Sphere { center: center.to_array(), radius: *radius, material };
                reference(ShapeKind::Sphere, push(&mut self.spheres, sphere))
            }
            Geometry::Plane { point, normal } => {
                let plane = Plane { point: point.to_array(), normal: normal.to_array(), material };
                reference(ShapeKind::Plane, push(&mut self.planes, plane))
            }
            Geometry::Rectangle { corner, edge_u, edge_v } => {
                let normal = edge_u.as_dvec3().cross(edge_v.as_dvec3()).normalize().as_vec3();
                let [corner, edge_u, edge_v, normal] = [*corner, *edge_u, *edge_v, normal].map(|v: Vec3| v.to_array());
                let rectangle = Rectangle { corner, edge_u, edge_v, normal, material };
                reference(ShapeKind::Rectangle, push(&mut self.rectangles, rectangle))
            }
            Geometry::Box { center, size, rotation_degrees } => {
                let axes = rotation(*rotation_degrees);
                let [axis_x, axis_y, axis_z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|a| a.as_vec3().to_array());
                let half_size = (*size * 0.5).to_array();
                let center = center.to_array();
                let cuboid = DeviceBox { center, half_size, axis_x, axis_y, axis_z, material };
                reference(ShapeKind::Box, push(&mut self.boxes, cuboid))
            }
            Geometry::Disk { center, normal, radius } => {
                let disk = round(*center, normal.as_dvec3(), [*radius; 2], 0.0);
                let disk = Round { capped: 1, material, ..disk };
                reference(ShapeKind::Round, push(&mut self.rounds, disk))
            }
            Geometry::Cylinder { base, top, radius, capped } => {
                let cylinder = between(*base, *top, [*radius; 2]);
                let cylinder = Round { capped: u32::from(*capped), material, ..cylinder };
                reference(ShapeKind::Round, push(&mut self.rounds, cylinder))
            }
            Geometry::Cone { base, top, radius, top_radius, capped } => {
                let cone = between(*base, *top, [*radius, *top_radius]);
                let cone = Round { capped: u32::from(*capped), material, ..cone };
                reference(ShapeKind::Round, push(&mut self.rounds, cone))
            }
            Geometry::Mesh { mesh, world_from_mesh, first_material } => {
                let place = meshes.place(mesh).unwrap_or_default();
                let instance = Instance {
                    world_from_mesh: rows(world_from_mesh),
                    mesh_from_world: rows(&world_from_mesh.inverse()),
                    mesh: place as u32,
                    material,
                    first_material: first_material.map_or(NONE, |first| first as u32),
                    has_holes: mesh.parts.iter().map(|part| holes(shape.material_of(part))).max().unwrap_or(0),
                    scale: instance_scale(meshes.bounds(place), world_from_mesh),
                    handedness: if world_from_mesh.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 },
                };
                reference(ShapeKind::Instance, push(&mut self.instances, instance))
            }
        }
    }

    /// Puts the lists among those of a scene.
    pub fn share(self, buffers: &mut SceneBuffers) {
        buffers.spheres = self.spheres.into();
        buffers.planes = self.planes.into();
        buffers.rectangles = self.rectangles.into();
        buffers.boxes = self.boxes.into();
        buffers.rounds = self.rounds.into();
        buffers.instances = self.instances.into();
    }
}

/// Appends `shape`, and returns its index.
fn push<T>(list: &mut Vec<T>, shape: T) -> u32 {
    list.push(shape);
    list.len() as u32 - 1
}

/// Shape between circles of these radii around two points.
fn between(base: Vec3, top: Vec3, radii: [f32; 2]) -> Round {
    let way = top.as_dvec3() - base.as_dvec3();
    round(base, way.normalize(), radii, way.length())
}

/// Shape between circles of these radii, the first around `base`, the second `height` along the unit vector `axis`.
fn round(base: Vec3, axis: DVec3, radii: [f32; 2], height: f64) -> Round {
    let [radius, top_radius] = radii;
    let slope = if height > 0.0 { (f64::from(top_radius) - f64::from(radius)) / height } else { 0.0 };
    let [axis_x, axis_y, axis_z] = axes_around(axis).map(|axis| axis.as_vec3().to_array());
    let (base, height, slope) = (base.to_array(), height as f32, slope as f32);
    Round { base, radius, axis_x, axis_y, axis_z, height, top_radius, slope, ..Round::default() }
}

fn rows(map: &DAffine3) -> [[f32; 4]; 3] {
    let DMat3 { x_axis, y_axis, z_axis } = map.matrix3;
    let row =
        |axis: fn(DVec3) -> f64| [axis(x_axis), axis(y_axis), axis(z_axis), axis(map.translation)].map(|x| x as f32);
    [row(|v| v.x), row(|v| v.y), row(|v| v.z)]
}
