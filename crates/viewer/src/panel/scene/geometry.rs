//! Where a shape is, and how large.

use egui::Ui;
use raggio_scene::{Geometry, Scene, Vec3};

use crate::command::{Command, Edit};
use crate::panel::controls::{number, row, step, table, vector};

/// Editor of one shape's numbers.
pub fn show(ui: &mut Ui, scene: &Scene, index: usize, commands: &mut Vec<Command>) {
    let shape = &scene.shapes[index];
    let mut geometry = shape.geometry.clone();
    ui.strong(super::shape_name(scene, index));
    table(ui, "geometry", |ui| match &mut geometry {
        Geometry::Sphere { center, radius } => {
            let speed = step(*radius);
            row(ui, "center", |ui| vector(ui, center, speed));
            row(ui, "radius", |ui| number(ui, radius, speed, 1e-6..=1e9));
        }
        Geometry::Plane { point, normal } => {
            row(ui, "point", |ui| vector(ui, point, 0.01));
            row(ui, "normal", |ui| vector(ui, normal, 0.01));
        }
        Geometry::Rectangle { corner, edge_u, edge_v } => {
            let speed = step(edge_u.length().max(edge_v.length()));
            row(ui, "corner", |ui| vector(ui, corner, speed));
            // The edges stay perpendicular: the one that is not changed gives way.
            if row(ui, "edge u", |ui| vector(ui, edge_u, speed)) {
                *edge_v = perpendicular(*edge_v, *edge_u);
            }
            if row(ui, "edge v", |ui| vector(ui, edge_v, speed)) {
                *edge_u = perpendicular(*edge_u, *edge_v);
            }
        }
        Geometry::Box { center, size, rotation_degrees } => {
            let speed = step(size.max_element());
            row(ui, "center", |ui| vector(ui, center, speed));
            if row(ui, "size", |ui| vector(ui, size, speed)) {
                *size = size.max(Vec3::splat(1e-6));
            }
            row(ui, "rotation", |ui| vector(ui, rotation_degrees, 0.5));
        }
    });
    if geometry != shape.geometry {
        commands.push(Command::Edit(Edit::Shape(index, geometry, shape.material)));
    }
}

/// `edge` turned to a right angle with `other`, its length kept; as it is where that cannot be.
fn perpendicular(edge: Vec3, other: Vec3) -> Vec3 {
    let (edge_64, other) = (edge.as_dvec3(), other.as_dvec3());
    let rest = edge_64 - other * (edge_64.dot(other) / other.length_squared());
    match rest.try_normalize() {
        Some(direction) => (direction * edge_64.length()).as_vec3(),
        None => edge,
    }
}
