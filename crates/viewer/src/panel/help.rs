//! The table of keys.

use egui::style::ScrollStyle;
use egui::{Align2, Grid, RichText, ScrollArea, Ui, Vec2, Window};

use crate::command::Command;
use crate::navigation::{Preset, describe};
use crate::viewer::Viewer;

/// Width and height that the table leaves of the window: for its frame, its title and a margin.
const AROUND: Vec2 = Vec2::new(52.0, 80.0);

/// Draws the table of keys in a window over the picture.
pub fn show(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let mut open = true;
    let preset = viewer.pilot.preset();
    // The table is longer than a small window, and wider than a narrow one.
    let room = ui.ctx().content_rect().size() - AROUND;
    Window::new(format!("Keys and mouse ({})", preset.name()))
        .open(&mut open)
        .anchor(Align2::LEFT_TOP, [12.0, 12.0])
        // The window is as large as the table, within this.
        .fixed_size(room.max(Vec2::splat(1.0)))
        .fade_in(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            // Bars that are always there say that there is more.
            ui.spacing_mut().scroll = ScrollStyle::solid();
            ScrollArea::both().show(ui, |ui| table(ui, preset));
        });
    if !open {
        commands.push(Command::Help);
    }
}

fn table(ui: &mut Ui, preset: Preset) {
    Grid::new("keys").num_columns(2).spacing([18.0, 4.0]).striped(true).show(ui, |ui| {
        for (keys, what) in describe(preset) {
            ui.label(RichText::new(*keys).strong());
            ui.label(*what);
            ui.end_row();
        }
    });
}
