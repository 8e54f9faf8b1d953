//! Edits that take the scene's plain data and touch only the keys whose values change.

use raggio_scene::{
    Camera, Environment, Geometry, LightEntry, Material, Medium, Placement, RenderSettings, Scene, Transform,
};
use toml_edit::{DocumentMut, InlineTable, Item, Table, Value};

use super::error::item;
use super::fields::{self, Field};
use super::lists::{self, LIGHTS, SHAPES};
use super::{Document, EditError, tree};

/// Edits that return whether the text changed, or the index of what they added; a new value equal to the old one is no
/// change and no step to undo.
///
/// Every edit fails with [`EditError::Scene`] when the result would not be a valid scene, and with
/// [`EditError::Missing`] when an index is out of range; nothing changes then.
impl Document {
    /// Moves the camera. `focus_distance` stays out of a file that does not have it while it is the distance of the
    /// point looked at, and what keyframes say stays as they say it.
    pub fn set_camera(&mut self, new: &Camera) -> Result<bool, EditError> {
        self.edit("camera", |toml, scene| {
            let has_focus = toml.get("camera").is_some_and(|camera| camera.get("focus_distance").is_some());
            let follows = !has_focus && ["position", "look_at"].iter().any(|key| is_keyed(toml, key));
            let mut fields = fields::camera(&scene.camera, new);
            fields.retain(|field| !(is_keyed(toml, field.key) || follows && field.key == "focus_distance"));
            write_section(toml, "camera", &fields);
            Ok(())
        })
    }

    /// Changes a material, all but its name.
    pub fn set_material(&mut self, index: usize, new: &Material) -> Result<bool, EditError> {
        let old = item(&self.scene.materials, index, "material")?;
        let name = format!("material {}", old.name);
        self.edit(&name, |toml, scene| {
            let old = item(&scene.materials, index, "material")?;
            let table = toml.get_mut("materials").and_then(|materials| tree::child(materials, &old.name));
            if let Some(table) = table {
                tree::write_fields(table, &fields::material(old, new));
                if let (Some(old), Some(new), Some(medium)) = (&old.medium, &new.medium, tree::child(table, "medium")) {
                    tree::write_fields(medium, &fields::medium(old, new));
                }
            }
            Ok(())
        })
    }

    /// Adds a material and returns its index. Where `name` is taken (or empty) a free one like it is given.
    pub fn add_material(&mut self, name: &str, material: &Material) -> Result<usize, EditError> {
        let name = free_name(&self.scene, name);
        self.edit(&format!("add material {name}"), |toml, _| {
            add_material(toml, &name, &fields::material(material, material));
            Ok(())
        })?;
        let place = self.scene.materials.iter().position(|material| material.name == name);
        place.ok_or(EditError::Missing { what: "material", index: 0, count: self.scene.materials.len() })
    }

    /// Changes the geometry of a shape that is no model, which may become one of another kind, and its material. Shapes
    /// are counted as in the file.
    pub fn set_shape(&mut self, index: usize, new: &Geometry, material: usize) -> Result<bool, EditError> {
        let name = change_of_shape(&self.scene, index, new)?;
        self.edit(&name, |toml, scene| {
            let old = item(&scene.entries, index, "shape")?;
            let named = item(&scene.materials, material, "material")?;
            let Some(table) = lists::entry(toml, SHAPES, index) else { return Ok(()) };
            if Some(material) != old.material {
                paint(table, Some(&named.name));
            }
            if let Some(old) = old.geometry() {
                write_geometry(table, old, new);
            }
            Ok(())
        })
    }

    /// Moves a model, and gives it a material, or with `None` its own.
    pub fn set_model(&mut self, index: usize, new: &Placement, material: Option<usize>) -> Result<bool, EditError> {
        let entry = item(&self.scene.entries, index, "shape")?;
        let moves = entry.placement() != Some(new);
        self.edit(if moves { "move mesh" } else { "paint mesh" }, |toml, scene| {
            let old = item(&scene.entries, index, "shape")?;
            let named = material.map(|index| item(&scene.materials, index, "material")).transpose()?;
            let Some(table) = lists::entry(toml, SHAPES, index) else { return Ok(()) };
            if material != old.material {
                paint(table, named.map(|material| material.name.as_str()));
            }
            if let (Some(old), Some(mesh)) = (old.placement(), tree::child(table, "mesh")) {
                tree::write_fields(mesh, &fields::placement(old, new));
            }
            Ok(())
        })
    }

    /// Gives all shapes of a group one material, or with `None` their own.
    pub fn set_group(&mut self, index: usize, material: Option<usize>) -> Result<bool, EditError> {
        self.edit("paint group", |toml, scene| {
            let old = item(&scene.entries, index, "shape")?;
            let named = material.map(|index| item(&scene.materials, index, "material")).transpose()?;
            let Some(table) = lists::entry(toml, SHAPES, index) else { return Ok(()) };
            if material != old.material {
                paint(table, named.map(|material| material.name.as_str()));
            }
            Ok(())
        })
    }

    /// Changes the transform of a shape or of a group. One that changes nothing need not be in the file.
    pub fn set_transform(&mut self, index: usize, new: &Transform) -> Result<bool, EditError> {
        let kind = kind_of(&self.scene, index)?;
        self.edit(&format!("transform {kind}"), |toml, scene| {
            let old = item(&scene.entries, index, "shape")?;
            let Some(table) = lists::entry(toml, SHAPES, index) else { return Ok(()) };
            if let Some(transform) = tree::child(table, "transform") {
                tree::write_fields(transform, &fields::transform(&old.transform, new));
            } else if *new != Transform::IDENTITY {
                tree::insert(table, "transform", tree::inline_table(&fields::transform(new, new)));
            }
            Ok(())
        })
    }

    /// Adds a shape and returns its index, which is the last.
    pub fn add_shape(&mut self, geometry: &Geometry, material: usize) -> Result<usize, EditError> {
        self.edit(&format!("add {}", geometry.key()), |toml, scene| {
            let named = item(&scene.materials, material, "material")?;
            let mut table = Item::Value(InlineTable::new().into());
            tree::insert(&mut table, "material", named.name.as_str().into());
            tree::insert(&mut table, geometry.key(), tree::inline_table(&fields::geometry(geometry, geometry)));
            if let Item::Value(Value::InlineTable(table)) = table {
                lists::push(toml, SHAPES, table);
            }
            Ok(())
        })?;
        Ok(self.scene.entries.len().saturating_sub(1))
    }

    /// Removes a shape, with the comments right before it. Its material stays.
    pub fn remove_shape(&mut self, index: usize) -> Result<bool, EditError> {
        let name = format!("remove {}", kind_of(&self.scene, index)?);
        self.edit(&name, |toml, _| {
            lists::remove(toml, SHAPES, index);
            Ok(())
        })
    }

    /// Adds a copy of a shape in the same place and returns its index, which is the last.
    pub fn duplicate_shape(&mut self, index: usize) -> Result<usize, EditError> {
        let name = format!("duplicate {}", kind_of(&self.scene, index)?);
        self.edit(&name, |toml, _| {
            lists::push_copy(toml, SHAPES, index);
            Ok(())
        })?;
        Ok(self.scene.entries.len().saturating_sub(1))
    }

    /// Changes a light of the file, which may become one of another kind.
    pub fn set_light(&mut self, index: usize, new: &LightEntry) -> Result<bool, EditError> {
        let kind = item(&self.scene.light_entries, index, "light")?.place.key();
        self.edit(&format!("{kind} light"), |toml, scene| {
            let old = item(&scene.light_entries, index, "light")?;
            let Some(table) = lists::entry(toml, LIGHTS, index) else { return Ok(()) };
            let (old_key, new_key) = (old.place.key(), new.place.key());
            if old_key != new_key {
                tree::remove(table, old_key);
                tree::insert(table, new_key, tree::inline_table(&fields::light(new, new)));
            } else if let Some(table) = tree::child(table, old_key) {
                tree::write_fields(table, &fields::light(old, new));
            }
            Ok(())
        })
    }

    /// Adds a light and returns its index among those of the file, which is the last.
    pub fn add_light(&mut self, light: &LightEntry) -> Result<usize, EditError> {
        self.edit(&format!("add {} light", light.place.key()), |toml, _| {
            let mut table = Item::Value(InlineTable::new().into());
            tree::insert(&mut table, light.place.key(), tree::inline_table(&fields::light(light, light)));
            if let Item::Value(Value::InlineTable(table)) = table {
                lists::push(toml, LIGHTS, table);
            }
            Ok(())
        })?;
        Ok(self.scene.light_entries.len().saturating_sub(1))
    }

    /// Removes a light of the file, with the comments right before it.
    pub fn remove_light(&mut self, index: usize) -> Result<bool, EditError> {
        let kind = item(&self.scene.light_entries, index, "light")?.place.key();
        self.edit(&format!("remove {kind} light"), |toml, _| {
            lists::remove(toml, LIGHTS, index);
            Ok(())
        })
    }

    /// Changes the light from outside. A file without `[environment]` gets one when it is no longer black.
    pub fn set_environment(&mut self, new: &Environment) -> Result<bool, EditError> {
        self.edit("environment", |toml, scene| {
            if *new != scene.environment {
                write_section(toml, "environment", &fields::environment(&scene.environment, new));
            }
            Ok(())
        })
    }

    /// Changes the medium that fills the scene, or with `None` takes it away.
    pub fn set_air(&mut self, new: Option<&Medium>) -> Result<bool, EditError> {
        self.edit("air", |toml, scene| {
            match new {
                None => drop(toml.remove("air")),
                Some(new) if Some(new) == scene.air.as_ref() => {}
                Some(new) => write_section(toml, "air", &fields::medium(&scene.air.unwrap_or_default(), new)),
            }
            Ok(())
        })
    }

    /// Changes size and quality of the picture.
    pub fn set_render(&mut self, new: &RenderSettings) -> Result<bool, EditError> {
        self.edit("render settings", |toml, scene| {
            if *new != scene.render {
                write_section(toml, "render", &fields::render(&scene.render, new));
            }
            Ok(())
        })
    }
}

/// Whether a keyframe of the camera has this key.
fn is_keyed(toml: &DocumentMut, key: &str) -> bool {
    match toml.get("camera").and_then(|camera| camera.get("keyframes")) {
        Some(Item::ArrayOfTables(keyframes)) => keyframes.iter().any(|keyframe| keyframe.contains_key(key)),
        Some(Item::Value(Value::Array(keyframes))) => {
            keyframes.iter().filter_map(Value::as_inline_table).any(|keyframe| keyframe.contains_key(key))
        }
        _ => false,
    }
}

fn write_section(toml: &mut DocumentMut, key: &str, fields: &[Field]) {
    tree::write_fields(section(toml, key), fields);
}

/// The scene's table of this key; if it is not there it is added beside that of the camera, which every scene has.
pub(super) fn section<'a>(toml: &'a mut DocumentMut, key: &str) -> &'a mut Item {
    let camera = toml.get("camera").and_then(Item::as_table).and_then(Table::position);
    // Two tables may have one place: the one that was added is written last.
    let place = camera.map(|place| if key == "render" { place - 1 } else { place });
    toml.entry(key).or_insert_with(|| {
        let mut table = Table::new();
        table.set_position(place);
        Item::Table(table)
    })
}

/// Adds a material in the form in which the last one is written.
fn add_material(toml: &mut DocumentMut, name: &str, fields: &[Field]) {
    let materials = toml.entry("materials").or_insert_with(|| {
        let mut table = Table::new();
        table.set_implicit(true);
        Item::Table(table)
    });
    let has_header = |item: &Item| item.as_table().is_some_and(|table| !table.is_dotted());
    match materials {
        Item::Table(table) if !table.is_dotted() && table.iter().last().is_none_or(|(_, last)| has_header(last)) => {
            table.insert(name, tree::table(fields));
        }
        _ => tree::insert(materials, name, tree::inline_table(fields)),
    }
}

/// A name that no material has: `name`, or `name_2`, `name_3` and so on.
fn free_name(scene: &Scene, name: &str) -> String {
    let is_free = |name: &str| scene.materials.iter().all(|material| material.name != name);
    let name = if name.trim().is_empty() { "material" } else { name.trim() };
    if is_free(name) {
        return name.to_string();
    }
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let stem = stem.strip_suffix('_').filter(|stem| !stem.is_empty() && stem.len() + 1 < name.len()).unwrap_or(name);
    let mut names = (2..=scene.materials.len() + 2).map(|number| format!("{stem}_{number}"));
    names.find(|name| is_free(name)).unwrap_or_else(|| stem.to_string())
}

/// The key of a shape's geometry; shapes are counted as in the file.
fn kind_of(scene: &Scene, index: usize) -> Result<&'static str, EditError> {
    Ok(item(&scene.entries, index, "shape")?.key())
}

/// Gives a shape the material of this name, or none.
fn paint(shape: &mut Item, material: Option<&str>) {
    match (material, tree::child(shape, "material")) {
        (Some(name), Some(Item::Value(value))) => tree::replace(value, name.into()),
        (Some(name), None) => tree::insert(shape, "material", name.into()),
        (None, Some(_)) => tree::remove(shape, "material"),
        _ => {}
    }
}

/// Name of a shape's change, for undo.
fn change_of_shape(scene: &Scene, index: usize, new: &Geometry) -> Result<String, EditError> {
    let entry = item(&scene.entries, index, "shape")?;
    let Some(old) = entry.geometry() else { return Ok(format!("change {}", entry.key())) };
    let verb = if old == new {
        "paint"
    } else if fields::is_moved(old, new) {
        "move"
    } else {
        "change"
    };
    Ok(format!("{verb} {}", old.key()))
}

fn write_geometry(shape: &mut Item, old: &Geometry, new: &Geometry) {
    if old.key() != new.key() {
        tree::remove(shape, old.key());
        tree::insert(shape, new.key(), tree::inline_table(&fields::geometry(new, new)));
    } else if let Some(table) = tree::child(shape, old.key()) {
        tree::write_fields(table, &fields::geometry(old, new));
    }
}
