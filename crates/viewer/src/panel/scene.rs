//! Editor of the scene: shapes, materials, lights, sky, air.

mod geometry;
mod light;
mod material;
mod medium;
mod sky;

use std::path::Path;

use egui::{Color32, Rect, Rgba, ScrollArea, Sense, Ui, vec2};
use raggio_scene::{Contents, Geometry, Material, Scene, Vec3, counted};

use crate::command::{Command, Edit, Navigate};
use crate::fields::Fields;
use crate::navigation::axes;
use crate::viewer::Viewer;

/// The list of shapes, and an editor for the chosen one.
pub fn show(ui: &mut Ui, viewer: &Viewer, fields: &mut Fields, commands: &mut Vec<Command>) {
    history(ui, viewer, commands);
    let scene = viewer.scene();
    let row_height = ui.text_style_height(&egui::TextStyle::Body) + 4.0;
    let height = 7.0 * row_height;
    let mut list = ScrollArea::vertical().id_salt("shapes").max_height(height).auto_shrink([false, true]);
    // A shape selected in the picture is to be seen in the list.
    if fields.scrolled_to != viewer.selection {
        fields.scrolled_to = viewer.selection;
        let row = viewer.selection.unwrap_or_default() as f32 * (row_height + ui.spacing().item_spacing.y);
        list = list.vertical_scroll_offset((row - height / 2.0).max(0.0));
    }
    list.show_rows(ui, row_height, scene.entries.len(), |ui, rows| {
        for shape in rows {
            entry(ui, viewer, shape, commands);
        }
    });
    ui.horizontal(|ui| {
        ui.menu_button("Add", |ui| add(ui, viewer, commands));
        let chosen = viewer.selection.is_some();
        if ui.add_enabled(chosen, egui::Button::new("Duplicate")).clicked() {
            commands.push(Command::DuplicateSelected);
        }
        if ui.add_enabled(chosen, egui::Button::new("Delete")).on_hover_text("Delete").clicked() {
            commands.push(Command::RemoveSelected);
        }
        if let Some(shape) = viewer.selection.filter(|_| go_to(ui, viewer)) {
            commands.push(Command::Navigate(Navigate::FocusOn(shape)));
        }
    });
    if let Some(shape) = viewer.selection {
        ui.separator();
        geometry::show(ui, scene, shape, commands);
        ui.separator();
        material::show(ui, scene, shape, commands);
    }
    ui.separator();
    light::show(ui, viewer, commands);
    ui.separator();
    sky::show(ui, scene, commands);
    ui.separator();
    medium::show_air(ui, scene, commands);
}

/// Draws the button that goes to the selected shape and returns whether it was clicked; a plane is everywhere, so that
/// there is no going to it.
fn go_to(ui: &mut Ui, viewer: &Viewer) -> bool {
    ui.add_enabled(viewer.outline.is_some(), egui::Button::new("Go to")).on_hover_text("double click").clicked()
}

/// Name of a shape: its kind or its file, and its place among all, counted from 1 as in messages about the file.
pub fn shape_name(scene: &Scene, shape: usize) -> String {
    let number = shape + 1;
    match scene.entries.get(shape).map(|entry| &entry.contents) {
        Some(Contents::Model(placement)) => {
            format!("{} {number}", Path::new(&placement.file).file_name().unwrap_or_default().display())
        }
        Some(Contents::Group(name)) => format!("{name} {number}"),
        Some(Contents::Geometry(geometry)) => format!("{} {number}", geometry.key()),
        None => format!("shape {number}"),
    }
}

fn history(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let mut button = |ui: &mut Ui, title: &str, keys: &str, step: Option<&str>, command: Command| {
        let response = ui.add_enabled(step.is_some(), egui::Button::new(title));
        if response.on_hover_text(format!("{} ({keys})", step.unwrap_or_default())).clicked() {
            commands.push(command);
        }
    };
    ui.horizontal(|ui| {
        button(ui, "Undo", "Ctrl+Z", viewer.document.can_undo(), Command::Undo);
        button(ui, "Redo", "Ctrl+Shift+Z", viewer.document.can_redo(), Command::Redo);
        ui.label(egui::RichText::new(counted(viewer.scene().entries.len(), "shape")).weak());
    });
}

/// A line of the list: a swatch of the material, the shape's name, the material's name.
fn entry(ui: &mut Ui, viewer: &Viewer, shape: usize, commands: &mut Vec<Command>) {
    let scene = viewer.scene();
    let material = scene.entries[shape].material.map(|material| &scene.materials[material]);
    ui.horizontal(|ui| {
        let (swatch, _) = ui.allocate_exact_size(vec2(12.0, 12.0), Sense::hover());
        // A model's own materials have many colours.
        if let Some(color) = material.map(swatch_color) {
            ui.painter().rect_filled(Rect::from_center_size(swatch.center(), vec2(12.0, 12.0)), 3.0, srgb(color));
        }
        let chosen = viewer.selection == Some(shape);
        let text = format!("{}   {}", shape_name(scene, shape), material.map_or("its own", |it| &it.name));
        let response = ui.selectable_label(chosen, text);
        if response.clicked() {
            commands.push(Command::Select((!chosen).then_some(shape)));
        }
        if response.double_clicked() {
            commands.push(Command::Select(Some(shape)));
            commands.push(Command::Navigate(Navigate::FocusOn(shape)));
        }
    });
}

fn swatch_color(material: &Material) -> Vec3 {
    match &material.principled {
        Some(surface) if material.is_emissive() => surface.emissive.into(),
        Some(surface) => surface.base_color.into(),
        None if material.is_emissive() => material.emission_color,
        None => material.color,
    }
}

/// Draws the menu of new shapes, which appear where the camera looks, in a size that shows.
fn add(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let scene = viewer.scene();
    let camera = viewer.camera();
    let center = camera.look_at;
    let size = 0.1 * (camera.look_at - camera.position).length();
    let axes = axes(camera);
    let (right, up) = (axes.right.as_vec3() * size, axes.up.as_vec3() * size);
    let stand = size * Vec3::Y;
    let kinds = [
        ("Sphere", Geometry::Sphere { center, radius: size }),
        ("Box", Geometry::Box { center, size: Vec3::splat(2.0 * size), rotation_degrees: Vec3::ZERO }),
        ("Rectangle", Geometry::Rectangle { corner: center - right - up, edge_u: 2.0 * right, edge_v: 2.0 * up }),
        ("Disk", Geometry::Disk { center, normal: Vec3::Y, radius: size }),
        ("Cylinder", Geometry::Cylinder { base: center - stand, top: center + stand, radius: size, capped: true }),
        (
            "Cone",
            Geometry::Cone { base: center - stand, top: center + stand, radius: size, top_radius: 0.0, capped: true },
        ),
        ("Plane", Geometry::Plane { point: center, normal: Vec3::Y }),
    ];
    let material = viewer.selection.and_then(|shape| scene.entries[shape].material).unwrap_or(0);
    for (name, geometry) in kinds {
        if ui.button(name).clicked() {
            commands.push(Command::Edit(Edit::Add(geometry, material)));
            ui.close();
        }
    }
}

/// Converts a linear colour to that of a display, clamped to 0 to 1.
fn srgb(color: Vec3) -> Color32 {
    let [r, g, b] = color.to_array().map(|x| x.clamp(0.0, 1.0));
    Rgba::from_rgb(r, g, b).into()
}
