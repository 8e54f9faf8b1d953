//! Editor of a shape's material.

use egui::{ComboBox, DragValue, Slider, SliderClamping, Ui};
use raggio_scene::{Contents, Geometry, Material, Principled, Reflection, Scene, Texture};

use crate::command::{Command, Edit};
use crate::panel::controls::{color, number, row, table};
use crate::panel::scene::medium::medium;

/// Refractive index of a new dielectric, that of glass.
const GLASS: f32 = 1.5;

/// Draws the editor of a shape's material: the choice of it, and its properties.
pub fn show(ui: &mut Ui, scene: &Scene, shape: usize, commands: &mut Vec<Command>) {
    let current = scene.entries[shape].material;
    let mut chosen = current;
    ui.horizontal(|ui| {
        ui.strong("material");
        choice(ui, scene, scene.entries[shape].geometry().is_none(), &mut chosen);
        // A copy of any other kind would have to be written by hand.
        let plain = current.is_some_and(|index| scene.materials[index].principled.is_none());
        let button = ui.add_enabled(plain, egui::Button::new("New"));
        if button.on_hover_text("a copy of this material, for this shape alone").clicked() {
            commands.push(Command::Edit(Edit::NewMaterial { shape }));
        }
    });
    if chosen != current {
        commands.extend(painted(scene, shape, chosen).map(Command::Edit));
        return;
    }
    let Some(index) = current else { return own_materials(ui, scene, shape) };
    if let Some(surface) = &scene.materials[index].principled {
        return summary(ui, "principled", surface);
    }
    let mut material = scene.materials[index].clone();
    table(ui, "material", |ui| fields(ui, &mut material));
    if material != scene.materials[index] {
        commands.push(Command::Edit(Edit::Material(index, material)));
    }
}

const ITS_OWN: &str = "its own";

/// Draws the choice of a material of the scene's file; a model or a group may have its own instead.
fn choice(ui: &mut Ui, scene: &Scene, may_have_own: bool, chosen: &mut Option<usize>) {
    let name = chosen.map_or(ITS_OWN, |index| &scene.materials[index].name);
    ComboBox::from_id_salt("material").selected_text(name).show_ui(ui, |ui| {
        if may_have_own {
            ui.selectable_value(chosen, None, ITS_OWN);
        }
        for (index, material) in scene.materials.iter().enumerate().filter(|(_, material)| !material.imported) {
            ui.selectable_value(chosen, Some(index), &material.name);
        }
    });
}

fn painted(scene: &Scene, shape: usize, material: Option<usize>) -> Option<Edit> {
    Some(match &scene.entries[shape].contents {
        Contents::Model(placement) => Edit::Model(shape, placement.clone(), material),
        Contents::Group(_) => Edit::Group(shape, material),
        Contents::Geometry(geometry) => Edit::Shape(shape, geometry.clone(), material?),
    })
}

/// Draws a model's own materials, which come with its file, and are changed there.
fn own_materials(ui: &mut Ui, scene: &Scene, shape: usize) {
    let firsts = scene.shapes_of(shape).iter().filter_map(|shape| match &shape.geometry {
        Geometry::Mesh { mesh, first_material: Some(first), .. } => Some((mesh, *first)),
        _ => None,
    });
    let mut used: Vec<usize> = firsts
        .take(MOST_LISTED)
        .flat_map(|(mesh, first)| mesh.parts.iter().filter_map(move |part| Some(first + part.material?)))
        .collect();
    used.sort_unstable();
    used.dedup();
    for index in used.iter().take(MOST_LISTED) {
        if let Some(Material { name, principled: Some(surface), .. }) = scene.materials.get(*index) {
            ui.collapsing(name, |ui| summary(ui, name, surface));
        }
    }
    if used.len() > MOST_LISTED {
        ui.weak(format!("and {} more", used.len() - MOST_LISTED));
    }
}

/// Most materials that are listed; a longer list would help nobody.
const MOST_LISTED: usize = 32;

/// Draws the properties of a material that cannot be changed here.
fn summary(ui: &mut Ui, id: &str, surface: &Principled) {
    table(ui, id, |ui| {
        let mut line = |name: &str, value: String| row(ui, name, |ui| ui.label(value));
        let textured = |texture: &Option<Texture>| if texture.is_some() { " × texture" } else { "" };
        let [r, g, b] = surface.base_color;
        line("base color", format!("{r:.3} {g:.3} {b:.3}{}", textured(&surface.base_color_texture)));
        let both = textured(&surface.metallic_roughness_texture);
        line("metallic", format!("{:.3}{both}", surface.metallic));
        line("roughness", format!("{:.3}{both}", surface.roughness));
        if surface.transmission > 0.0 {
            line("transmission", format!("{:.3}{}", surface.transmission, textured(&surface.transmission_texture)));
            line("ior", format!("{:.3}", surface.ior));
        }
        if surface.emissive != [0.0; 3] {
            let [r, g, b] = surface.emissive;
            line("emissive", format!("{r:.3} {g:.3} {b:.3}{}", textured(&surface.emissive_texture)));
        }
    });
}

fn fields(ui: &mut Ui, material: &mut Material) {
    if material.is_seamless() {
        // A body without a surface has nothing else.
        medium(ui, &mut material.medium, false);
        row(ui, "priority", |ui| ui.add(DragValue::new(&mut material.priority).speed(0.1)));
        return;
    }
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
                // What lets no light in has nothing in it.
                material.medium = material.medium.filter(|_| dielectric);
            }
        });
    });
    if dielectric {
        row(ui, "reflection", |ui| reflection(ui, &mut material.reflection));
        row(ui, "priority", |ui| ui.add(DragValue::new(&mut material.priority).speed(0.1)));
        medium(ui, &mut material.medium, true);
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
