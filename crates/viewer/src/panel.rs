//! The panels: they show what is, and ask for what shall be.

mod camera;
mod controls;
mod help;
mod output;
mod picture;
mod probe;
mod scene;
mod status;
mod theme;

use egui::{Panel, ScrollArea, Ui};

use crate::command::Command;
use crate::fields::Fields;
use crate::viewer::Viewer;

pub use theme::apply as apply_theme;

/// Draws the panels and says what they ask for.
pub fn show(ui: &mut Ui, viewer: &Viewer, fields: &mut Fields, commands: &mut Vec<Command>) {
    if viewer.settings.panels {
        let panel = Panel::right("panel").resizable(true).default_size(320.0).size_range(280.0..=640.0);
        panel.show(ui, |ui| {
            status::show(ui, viewer, commands);
            ui.separator();
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                section(ui, "Picture", true, |ui| picture::show(ui, viewer, fields, commands));
                section(ui, "Scene", true, |ui| scene::show(ui, viewer, fields, commands));
                section(ui, "Under the cursor", true, |ui| probe::show(ui, viewer));
                section(ui, "Camera", false, |ui| camera::show(ui, viewer, commands));
                section(ui, "Files", false, |ui| output::show(ui, viewer, fields, commands));
            });
        });
    }
    if viewer.settings.help {
        help::show(ui, viewer, commands);
    }
}

fn section(ui: &mut Ui, title: &str, open: bool, contents: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(egui::RichText::new(title).strong()).default_open(open).show(ui, |ui| {
        contents(ui);
        ui.add_space(4.0);
    });
}
