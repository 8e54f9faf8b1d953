//! Editor of a shape's place and size.

use egui::Ui;
use raggio_scene::{Geometry, Placement, Scene, Vec3};

use crate::command::{Command, Edit};
use crate::panel::controls::{number, row, step, table, vector};

/// Editor of one shape's numbers.
pub fn show(ui: &mut Ui, scene: &Scene, index: usize, commands: &mut Vec<Command>) {
    ui.strong(super::shape_name(scene, index));
    let entry = &scene.entries[index];
    if let Some(placement) = &entry.placement {
        return self::placement(ui, placement, index, entry.material, commands);
    }
    let Some(shape) = scene.shapes_of(index).first() else { return };
    let mut geometry = shape.geometry.clone();
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
        // A mesh has a placement instead.
        Geometry::Mesh { .. } => {}
    });
    if geometry != shape.geometry {
        commands.push(Command::Edit(Edit::Shape(index, geometry, shape.material)));
    }
}

/// Draws the editor of a model's placement.
fn placement(ui: &mut Ui, old: &Placement, index: usize, material: Option<usize>, commands: &mut Vec<Command>) {
    let mut new = old.clone();
    table(ui, "placement", |ui| {
        row(ui, "file", |ui| ui.label(&old.file));
        let speed = step(old.translation.length().max(1.0));
        row(ui, "translation", |ui| vector(ui, &mut new.translation, speed));
        row(ui, "rotation", |ui| vector(ui, &mut new.rotation_degrees, 0.5));
        row(ui, "scale", |ui| scale(ui, &mut new.scale));
    });
    if new != *old {
        commands.push(Command::Edit(Edit::Model(index, new, material)));
    }
}

/// Draws the scale: one number for all axes, and one for each; none becomes 0.
fn scale(ui: &mut Ui, scale: &mut Vec3) {
    let old = *scale;
    let speed = step(old.abs().max_element());
    ui.vertical(|ui| {
        let mut largest = old.max_element();
        if number(ui, &mut largest, speed, 1e-6..=1e9).changed() && old.max_element() > 0.0 {
            *scale = old * (largest / old.max_element());
        }
        vector(ui, scale, speed);
    });
    if scale.to_array().contains(&0.0) {
        *scale = old;
    }
}

/// `edge` turned to a right angle with `other`, its length kept; unchanged where that cannot be.
fn perpendicular(edge: Vec3, other: Vec3) -> Vec3 {
    let (edge_64, other) = (edge.as_dvec3(), other.as_dvec3());
    let rest = edge_64 - other * (edge_64.dot(other) / other.length_squared());
    match rest.try_normalize() {
        Some(direction) => (direction * edge_64.length()).as_vec3(),
        None => edge,
    }
}
