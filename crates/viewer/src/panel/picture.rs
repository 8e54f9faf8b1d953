//! Controls of how the film is shown.

use egui::{DragValue, Slider, SliderClamping, TextEdit, Ui};
use raggio_render::{Comparison, View};

use super::controls::{choose, choose_in, row, table};
use crate::command::Command;
use crate::fields::Fields;
use crate::look::Look;
use crate::viewer::Viewer;

/// Draws the controls of view, exposure, tone mapping, comparison, and of how samples are added.
pub fn show(ui: &mut Ui, viewer: &Viewer, fields: &mut Fields, commands: &mut Vec<Command>) {
    let mut look = viewer.settings.look;
    table(ui, "picture", |ui| {
        row(ui, "view", |ui| choose(ui, "view", &mut look.view));
        if let Some(legend) = look.view.legend(viewer.tracer.scale(look.view)) {
            row(ui, "", |ui| ui.add(egui::Label::new(egui::RichText::new(legend).weak()).wrap()));
        }
        let tone_mapped = look.view == View::Radiance;
        row(ui, "exposure", |ui| {
            let slider = Slider::new(&mut look.exposure, -10.0..=10.0)
                .clamping(SliderClamping::Edits)
                .suffix(" stops")
                .max_decimals(2);
            ui.add_enabled(tone_mapped, slider);
        });
        row(ui, "tones", |ui| {
            ui.add_enabled_ui(tone_mapped, |ui| choose(ui, "tones", &mut look.tone_mapper));
        });
        row(ui, "noise", |ui| {
            ui.horizontal(|ui| {
                let mut denoised = viewer.denoising.is_some();
                let box_ = ui.add_enabled(tone_mapped, egui::Checkbox::new(&mut denoised, "denoised"));
                if box_.on_hover_text("Intel Open Image Denoise; files keep their noise").changed() {
                    commands.push(Command::Denoise(denoised));
                }
                let mut in_motion = viewer.settings.denoise_in_motion;
                ui.label("in motion");
                ui.add_enabled_ui(tone_mapped && denoised, |ui| choose_in(ui, "in motion", &mut in_motion, 70.0));
                if in_motion != viewer.settings.denoise_in_motion {
                    commands.push(Command::DenoiseInMotion(in_motion));
                }
            });
        });
        if let Some(denoising) = &viewer.denoising {
            row(ui, "", |ui| ui.add(egui::Label::new(egui::RichText::new(denoising.describe()).weak()).wrap()));
        }
        row(ui, "alpha", |ui| alpha(ui, viewer, commands));
        row(ui, "samples", |ui| samples(ui, viewer, commands));
        row(ui, "depth", |ui| depth(ui, viewer, commands));
        row(ui, "size", |ui| size(ui, viewer, commands));
        row(ui, "compare", |ui| {
            ui.add_enabled_ui(tone_mapped, |ui| compare(ui, viewer, fields, &mut look, commands));
        });
    });
    if look != viewer.settings.look {
        commands.push(Command::Look(look));
    }
}

/// Draws the number of samples that a frame adds.
fn samples(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let mut automatic = viewer.settings.samples_per_frame.is_none();
        let mut count = viewer.settings.samples_per_frame.unwrap_or(1);
        let mut changed = ui.checkbox(&mut automatic, "automatic").changed();
        let number = DragValue::new(&mut count).range(1..=1024).suffix(" at a time");
        changed |= ui.add_enabled(!automatic, number).changed();
        if changed {
            commands.push(Command::SamplesPerFrame((!automatic).then_some(count)));
        }
    });
}

/// Draws how the picture's size and frame come about.
fn size(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let mut fixed = viewer.settings.scene_size;
        let render = &viewer.scene().render;
        let text = format!("the scene's, {} x {}", render.width, render.height);
        if ui.checkbox(&mut fixed, text).changed() {
            commands.push(Command::SceneSize(fixed));
        }
        let mut fill = viewer.settings.fill;
        let box_ = ui.add_enabled(!fixed, egui::Checkbox::new(&mut fill, "fill"));
        if box_.on_hover_text("fills the window; otherwise the frame is the scene's").changed() {
            commands.push(Command::Fill(fill));
        }
    });
}

/// Draws whether files of the picture have an alpha channel.
fn alpha(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let mut render = viewer.scene().render.clone();
    let box_ = ui.checkbox(&mut render.alpha, "files without background");
    if box_.on_hover_text("the background shines, but is left out where it is seen directly").changed() {
        commands.push(Command::Edit(crate::command::Edit::Render(render)));
    }
}

/// Draws the greatest length of paths.
fn depth(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let mut render = viewer.scene().render.clone();
    if ui.add(DragValue::new(&mut render.max_depth).range(0..=65535).suffix(" rays a path")).changed() {
        commands.push(Command::Edit(crate::command::Edit::Render(render)));
    }
}

fn compare(ui: &mut Ui, viewer: &Viewer, fields: &mut Fields, look: &mut Look, commands: &mut Vec<Command>) {
    ui.vertical(|ui| {
        ui.horizontal(|ui| {
            ui.add(TextEdit::singleline(&mut fields.reference_path).hint_text("an .exr or .png").desired_width(130.0));
            if ui.button("Load").clicked() && !fields.reference_path.is_empty() {
                commands.push(Command::Reference(Some(fields.reference_path.clone().into())));
            }
        });
        if viewer.reference.is_some() {
            ui.horizontal(|ui| {
                choose(ui, "comparison", &mut look.comparison);
                if ui.button("Close").clicked() {
                    commands.push(Command::Reference(None));
                }
            });
            if look.comparison == Comparison::Split {
                ui.add(Slider::new(&mut look.split, 0.0..=1.0).show_value(false));
            }
        }
    });
}
