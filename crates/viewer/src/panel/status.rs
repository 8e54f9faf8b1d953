//! Status of the rendering: at the top of the panel, always in sight.

use egui::{Align, DragValue, Layout, ProgressBar, RichText, Ui};

use super::controls::{row, table};
use crate::command::Command;
use crate::viewer::Viewer;

/// Draws the figures, and the buttons that pause and restart.
pub fn show(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    ui.add_space(4.0);
    let name = viewer.document.path().file_name().unwrap_or_default().to_string_lossy();
    let unsaved = if viewer.document.is_modified() { " *" } else { "" };
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.button("Help (F1)").on_hover_text("what mouse and keys do").clicked() {
                commands.push(Command::Help);
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(egui::Label::new(RichText::new(format!("{name}{unsaved}")).heading()).truncate());
            });
        });
    });
    let progress = viewer.tracer.progress();
    let [width, height] = viewer.tracer.film_size();
    let rate = progress.total_samples as f64 / progress.seconds.max(1e-9);
    table(ui, "status", |ui| {
        row(ui, "samples", |ui| ui.label(RichText::new(progress.samples.to_string()).strong()));
        row(ui, "speed", |ui| {
            let rays = rate * viewer.tracer.rays_per_sample();
            let rays = if rays > 0.0 { large(rays) } else { "-".into() };
            ui.label(format!("{} samples/s, {rays} rays/s", large(rate)))
        });
        row(ui, "display", |ui| {
            ui.label(format!("{:.0} frames/s, {width} x {height}", viewer.clock.frames_per_second()))
        });
        row(ui, "time", |ui| ui.label(duration(progress.seconds)));
        row(ui, "device", |ui| ui.add(egui::Label::new(viewer.tracer.device().name()).wrap()));
        row(ui, "memory", |ui| ui.label(memory(viewer)));
    });
    ui.horizontal(|ui| {
        let paused = viewer.settings.paused;
        if ui.button(if paused { "Go on" } else { "Pause" }).on_hover_text("Space").clicked() {
            commands.push(Command::Pause);
        }
        if ui.button("Restart").on_hover_text("R").clicked() {
            commands.push(Command::Restart);
        }
        let mut stops = viewer.settings.limit.is_some();
        let mut limit = viewer.settings.limit.unwrap_or(viewer.scene().render.samples);
        let mut changed = ui.checkbox(&mut stops, "stop at").changed();
        changed |= ui.add_enabled(stops, DragValue::new(&mut limit).range(1..=i32::MAX as u32)).changed();
        if changed {
            commands.push(Command::StopAt(stops.then_some(limit)));
        }
    });
    if let Some(limit) = viewer.settings.limit {
        ui.add(ProgressBar::new(progress.samples as f32 / limit as f32).desired_height(6.0));
    }
}

fn memory(viewer: &Viewer) -> String {
    let mebibytes = |bytes: u64| format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20));
    let device = viewer.tracer.device().vulkan().map(|device| device.allocated_bytes());
    let host = raggio_render::memory_bytes();
    match (device, host) {
        (Some(device), Some(host)) => format!("{} on the device, {} here", mebibytes(device), mebibytes(host)),
        (Some(bytes), None) | (None, Some(bytes)) => mebibytes(bytes),
        (None, None) => "unknown".into(),
    }
}

/// Writes a number with three digits and a unit's prefix.
fn large(value: f64) -> String {
    let (value, unit) = match value {
        v if v >= 1e9 => (v / 1e9, "G"),
        v if v >= 1e6 => (v / 1e6, "M"),
        v if v >= 1e3 => (v / 1e3, "k"),
        v => (v, ""),
    };
    let digits = if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else {
        2
    };
    format!("{value:.digits$} {unit}").trim_end().to_owned()
}

fn duration(seconds: f64) -> String {
    let whole = seconds as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole / 60 % 60),
    }
}
