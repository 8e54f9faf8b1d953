//! What a shape is made of.

use egui::{ComboBox, DragValue, Slider, SliderClamping, Ui};
use raggio_scene::{Material, Reflection, Scene};

use crate::command::{Command, Edit};
use crate::panel::controls::{color, number, row, table};

/// What a new dielectric is made of.
const GLASS: f32 = 1.5;

/// The material of a shape: which, and what it is like.
pub fn show(ui: &mut Ui, scene: &Scene, shape: usize, commands: &mut Vec<Command>) {
    let current = &scene.shapes[shape];
    let mut index = current.material;
    ui.horizontal(|ui| {
        ui.strong("material");
        ComboBox::from_id_salt("material").selected_text(&scene.materials[index].name).show_ui(ui, |ui| {
            for (i, material) in scene.materials.iter().enumerate() {
                ui.selectable_value(&mut index, i, &material.name);
            }
        });
        if ui.button("New").on_hover_text("a copy of this material, for this shape alone").clicked() {
            commands.push(Command::Edit(Edit::NewMaterial { shape }));
        }
    });
    if index != current.material {
        commands.push(Command::Edit(Edit::Shape(shape, current.geometry.clone(), index)));
        return;
    }
    let mut material = scene.materials[index].clone();
    table(ui, "material", |ui| fields(ui, &mut material));
    if material != scene.materials[index] {
        commands.push(Command::Edit(Edit::Material(index, material)));
    }
}

fn fields(ui: &mut Ui, material: &mut Material) {
    row(ui, "color", |ui| color(ui, &mut material.color));
    row(ui, "emission", |ui| {
        ui.horizontal(|ui| {
            let mut hue = material.emission_color.clamp(raggio_scene::Vec3::ZERO, raggio_scene::Vec3::ONE);
            if color(ui, &mut hue) {
                material.emission_color = hue;
            }
            let speed = (material.emission_strength * 0.01).max(0.01);
            number(ui, &mut material.emission_strength, speed, 0.0..=1e9);
        });
    });
    let mut dielectric = material.refractive_index.is_some();
    row(ui, "smoothness", |ui| {
        ui.add_enabled(
            !dielectric,
            Slider::new(&mut material.smoothness, 0.0..=1.0).clamping(SliderClamping::Edits).max_decimals(3),
        )
    });
    row(ui, "dielectric", |ui| {
        ui.horizontal(|ui| {
            let mut value = material.refractive_index.unwrap_or(GLASS);
            let mut changed = ui.checkbox(&mut dielectric, "").changed();
            changed |= ui.add_enabled_ui(dielectric, |ui| number(ui, &mut value, 0.005, 0.1..=10.0).changed()).inner;
            if changed {
                material.refractive_index = dielectric.then_some(value);
            }
        });
    });
    if dielectric {
        row(ui, "reflection", |ui| reflection(ui, &mut material.reflection));
        row(ui, "priority", |ui| ui.add(DragValue::new(&mut material.priority).speed(0.1)));
    }
}

fn reflection(ui: &mut Ui, reflection: &mut Reflection) {
    ui.horizontal(|ui| {
        let mut fresnel = *reflection == Reflection::Fresnel;
        if ui.checkbox(&mut fresnel, "Fresnel").changed() {
            *reflection = if fresnel { Reflection::Fresnel } else { Reflection::Probability(0.1) };
        }
        if let Reflection::Probability(probability) = reflection {
            number(ui, probability, 0.005, 0.0..=1.0);
        }
    });
}
