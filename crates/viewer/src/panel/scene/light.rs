//! Editors of the lights that are no surfaces.

use egui::{CollapsingHeader, Ui};
use raggio_scene::{Environment, LightEntry, LightPlace, Vec3};

use crate::command::{Command, Edit};
use crate::panel::controls::{color, number, row, step, table, vector};
use crate::viewer::Viewer;

/// Editors of all lights of the file, each below its name, and the menu of new ones. Lights of models are changed where the
/// models are made.
pub fn show(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let scene = viewer.scene();
    ui.horizontal(|ui| {
        ui.strong("lights");
        ui.menu_button("Add", |ui| add(ui, viewer, commands)).response.on_hover_text("a light that is no surface");
        let has_sun = matches!(&scene.environment, Environment::Sky(sky) if sky.sun().is_some());
        let of_models = scene.lights.len() - scene.light_entries.len() - usize::from(has_sun);
        if of_models > 0 {
            ui.weak(format!("and {of_models} of models"));
        }
    });
    for (index, light) in scene.light_entries.iter().enumerate() {
        let title = format!("{} {}", light.place.key(), index + 1);
        CollapsingHeader::new(title).id_salt(("light", index)).show(ui, |ui| editor(ui, index, light, commands));
    }
}

fn editor(ui: &mut Ui, index: usize, old: &LightEntry, commands: &mut Vec<Command>) {
    let mut new = *old;
    table(ui, &format!("light {index}"), |ui| {
        place(ui, &mut new.place);
        row(ui, "color", |ui| {
            let mut hue = new.color.clamp(Vec3::ZERO, Vec3::ONE);
            if color(ui, &mut hue) {
                new.color = hue;
            }
        });
        let speed = (new.intensity * 0.01).max(0.01);
        row(ui, "intensity", |ui| number(ui, &mut new.intensity, speed, 0.0..=1e9));
    });
    if ui.button("Remove").clicked() {
        commands.push(Command::Edit(Edit::RemoveLight(index)));
    } else if new != *old {
        commands.push(Command::Edit(Edit::Light(index, new)));
    }
}

fn place(ui: &mut Ui, place: &mut LightPlace) {
    match place {
        LightPlace::Point { position } => position_row(ui, position),
        LightPlace::Spot { position, direction, inner_degrees, outer_degrees } => {
            position_row(ui, position);
            row(ui, "direction", |ui| vector(ui, direction, 0.01));
            // The angle that is not changed gives way.
            row(ui, "inner angle", |ui| number(ui, inner_degrees, 0.2, 0.0..=90.0));
            *outer_degrees = outer_degrees.max(*inner_degrees);
            row(ui, "outer angle", |ui| number(ui, outer_degrees, 0.2, 0.0..=90.0));
            *inner_degrees = inner_degrees.min(*outer_degrees);
        }
        LightPlace::Directional { direction, angle_degrees } => {
            row(ui, "direction", |ui| vector(ui, direction, 0.01));
            row(ui, "angle", |ui| number(ui, angle_degrees, 0.02, 0.0..=180.0));
            // Below its smallest width a sun is no disk.
            if *angle_degrees < SMALLEST_DEGREES {
                *angle_degrees = 0.0;
            }
        }
    }
}

/// Least width of a sun that has one.
const SMALLEST_DEGREES: f32 = 0.01;

fn position_row(ui: &mut Ui, position: &mut Vec3) {
    let speed = step(position.length().max(1.0));
    row(ui, "position", |ui| vector(ui, position, speed));
}

/// Draws the menu of new lights. Points and spots are where the camera is, and shine as brightly on what it looks at as a sun
/// of irradiance 3.
fn add(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let camera = viewer.camera();
    let (position, way) = (camera.position, camera.look_at - camera.position);
    let direction = way.normalize_or(Vec3::NEG_Y);
    let intensity = (3.0 * way.length_squared()).clamp(1e-6, 1e9);
    let spot = LightPlace::Spot { position, direction, inner_degrees: 10.0, outer_degrees: 20.0 };
    let sun = LightPlace::Directional { direction: Vec3::new(-0.4, -0.8, -0.45).normalize(), angle_degrees: 0.53 };
    for (name, place, intensity) in
        [("Point", LightPlace::Point { position }, intensity), ("Spot", spot, intensity), ("Sun", sun, 3.0)]
    {
        if ui.button(name).clicked() {
            commands.push(Command::Edit(Edit::AddLight(LightEntry { place, color: Vec3::ONE, intensity })));
            ui.close();
        }
    }
}
