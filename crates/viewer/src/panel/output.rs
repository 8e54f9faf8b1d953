//! Scenes and pictures on disk.

use egui::{DragValue, ProgressBar, TextEdit, Ui};

use super::controls::{row, table};
use crate::command::{Command, ExportRequest};
use crate::fields::Fields;
use crate::viewer::Viewer;

/// Draws the controls that save, open and export.
pub fn show(ui: &mut Ui, viewer: &Viewer, fields: &mut Fields, commands: &mut Vec<Command>) {
    table(ui, "files", |ui| {
        row(ui, "scene", |ui| {
            ui.horizontal(|ui| {
                ui.add(TextEdit::singleline(&mut fields.save_path).desired_width(150.0));
                if ui.button("Save").on_hover_text("Ctrl+S").clicked() {
                    let other = fields.save_path != viewer.document.path().display().to_string();
                    commands.push(Command::Save(other.then(|| fields.save_path.clone().into())));
                }
            });
        });
        row(ui, "open", |ui| {
            ui.horizontal(|ui| {
                let hint = "or drop a file here";
                ui.add(TextEdit::singleline(&mut fields.open_path).hint_text(hint).desired_width(150.0));
                if ui.button("Open").clicked() && !fields.open_path.is_empty() {
                    commands.push(Command::Open(fields.open_path.clone().into()));
                }
            });
        });
        row(ui, "picture", |ui| export(ui, viewer, fields, commands));
    });
}

fn export(ui: &mut Ui, viewer: &Viewer, fields: &mut Fields, commands: &mut Vec<Command>) {
    ui.vertical(|ui| {
        ui.horizontal(|ui| {
            let hint = "NAME.png or NAME.exr";
            ui.add(TextEdit::singleline(&mut fields.export_path).hint_text(hint).desired_width(150.0));
            if let Some(export) = &viewer.export {
                if ui.button("Cancel").clicked() {
                    commands.push(Command::CancelExport);
                }
                ui.add(ProgressBar::new(export.fraction()).desired_width(80.0).show_percentage());
            } else if ui.button("Export").clicked() {
                let path = fields.export_path.clone().into();
                let (size, samples) = (fields.export_size, fields.export_samples);
                commands.push(Command::Export(ExportRequest { path, size, samples }));
            }
        });
        let mut own_size = fields.export_size.is_some();
        ui.horizontal(|ui| {
            let render = &viewer.scene().render;
            let mut size = fields.export_size.unwrap_or([render.width, render.height]);
            ui.checkbox(&mut own_size, "size");
            ui.add_enabled_ui(own_size, |ui| {
                ui.add(DragValue::new(&mut size[0]).range(1..=65536));
                ui.label("x");
                ui.add(DragValue::new(&mut size[1]).range(1..=65536));
            });
            fields.export_size = own_size.then_some(size);
        });
        let mut own_samples = fields.export_samples.is_some();
        ui.horizontal(|ui| {
            let mut samples = fields.export_samples.unwrap_or(viewer.scene().render.samples);
            ui.checkbox(&mut own_samples, "samples");
            ui.add_enabled(own_samples, DragValue::new(&mut samples).range(1..=i32::MAX as u32));
            fields.export_samples = own_samples.then_some(samples);
        });
    });
}
