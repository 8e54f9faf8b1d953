//! The light that comes from outside.

use egui::Ui;
use raggio_scene::{Environment, Scene, Vec3};

use crate::command::{Command, Edit};
use crate::panel::controls::{radiance, row, table};

/// Editor of the sky.
pub fn show(ui: &mut Ui, scene: &Scene, commands: &mut Vec<Command>) {
    let mut environment = scene.environment.clone();
    ui.horizontal(|ui| {
        ui.strong("sky");
        let horizon = match environment {
            Environment::Constant(radiance) => radiance,
            Environment::Gradient { horizon, .. } => horizon,
        };
        let constant = matches!(environment, Environment::Constant(_));
        if ui.selectable_label(constant, "constant").clicked() && !constant {
            environment = Environment::Constant(horizon);
        }
        if ui.selectable_label(!constant, "gradient").clicked() && constant {
            environment = Environment::Gradient { horizon, zenith: horizon * Vec3::new(0.5, 0.7, 1.0) };
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
    });
    if environment != scene.environment {
        commands.push(Command::Edit(Edit::Environment(environment)));
    }
}
