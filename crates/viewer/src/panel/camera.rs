//! Controls of the camera.

use egui::{DragValue, Label, Ui};
use raggio_scene::{Camera, Intrinsics, Projection};

use super::controls::{choose, number, row, step, table, vector};
use crate::command::{Command, Navigate};
use crate::viewer::Viewer;

/// Sides to look from: front, right, top and their opposites.
const SIDES: [(&str, [f32; 3]); 6] = [
    ("front", [0.0, 0.0, 1.0]),
    ("back", [0.0, 0.0, -1.0]),
    ("right", [1.0, 0.0, 0.0]),
    ("left", [-1.0, 0.0, 0.0]),
    ("top", [0.0, 1.0, 0.0]),
    ("bottom", [0.0, -1.0, 0.0]),
];

/// Draws the projection; intrinsics, which belong together, and panoramas are the file's to change.
fn projection(ui: &mut Ui, projection: &mut Projection) {
    match projection {
        Projection::Orthographic { height } => row(ui, "height", |ui| {
            let step = *height * 0.01;
            number(ui, height, step, 1e-9..=1e9)
                .on_hover_text("height of the picture in the scene's units: all rays are parallel")
        }),
        Projection::Perspective { vertical_fov_degrees } => row(ui, "field of view", |ui| {
            ui.add(
                DragValue::new(vertical_fov_degrees)
                    .speed(0.1)
                    .range(1.0..=170.0)
                    .clamp_existing_to_range(false)
                    .suffix(" °"),
            )
        }),
        Projection::Calibrated(Intrinsics {
            focal: [fx, fy],
            principal_point: [cx, cy],
            skew,
            size: [width, height],
        }) => row(ui, "intrinsics", |ui| {
            let skew = if *skew == 0.0 { String::new() } else { format!(", skew {skew}") };
            let text = format!("f {fx}, {fy}; c {cx}, {cy}{skew}; of {width} x {height}");
            ui.add(Label::new(text).wrap())
                .on_hover_text("focal lengths and principal point in pixels of a picture of that size")
        }),
        Projection::Panoramic(panorama) => row(ui, "panorama", |ui| ui.label(panorama.name())),
    };
}

/// Draws the lens.
fn lens(ui: &mut Ui, camera: &mut Camera, speed: f32) {
    row(ui, "aperture", |ui| {
        let step = (camera.aperture_radius * 0.02).max(speed * 0.02);
        number(ui, &mut camera.aperture_radius, step, 0.0..=1e6)
            .on_hover_text("radius of the lens: larger blurs what is not in focus")
    });
    row(ui, "focus", |ui| {
        number(ui, &mut camera.focus_distance, speed, 1e-4..=1e9)
            .on_hover_text("distance of what is sharp; F and a click set it to what is under the cursor")
    });
}

/// Draws the camera's numbers, and the controls of how hands move it.
pub fn show(ui: &mut Ui, viewer: &Viewer, commands: &mut Vec<Command>) {
    let mut camera = viewer.camera().clone();
    let speed = step((camera.look_at - camera.position).length());
    table(ui, "camera", |ui| {
        row(ui, "position", |ui| vector(ui, &mut camera.position, speed));
        row(ui, "look at", |ui| vector(ui, &mut camera.look_at, speed));
        projection(ui, &mut camera.projection);
        if !camera.is_panoramic() {
            lens(ui, &mut camera, speed);
        }
        row(ui, "mouse", |ui| {
            let mut preset = viewer.pilot.preset();
            choose(ui, "preset", &mut preset);
            if preset != viewer.pilot.preset() {
                commands.push(Command::Preset(preset));
            }
        });
        row(ui, "speed", |ui| {
            let mut speed = viewer.pilot.speed();
            let step = f64::from(speed) * 0.02;
            if ui
                .add(
                    DragValue::new(&mut speed)
                        .speed(step)
                        .range(1e-6..=1e9)
                        .clamp_existing_to_range(false)
                        .suffix(" units/s"),
                )
                .changed()
            {
                commands.push(Command::Speed(speed));
            }
        });
        row(ui, "from", |ui| {
            ui.vertical(|ui| {
                for sides in SIDES.chunks(3) {
                    ui.horizontal(|ui| {
                        for (name, direction) in sides {
                            if ui.small_button(*name).clicked() {
                                commands.push(Command::Navigate(Navigate::From(*direction)));
                            }
                        }
                    });
                }
            });
        });
        row(ui, "views", |ui| {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 3.0;
                for number in 1..=9 {
                    let response = ui.small_button(number.to_string());
                    if response.clicked() {
                        commands.push(Command::Navigate(Navigate::Recall(number)));
                    }
                    if response.on_hover_text("click goes there; the right button stores").secondary_clicked() {
                        commands.push(Command::Navigate(Navigate::Store(number)));
                    }
                }
            });
        });
    });
    ui.horizontal(|ui| {
        if ui.button("Home").on_hover_text("the scene's own camera").clicked() {
            commands.push(Command::Navigate(Navigate::Home));
        }
        if ui.button("Copy").on_hover_text("Ctrl+C: the camera as text").clicked() {
            commands.push(Command::CopyCamera);
        }
        if ui.button("Keep").on_hover_text("make this the scene's camera; saving does it too").clicked() {
            commands.push(Command::Edit(crate::command::Edit::Camera(camera.clone())));
        }
    });
    let usable = (camera.look_at - camera.position).length() > 1e-6;
    if camera != *viewer.camera() && usable {
        commands.push(Command::Navigate(Navigate::Jump(camera)));
    }
}
