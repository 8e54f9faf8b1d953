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

/// Width of the panel, in points: the least, the one at first, and the most.
const WIDTH: [f32; 3] = [280.0, 320.0, 640.0];
/// Least width that the panel leaves for the picture, in points.
const PICTURE: f32 = 160.0;

/// Whether a window of this width, in points, has room for a panel beside the picture.
pub fn fit(width: f32) -> bool {
    width >= WIDTH[0] + PICTURE
}

/// Draws the panels and says what they ask for.
pub fn show(ui: &mut Ui, viewer: &Viewer, fields: &mut Fields, commands: &mut Vec<Command>) {
    if viewer.shows_panels() {
        let [least, first, most] = WIDTH;
        let most = most.min(ui.available_width() - PICTURE);
        let panel = Panel::right("panel").resizable(true).default_size(first).size_range(least..=most);
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
