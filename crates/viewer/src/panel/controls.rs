//! Controls that several panels share.

use egui::{ComboBox, DragValue, Grid, Response, Ui};
use raggio_render::Choice;
use raggio_scene::Vec3;

/// A table of names and controls.
pub fn table(ui: &mut Ui, name: &str, rows: impl FnOnce(&mut Ui)) {
    Grid::new(name).num_columns(2).spacing([10.0, 5.0]).show(ui, rows);
}

/// A row of a [`table`].
pub fn row<T>(ui: &mut Ui, name: &str, control: impl FnOnce(&mut Ui) -> T) -> T {
    ui.label(egui::RichText::new(name).weak());
    let result = control(ui);
    ui.end_row();
    result
}

/// A menu of a choice's names; `id` is its own in the window.
pub fn choose<T: Choice>(ui: &mut Ui, id: &str, value: &mut T) {
    choose_in(ui, id, value, 150.0);
}

/// A choice among what there is, so many points wide.
pub fn choose_in<T: Choice>(ui: &mut Ui, id: &str, value: &mut T, width: f32) {
    ComboBox::from_id_salt(id).width(width).selected_text(value.name()).show_ui(ui, |ui| {
        for choice in T::ALL {
            ui.selectable_value(value, *choice, choice.name()).on_hover_text(choice.description());
        }
    });
}

/// A number that is dragged or typed; `speed` is for a point of the drag.
pub fn number(ui: &mut Ui, value: &mut f32, speed: f32, range: std::ops::RangeInclusive<f32>) -> Response {
    // A number out of range in a scene's file stays so until it is changed here.
    ui.add(DragValue::new(value).speed(speed).range(range).clamp_existing_to_range(false).max_decimals(6))
}

/// Three numbers side by side; true if one has changed.
pub fn vector(ui: &mut Ui, value: &mut Vec3, speed: f32) -> bool {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        let component = |ui: &mut Ui, x: &mut f32| {
            let drag = DragValue::new(x).speed(speed).max_decimals(5);
            ui.add_sized([58.0, 18.0], drag).changed()
        };
        let changed = [&mut value.x, &mut value.y, &mut value.z].map(|x| component(ui, x));
        changed.contains(&true)
    })
    .inner
}

/// A colour, each component 0 to 1, linear; true if it has changed.
pub fn color(ui: &mut Ui, value: &mut Vec3) -> bool {
    let mut rgb = value.to_array();
    let changed = ui.color_edit_button_rgb(&mut rgb).changed();
    if changed {
        *value = Vec3::from_array(rgb);
    }
    changed
}

/// Radiance: a colour whose components may be larger than 1.
pub fn radiance(ui: &mut Ui, value: &mut Vec3) -> bool {
    ui.horizontal(|ui| {
        let peak = value.max_element().max(1.0);
        let mut hue = *value / peak;
        let mut changed = color(ui, &mut hue);
        if changed {
            *value = hue * peak;
        }
        changed |= vector(ui, value, 0.01);
        *value = value.max(Vec3::ZERO);
        changed
    })
    .inner
}

/// Step of a length that is dragged: a hundredth of its size at a time.
pub fn step(value: f32) -> f32 {
    (value.abs() * 0.01).clamp(1e-5, 1e4)
}
