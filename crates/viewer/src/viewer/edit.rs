//! Changes of the scene.

use raggio_scene::{Contents, Material};

use super::Viewer;
use crate::command::Edit;
use crate::document::{Document, EditError};
use crate::error::ViewError;

impl Viewer {
    pub(super) fn edit(&mut self, edit: Edit) -> Result<(), ViewError> {
        // All that a hand does to one control until it lets go is one step to undo.
        match &edit {
            Edit::Material(index, _) => self.document.begin_gesture(&format!("material {index}")),
            Edit::Shape(index, ..) | Edit::Model(index, ..) | Edit::Transform(index, _) => {
                self.document.begin_gesture(&format!("shape {index}"))
            }
            Edit::Light(index, _) => self.document.begin_gesture(&format!("light {index}")),
            Edit::Environment(_) => self.document.begin_gesture("environment"),
            Edit::Air(_) => self.document.begin_gesture("air"),
            Edit::Render(_) => self.document.begin_gesture("render"),
            _ => self.document.end_gesture(),
        }
        let mut added = None;
        self.change(|document| {
            Ok(match edit {
                Edit::Material(index, material) => document.set_material(index, &material)?,
                Edit::NewMaterial { shape } => {
                    let scene = document.scene();
                    let Some(entry) = scene.entries.get(shape).cloned() else { return Ok(false) };
                    let Some(current) = entry.material else { return Ok(false) };
                    let material = scene.materials[current].clone();
                    let copy = document.add_material(&material.name, &material)?;
                    match entry.contents {
                        Contents::Model(placement) => document.set_model(shape, &placement, Some(copy))?,
                        Contents::Geometry(geometry) => document.set_shape(shape, &geometry, copy)?,
                        Contents::Group(_) => document.set_group(shape, Some(copy))?,
                    }
                }
                Edit::Shape(index, geometry, material) => document.set_shape(index, &geometry, material)?,
                Edit::Model(index, placement, material) => document.set_model(index, &placement, material)?,
                Edit::Group(index, material) => document.set_group(index, material)?,
                Edit::Transform(index, transform) => document.set_transform(index, &transform)?,
                Edit::Add(geometry, material) => {
                    if document.scene().materials.is_empty() {
                        document.add_material("clay", &clay())?;
                    }
                    added = Some(document.add_shape(&geometry, material)?);
                    true
                }
                Edit::Light(index, light) => document.set_light(index, &light)?,
                Edit::AddLight(light) => {
                    document.add_light(&light)?;
                    true
                }
                Edit::RemoveLight(index) => document.remove_light(index)?,
                Edit::Environment(environment) => document.set_environment(&environment)?,
                Edit::Air(air) => document.set_air(air.as_ref())?,
                Edit::Camera(camera) => document.set_camera(&camera)?,
                Edit::Render(settings) => document.set_render(&settings)?,
                Edit::Key(key, value) => document.edit_path(&key, &value)?,
            })
        })?;
        self.select(added.or(self.selection));
        Ok(())
    }

    pub(super) fn undo(&mut self) -> Result<(), ViewError> {
        let mut undone = None;
        self.change(|document| {
            undone = document.undo();
            Ok(undone.is_some())
        })?;
        self.notices.done(undone.map_or("nothing to undo".into(), |name| format!("undone: {name}")));
        Ok(())
    }

    pub(super) fn redo(&mut self) -> Result<(), ViewError> {
        let mut redone = None;
        self.change(|document| {
            redone = document.redo();
            Ok(redone.is_some())
        })?;
        self.notices.done(redone.map_or("nothing to do again".into(), |name| format!("done again: {name}")));
        Ok(())
    }

    pub(super) fn remove_selected(&mut self) -> Result<(), ViewError> {
        let Some(shape) = self.selection else { return Ok(()) };
        self.select(None);
        self.change(|document| document.remove_shape(shape))
    }

    pub(super) fn duplicate_selected(&mut self) -> Result<(), ViewError> {
        let Some(shape) = self.selection else { return Ok(()) };
        let mut copy = None;
        self.change(|document| {
            copy = Some(document.duplicate_shape(shape)?);
            Ok(true)
        })?;
        self.select(copy);
        Ok(())
    }

    /// Lets `change` edit the document, which says whether it did, and shows the result. An edit that cannot be shown
    /// is taken back.
    pub(super) fn change(
        &mut self,
        change: impl FnOnce(&mut Document) -> Result<bool, EditError>,
    ) -> Result<(), ViewError> {
        let camera = self.document.scene().camera.clone();
        if !change(&mut self.document)? {
            return Ok(());
        }
        let scene = self.document.scene();
        // The camera moves only if the scene's own did.
        if scene.camera != camera {
            self.pilot.jump(scene.camera.clone());
        }
        self.reading = None;
        self.notices.warn_of_scene(&scene.warnings);
        let shown = self.tracer.set_scene(scene, self.pilot.camera());
        if let Err(error) = &shown
            && !error.is_device_lost()
        {
            self.document.undo();
        }
        self.select(self.selection);
        self.watch_scene();
        shown?;
        self.notices.forgive();
        Ok(())
    }
}

/// Material for the first shape of a scene that has none.
fn clay() -> Material {
    Material { name: "clay".into(), ..Material::default() }
}
