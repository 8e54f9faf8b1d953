//! Editor of media: of those in bodies, and of the air.

use egui::{Slider, SliderClamping, Ui};
use raggio_scene::{Medium, Scene, Vec3};

use crate::command::{Command, Edit};
use crate::panel::controls::{row, step, table, vector};

/// Medium that is there first when one is asked for: thin white fog.
const FOG: Medium = Medium { absorption: Vec3::ZERO, scattering: Vec3::splat(0.05), anisotropy: 0.0 };

/// Editor of the air.
pub fn show_air(ui: &mut Ui, scene: &Scene, commands: &mut Vec<Command>) {
    let mut air = scene.air;
    ui.strong("air");
    table(ui, "air", |ui| medium(ui, &mut air, true));
    if air != scene.air {
        commands.push(Command::Edit(Edit::Air(air)));
    }
}

/// Rows of a medium, which may be taken away only where `is_optional`.
pub fn medium(ui: &mut Ui, medium: &mut Option<Medium>, is_optional: bool) {
    let mut is_there = medium.is_some();
    if row(ui, "medium", |ui| ui.add_enabled(is_optional, egui::Checkbox::without_text(&mut is_there)).changed()) {
        *medium = is_there.then_some(FOG);
    }
    let Some(Medium { absorption, scattering, anisotropy }) = medium else { return };
    for (name, coefficients) in [("absorption", absorption), ("scattering", scattering)] {
        let speed = step(coefficients.max_element()).max(1e-3);
        if row(ui, name, |ui| vector(ui, coefficients, speed)) {
            *coefficients = coefficients.max(Vec3::ZERO);
        }
    }
    row(ui, "anisotropy", |ui| {
        ui.add(Slider::new(anisotropy, -0.999..=0.999).clamping(SliderClamping::Edits).max_decimals(3))
    });
}
