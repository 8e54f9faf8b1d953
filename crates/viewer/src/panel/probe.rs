//! Values of the picture under the cursor.

use egui::{RichText, Ui};
use raggio_render::Feature;
use raggio_scene::Vec3;

use super::controls::{row, table};
use crate::viewer::Viewer;

/// Draws radiance, position, normal and material under the cursor.
pub fn show(ui: &mut Ui, viewer: &Viewer) {
    let reading = viewer.reading.as_ref();
    let pick = reading.and_then(|reading| reading.pick);
    let text = |value: Option<String>| RichText::new(value.unwrap_or_else(|| "-".into())).monospace();
    table(ui, "probe", |ui| {
        let mut line = |name: &str, value: Option<String>| {
            row(ui, name, |ui| ui.label(text(value)));
        };
        line("pixel", reading.map(|r| format!("{}, {}", r.pixel[0], r.pixel[1])));
        line(
            if viewer.settings.look.view.feature() == Feature::Radiance { "radiance" } else { "value" },
            reading.map(|r| numbers(r.film.mean().map(|x| x as f32))),
        );
        line("error", reading.and_then(|r| r.film.luminance_error()).map(|error| format!("± {error:.2e}")));
        line("position", pick.map(|p| vector(p.position)));
        line("normal", pick.map(|p| vector(p.normal)));
        line("distance", pick.map(|p| format!("{:.4}", p.distance)));
        line("material", pick.and_then(|p| Some(viewer.scene().materials.get(p.material)?.name.clone())));
        line("shape", pick.map(|p| crate::panel::scene::shape_name(viewer.scene(), p.shape)));
    });
}

fn vector(v: Vec3) -> String {
    numbers(v.to_array())
}

fn numbers(values: [f32; 3]) -> String {
    values.map(|x| if x != 0.0 && x.abs() < 1e-3 { format!("{x:.1e}") } else { format!("{x:.4}") }).join("  ")
}
