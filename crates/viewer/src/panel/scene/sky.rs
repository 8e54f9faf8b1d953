//! The light that comes from outside.

use egui::Ui;
use raggio_scene::{Environment, Scene, Vec3};

use crate::command::{Command, Edit};
use crate::panel::controls::{number, radiance, row, table};

/// Editor of the sky.
pub fn show(ui: &mut Ui, scene: &Scene, commands: &mut Vec<Command>) {
    let mut environment = scene.environment.clone();
    ui.horizontal(|ui| {
        ui.strong("sky");
        let horizon = match environment {
            Environment::Constant(radiance) => radiance,
            Environment::Gradient { horizon, .. } => horizon,
            Environment::Image { .. } => Vec3::ONE,
        };
        let constant = matches!(environment, Environment::Constant(_));
        if ui.selectable_label(constant, "constant").clicked() && !constant {
            environment = Environment::Constant(horizon);
        }
        let gradient = matches!(environment, Environment::Gradient { .. });
        if ui.selectable_label(gradient, "gradient").clicked() && !gradient {
            environment = Environment::Gradient { horizon, zenith: horizon * Vec3::new(0.5, 0.7, 1.0) };
        }
        // The file alone can say which image it is.
        if matches!(environment, Environment::Image { .. }) {
            let _ = ui.selectable_label(true, "image");
        }
    });
    table(ui, "sky", |ui| match &mut environment {
        Environment::Constant(color) => {
            row(ui, "radiance", |ui| radiance(ui, color));
        }
        Environment::Gradient { horizon, zenith } => {
            row(ui, "horizon", |ui| radiance(ui, horizon));
            row(ui, "zenith", |ui| radiance(ui, zenith));
        }
        Environment::Image { rotation_degrees, intensity, .. } => {
            row(ui, "rotation", |ui| number(ui, rotation_degrees, 0.5, -360.0..=360.0));
            row(ui, "intensity", |ui| number(ui, intensity, 0.01, 0.0..=1e9));
        }
    });
    if environment != scene.environment {
        commands.push(Command::Edit(Edit::Environment(environment)));
    }
}
