//! The table of keys.

use egui::style::ScrollStyle;
use egui::{Align2, Label, RichText, ScrollArea, Ui, Vec2, Window};

use crate::command::Command;
use crate::navigation::{Preset, describe};
use crate::viewer::Viewer;

/// Width and height that the table leaves of the window: for its frame, its title and a margin.
const AROUND: Vec2 = Vec2::new(52.0, 80.0);
/// Width of the table with its longest row in one line.
const WIDTH: f32 = 470.0;
/// Width of the column of keys.
const KEYS: f32 = 140.0;

/// Draws the table of keys in a window over the picture.
pub fn show(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let mut open = true;
    let preset = viewer.pilot.preset();
    // The table is longer than a small window, and wider than a narrow one.
    let room = (ui.ctx().content_rect().size() - AROUND).max(Vec2::splat(1.0)).min(Vec2::new(WIDTH, f32::INFINITY));
    Window::new(format!("Keys and mouse ({})", preset.name()))
        .open(&mut open)
        .anchor(Align2::LEFT_TOP, [12.0, 12.0])
        // The window is as high as the table, within this.
        .fixed_size(room)
        .fade_in(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            // A bar that is always there says that there is more.
            ui.spacing_mut().scroll = ScrollStyle::solid();
            ScrollArea::vertical().show(ui, |ui| table(ui, preset));
        });
    if !open {
        commands.push(Command::Help);
    }
}

fn table(ui: &mut Ui, preset: Preset) {
    for (keys, what) in describe(preset) {
        ui.horizontal_top(|ui| {
            let keys = ui.label(RichText::new(*keys).strong());
            ui.add_space((KEYS - keys.rect.width()).max(0.0));
            ui.add(Label::new(*what).wrap());
        });
    }
}
