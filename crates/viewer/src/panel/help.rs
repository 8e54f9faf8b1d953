//! The table of keys.

use egui::{Align2, Grid, RichText, Ui, Window};

use crate::command::Command;
use crate::navigation::describe;
use crate::viewer::Viewer;

/// Draws the table of keys in a window over the picture.
pub fn show(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let mut open = true;
    let preset = viewer.pilot.preset();
    Window::new(format!("Keys and mouse ({})", preset.name()))
        .open(&mut open)
        .anchor(Align2::LEFT_TOP, [12.0, 12.0])
        .resizable(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            // On a small screen the table is longer than the window.
            let height = ui.ctx().content_rect().height() - 80.0;
            egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
                Grid::new("keys").num_columns(2).spacing([18.0, 4.0]).striped(true).show(ui, |ui| {
                    for (keys, what) in describe(preset) {
                        ui.label(RichText::new(*keys).strong());
                        ui.label(*what);
                        ui.end_row();
                    }
                })
            });
        });
    if !open {
        commands.push(Command::Help);
    }
}
