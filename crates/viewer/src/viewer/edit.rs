//! Changes of the scene.

use raggio_scene::{Material, Reflection, Vec3};

use super::Viewer;
use crate::command::Edit;
use crate::document::{Document, EditError};
use crate::error::ViewError;

impl Viewer {
    pub(super) fn edit(&mut self, edit: Edit) -> Result<(), ViewError> {
        // All that a hand does to one control until it lets go is one step to undo.
        match &edit {
            Edit::Material(index, _) => self.document.begin_gesture(&format!("material {index}")),
            Edit::Shape(index, ..) => self.document.begin_gesture(&format!("shape {index}")),
            Edit::Environment(_) => self.document.begin_gesture("environment"),
            Edit::Render(_) => self.document.begin_gesture("render"),
            _ => self.document.end_gesture(),
        }
        let mut added = None;
        self.change(|document| {
            Ok(match edit {
                Edit::Material(index, material) => document.set_material(index, &material)?,
                Edit::NewMaterial { shape } => {
                    let Some(current) = document.scene().shapes.get(shape).cloned() else { return Ok(false) };
                    let material = document.scene().materials[current.material].clone();
                    let copy = document.add_material(&material.name, &material)?;
                    document.set_shape(shape, &current.geometry, copy)?
                }
                Edit::Shape(index, geometry, material) => document.set_shape(index, &geometry, material)?,
                Edit::Add(geometry, material) => {
                    if document.scene().materials.is_empty() {
                        document.add_material("clay", &clay())?;
                    }
                    added = Some(document.add_shape(&geometry, material)?);
                    true
                }
                Edit::Environment(environment) => document.set_environment(&environment)?,
                Edit::Camera(camera) => document.set_camera(&camera)?,
                Edit::Render(settings) => document.set_render(&settings)?,
                Edit::Key(key, value) => document.edit_path(&key, &value)?,
            })
        })?;
        self.selection = added.or(self.selection);
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
        let Some(shape) = self.selection.take() else { return Ok(()) };
        self.change(|document| document.remove_shape(shape))
    }

    pub(super) fn duplicate_selected(&mut self) -> Result<(), ViewError> {
        let Some(shape) = self.selection else { return Ok(()) };
        let mut copy = None;
        self.change(|document| {
            copy = Some(document.duplicate_shape(shape)?);
            Ok(true)
        })?;
        self.selection = copy;
        Ok(())
    }

    /// Lets `change` edit the document, which says whether it did, and shows the result. What cannot be shown is taken
    /// back.
    pub(super) fn change(
        &mut self,
        change: impl FnOnce(&mut Document) -> Result<bool, EditError>,
    ) -> Result<(), ViewError> {
        let camera = self.document.scene().camera.clone();
        if !change(&mut self.document)? {
            return Ok(());
        }
        let scene = self.document.scene();
        // It moves only if the scene's own camera did.
        if scene.camera != camera {
            self.pilot.jump(scene.camera.clone());
        }
        self.reading = None;
        self.selection = self.selection.filter(|shape| *shape < scene.shapes.len());
        self.notices.warn_of_scene(&scene.warnings);
        if let Err(error) = self.tracer.set_scene(scene, self.pilot.camera()) {
            if !error.is_device_lost() {
                self.document.undo();
            }
            return Err(error);
        }
        self.notices.forgive();
        Ok(())
    }
}

/// For the first shape of a scene that has nothing to make it of.
fn clay() -> Material {
    Material {
        name: "clay".into(),
        color: Vec3::splat(0.8),
        emission_color: Vec3::ONE,
        emission_strength: 0.0,
        smoothness: 0.0,
        refractive_index: None,
        reflection: Reflection::Fresnel,
        priority: 0,
    }
}
