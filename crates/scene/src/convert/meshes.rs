//! Models: each of their instances becomes a shape; their materials and lights are taken along.

use std::collections::hash_map::Entry;
use std::path::PathBuf;
use std::sync::Arc;

use glam::DAffine3;
use raggio_images::Bitmap;
use raggio_models::{Light, LightKind, Principled};

use super::shapes::{Parts, below};
use super::transform::{map, scale};
use super::{Builder, Files, vec3};
use crate::assets::{Assets, Bounds, Imported, Trouble, can_be_undone};
use crate::fault::{Fault, Step, place};
use crate::file::MeshFile;
use crate::names;
use crate::number::LARGEST;
use crate::scene::{Geometry, Material, Placement};

impl Files<'_> {
    /// Image of that name: an absolute path stays as it is, others are relative to the scene's folder.
    pub(super) fn image(&mut self, name: &str, at: Vec<Step>) -> Result<Arc<Bitmap>, Fault> {
        let picture = self.read(name, at.clone(), Assets::image)?;
        if !picture.warnings.is_empty() && self.warned.insert(self.folder.join(name)) {
            let name = names::printable(name);
            let warn = |warning: &String| Fault::value(at.clone(), names::escaped(&format!("{name}: {warning}")));
            self.warnings.extend(picture.warnings.iter().map(warn));
        }
        Ok(picture.bitmap.clone())
    }

    pub(super) fn model(&mut self, mesh: &MeshFile, at: Vec<Step>) -> Result<Arc<Imported>, Fault> {
        let time_seconds = mesh.time.map(f64::from);
        self.read(&mesh.file, at, |assets, path| assets.model(path, time_seconds))
    }

    /// Reads a file, unless that has failed before: whoever names it many times does not wait many times.
    fn read<T>(
        &mut self,
        name: &str,
        at: Vec<Step>,
        read: impl FnOnce(&mut Assets, PathBuf) -> Result<Arc<T>, Trouble>,
    ) -> Result<Arc<T>, Fault> {
        let path = self.folder.join(name);
        let known = self.troubles.get(&path).cloned();
        let result = known.map_or_else(|| read(self.assets, path.clone()).map_err(|trouble| trouble.to_string()), Err);
        result.map_err(|trouble| {
            let message = format!("{}{trouble}", names::printable(name));
            self.troubles.insert(path, trouble);
            Fault::value(at, message)
        })
    }
}

impl Builder<'_, '_> {
    /// Shapes and lights of a model. `at` is the place in the file of the shape that names it; `material`, if there is one, covers
    /// all of the model.
    pub(super) fn model(
        &mut self,
        at: &[Step],
        mesh: &MeshFile,
        material: Option<usize>,
    ) -> Result<(Placement, Parts), Fault> {
        let of_mesh = below(at, "mesh");
        let file = below(&of_mesh, "file");
        let (placement, world_from_model) = placement(&of_mesh, mesh)?;
        let model = self.files.model(mesh, file.clone())?;
        if let Entry::Vacant(unknown) = self.first_materials.entry(Arc::as_ptr(&model)) {
            unknown.insert(None);
            let name = names::printable(&mesh.file);
            let warn = |warning: &String| Fault::value(file.clone(), names::escaped(&format!("{name}: {warning}")));
            self.warnings.extend(model.warnings.iter().map(warn));
        }
        let (material, first_material) = match material {
            Some(material) => (material, None),
            None => self.own_materials(at, mesh, &model)?,
        };
        let mut bounds = Bounds::EMPTY;
        let mut shapes = Vec::with_capacity(model.instances.len());
        for instance in &model.instances {
            let world_from_mesh = world_from_model * instance.model_from_mesh;
            if !can_be_undone(&world_from_mesh) {
                return Err(Fault::value(file, beyond(mesh)));
            }
            bounds = bounds.united(model.bounds_of(instance, &world_from_mesh));
            let geometry =
                Geometry::Mesh { mesh: model.meshes[instance.mesh].clone(), world_from_mesh, first_material };
            shapes.push((material, geometry));
        }
        if !model.instances.is_empty() && bounds.reach() > LARGEST {
            return Err(Fault::value(file, beyond(mesh)));
        }
        let lights = model.lights.iter().map(|light| placed(light, &world_from_model)).collect();
        Ok((placement, Parts { shapes, lights }))
    }

    /// Index of the material of parts without one, and that of the first of the others. A model's are added when it is
    /// met first.
    fn own_materials(
        &mut self,
        at: &[Step],
        mesh: &MeshFile,
        model: &Arc<Imported>,
    ) -> Result<(usize, Option<usize>), Fault> {
        if model.materials.is_empty() {
            let file = names::quoted(&mesh.file);
            let message = format!("`material` is missing {}: {file} has no materials of its own", place(at));
            return Err(Fault::value(at.to_vec(), message));
        }
        let materials = &mut self.scene.materials;
        let first = *self.first_materials.entry(Arc::as_ptr(model)).or_default().get_or_insert_with(|| {
            let first = materials.len();
            materials.extend(imported(&mesh.file, model));
            first
        });
        let bare = if model.has_bare_parts { first + model.materials.len() } else { first };
        Ok((bare, Some(first)))
    }
}

/// The model's materials, and one for parts that have none.
fn imported<'a>(file: &'a str, model: &'a Imported) -> impl Iterator<Item = Material> + 'a {
    let material = move |name: &str, surface: &Arc<Principled>| Material {
        name: format!("{file}/{name}"),
        principled: Some(surface.clone()),
        imported: true,
        ..Material::default()
    };
    let grey = Principled { base_color: [0.8; 3], ..Principled::default() };
    let bare = model.has_bare_parts.then(|| material("default", &Arc::new(grey)));
    let named = model.materials.iter().enumerate();
    let named = named.map(move |(place, (name, surface))| match name.as_str() {
        "" => material(&place.to_string(), surface),
        name => material(name, surface),
    });
    named.chain(bare)
}

/// Placement of the model, and in 64 bits the map T + R S p that it is.
fn placement(at: &[Step], mesh: &MeshFile) -> Result<(Placement, DAffine3), Fault> {
    let scale = scale(mesh.scale, at)?;
    let rotation_degrees = vec3(mesh.rotation_degrees);
    let map = map(mesh.translation, rotation_degrees, scale);
    let (translation, scale) = (vec3(mesh.translation), scale.as_vec3());
    Ok((Placement { file: mesh.file.clone(), translation, rotation_degrees, scale }, map))
}

fn beyond(mesh: &MeshFile) -> String {
    let file = names::printable(&mesh.file);
    format!("{file}: as it is placed here, it is too large or too small: keep all of it within 1e15 of the origin")
}

/// The light placed in the world. Lights of a model are scaled with it: lengths are multiplied by s, so intensity has
/// to be multiplied by s squared for everything to be lit as before.
pub(super) fn placed(light: &Light, world_from_model: &DAffine3) -> Light {
    let area = world_from_model.matrix3.determinant().abs().powf(2.0 / 3.0);
    let is_far = matches!(light.kind, LightKind::Directional | LightKind::Sun { .. });
    let gain = if is_far { 1.0 } else { area };
    Light {
        intensity: light.intensity.map(|component| (f64::from(component) * gain).min(f64::from(f32::MAX)) as f32),
        position: world_from_model.transform_point3(light.position),
        direction: world_from_model.transform_vector3(light.direction).normalize_or(light.direction),
        ..light.clone()
    }
}
