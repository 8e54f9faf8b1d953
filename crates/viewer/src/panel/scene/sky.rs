//! The light that comes from outside.

use egui::Ui;
use raggio_scene::{Environment, Scene, Sky, SunPlace, Vec3};

use crate::command::{Command, Edit};
use crate::panel::controls::{color, number, radiance, row, table};

/// Editor of the sky.
pub fn show(ui: &mut Ui, scene: &Scene, commands: &mut Vec<Command>) {
    let mut environment = scene.environment.clone();
    ui.horizontal(|ui| {
        ui.strong("sky");
        let horizon = match environment {
            Environment::Constant(radiance) => radiance,
            Environment::Gradient { horizon, .. } => horizon,
            Environment::Image { .. } | Environment::Sky(_) => Vec3::ONE,
        };
        let constant = matches!(environment, Environment::Constant(_));
        if ui.selectable_label(constant, "constant").clicked() && !constant {
            environment = Environment::Constant(horizon);
        }
        let gradient = matches!(environment, Environment::Gradient { .. });
        if ui.selectable_label(gradient, "gradient").clicked() && !gradient {
            environment = Environment::Gradient { horizon, zenith: horizon * Vec3::new(0.5, 0.7, 1.0) };
        }
        let day = matches!(environment, Environment::Sky(_));
        if ui.selectable_label(day, "day").clicked() && !day {
            environment = Environment::Sky(Sky::of(SunPlace::Direction(toward(40.0, 135.0))));
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
        Environment::Sky(sky) => day(ui, sky),
    });
    if environment != scene.environment {
        commands.push(Command::Edit(Edit::Environment(environment)));
    }
}

/// Rows of a sky by day. A sun that is moved by hand is no longer that of a place and a time.
fn day(ui: &mut Ui, sky: &mut Sky) {
    let direction = sky.sun.direction();
    let mut elevation = direction.y.clamp(-1.0, 1.0).asin().to_degrees() as f32;
    let mut azimuth = direction.x.atan2(-direction.z).to_degrees().rem_euclid(360.0) as f32;
    let moved = row(ui, "sun's height", |ui| number(ui, &mut elevation, 0.1, 0.0..=90.0)).changed()
        | row(ui, "sun's azimuth", |ui| number(ui, &mut azimuth, 0.5, 0.0..=360.0)).changed();
    if moved {
        sky.sun = SunPlace::Direction(toward(elevation, azimuth));
    }
    row(ui, "haze", |ui| number(ui, &mut sky.turbidity, 0.02, 1.0..=10.0));
    row(ui, "ground", |ui| color(ui, &mut sky.ground_albedo));
    row(ui, "sun", |ui| number(ui, &mut sky.sun_intensity, 0.01, 0.0..=1e9));
    row(ui, "rotation", |ui| number(ui, &mut sky.rotation_degrees, 0.5, -360.0..=360.0));
    row(ui, "intensity", |ui| number(ui, &mut sky.intensity, 0.01, 0.0..=1e9));
}

/// Unit vector toward a sun, its azimuth counted from north (-Z) over east (+X), both in degrees.
fn toward(elevation: f32, azimuth: f32) -> Vec3 {
    let (sine, cosine) = elevation.to_radians().sin_cos();
    let (east, north) = azimuth.to_radians().sin_cos();
    Vec3::new(east * cosine, sine, -north * cosine)
}
