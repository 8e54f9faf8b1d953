//! Editor of a shape's place and size.

use egui::{CollapsingHeader, Ui};
use raggio_scene::{Contents, Entry, Geometry, Placement, Scene, Transform, Vec3};

use crate::command::{Command, Edit};
use crate::panel::controls::{number, row, step, table, vector};

/// Editor of one shape's numbers.
pub fn show(ui: &mut Ui, scene: &Scene, index: usize, commands: &mut Vec<Command>) {
    ui.strong(super::shape_name(scene, index));
    let entry = &scene.entries[index];
    match &entry.contents {
        Contents::Model(placement) => self::placement(ui, placement, index, entry.material, commands),
        Contents::Group(name) => table(ui, "group", |ui| {
            row(ui, "group", |ui| ui.label(name));
        }),
        Contents::Geometry(geometry) => self::geometry(ui, geometry, index, entry.material, commands),
    }
    transform(ui, entry, index, commands);
}

/// Draws the editor of a shape's numbers, as they are before its transform.
fn geometry(ui: &mut Ui, old: &Geometry, index: usize, material: Option<usize>, commands: &mut Vec<Command>) {
    let mut geometry = old.clone();
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
        Geometry::Disk { center, normal, radius } => {
            let speed = step(*radius);
            row(ui, "center", |ui| vector(ui, center, speed));
            row(ui, "normal", |ui| vector(ui, normal, 0.01));
            row(ui, "radius", |ui| number(ui, radius, speed, 1e-6..=1e9));
        }
        Geometry::Cylinder { base, top, radius, capped } => {
            let speed = step(radius.max(base.distance(*top)));
            row(ui, "base", |ui| vector(ui, base, speed));
            row(ui, "top", |ui| vector(ui, top, speed));
            row(ui, "radius", |ui| number(ui, radius, step(*radius), 1e-6..=1e9));
            row(ui, "capped", |ui| ui.checkbox(capped, ""));
        }
        Geometry::Cone { base, top, radius, top_radius, capped } => {
            let speed = step(radius.max(base.distance(*top)));
            row(ui, "base", |ui| vector(ui, base, speed));
            row(ui, "top", |ui| vector(ui, top, speed));
            // The wide end stays the wide one.
            row(ui, "radius", |ui| number(ui, radius, step(*radius), 1e-6..=1e9));
            let most = *radius;
            row(ui, "top radius", |ui| number(ui, top_radius, step(most), 0.0..=most));
            *top_radius = top_radius.min(most);
            row(ui, "capped", |ui| ui.checkbox(capped, ""));
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
    if geometry != *old {
        commands.push(Command::Edit(Edit::Shape(index, geometry, material.unwrap_or_default())));
    }
}

/// Draws the editor of a transform, closed where there is none. Models have a placement for it.
fn transform(ui: &mut Ui, entry: &Entry, index: usize, commands: &mut Vec<Command>) {
    let old = entry.transform;
    if entry.placement().is_some() && old == Transform::IDENTITY {
        return;
    }
    let mut new = old;
    let is_open = old != Transform::IDENTITY || matches!(entry.contents, Contents::Group(_));
    CollapsingHeader::new("transform").default_open(is_open).show(ui, |ui| {
        table(ui, "transform", |ui| {
            let speed = step(old.translation.length().max(1.0));
            row(ui, "translation", |ui| vector(ui, &mut new.translation, speed));
            row(ui, "rotation", |ui| vector(ui, &mut new.rotation_degrees, 0.5));
            row(ui, "scale", |ui| scale(ui, &mut new.scale));
        });
    });
    if new != old {
        commands.push(Command::Edit(Edit::Transform(index, new)));
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
