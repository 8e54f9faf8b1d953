//! A model as scenes use it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use raggio_models::{Animation, Camera, Instance, Light, Mesh, Model, Principled};

use super::cache::Depends;
use crate::counts::counted;
use crate::number::{BRIGHTEST, SMALLEST};

/// A model whose instances can all be drawn.
#[derive(Debug)]
pub(crate) struct Imported {
    pub meshes: Vec<Arc<Mesh>>,
    /// Instances of meshes with triangles, placed by maps that can be undone.
    pub instances: Vec<Instance>,
    /// Materials, with the names that the file gives them.
    pub materials: Vec<(String, Arc<Principled>)>,
    pub lights: Vec<Light>,
    pub cameras: Vec<Camera>,
    /// Animations of the file.
    pub animations: Vec<Animation>,
    /// Files that the model's own names and that were opened, by their canonical paths.
    pub files: Vec<PathBuf>,
    /// Paths at which such files were looked for in vain.
    pub missing: Vec<PathBuf>,
    /// Warnings, one sentence each, without the file's name.
    pub warnings: Vec<String>,
    /// Whether any part of an instance has no material of the file's.
    pub has_bare_parts: bool,
    /// Bounds of each mesh, in its own space.
    bounds: Vec<Bounds>,
}

impl Imported {
    pub(super) fn new(model: Model) -> Self {
        let Model { meshes, mut instances, materials, mut lights, animations, cameras, files, missing, mut warnings } =
            model;
        let bounds: Vec<Bounds> = meshes.iter().map(|mesh| Bounds::of(mesh)).collect();
        let in_file = instances.len();
        instances.retain(|instance| {
            let shows = meshes.get(instance.mesh).is_some_and(|mesh| !mesh.triangles.is_empty());
            shows && can_be_undone(&instance.model_from_mesh)
        });
        if instances.len() < in_file {
            let count = in_file - instances.len();
            let (have, were) = if count == 1 { ("has", "it was") } else { ("have", "they were") };
            let of = counted(in_file, "instance");
            warnings.push(format!("{count} of {of} {have} no triangles or no extent; {were} left out"));
        }
        let mut dimmed = lights.iter_mut().map(|light| dim(&mut light.intensity)).filter(|it| *it).count();
        let materials = materials.into_iter().map(|mut material| {
            dimmed += usize::from(dim(&mut material.surface.emissive));
            (material.name, Arc::new(material.surface))
        });
        let materials: Vec<_> = materials.collect();
        if dimmed > 0 {
            let (are, were) =
                if dimmed == 1 { ("light or material is", "was") } else { ("lights or materials are", "were") };
            warnings.push(format!("{dimmed} {are} brighter than 1e9, and {were} dimmed to that"));
        }
        let is_bare = |mesh: &Arc<Mesh>| mesh.parts.iter().any(|part| part.material.is_none());
        let bare: Vec<bool> = meshes.iter().map(is_bare).collect();
        let has_bare_parts = instances.iter().any(|instance| bare[instance.mesh]);
        Self {
            meshes,
            instances,
            materials,
            lights,
            cameras,
            animations,
            files,
            missing,
            warnings,
            has_bare_parts,
            bounds,
        }
    }

    /// The model, with the meshes and materials of the same file at another time in place of its own where they are equal:
    /// devices then keep what they hold of these.
    pub(super) fn sharing(mut self, earlier: &Self) -> Self {
        for (mesh, known) in self.meshes.iter_mut().zip(&earlier.meshes) {
            if !Arc::ptr_eq(mesh, known) && mesh == known {
                *mesh = known.clone();
            }
        }
        for ((_, material), (_, known)) in self.materials.iter_mut().zip(&earlier.materials) {
            if material == known {
                *material = known.clone();
            }
        }
        self
    }

    /// A box around an instance, which may be larger than need be.
    pub(crate) fn bounds_of(&self, instance: &Instance, world_from_mesh: &DAffine3) -> Bounds {
        self.bounds[instance.mesh].transformed(world_from_mesh)
    }
}

impl Depends for Imported {
    fn others(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().chain(&self.missing).map(PathBuf::as_path)
    }
}

/// Whether the map is finite and keeps volumes from vanishing.
pub(crate) fn can_be_undone(map: &DAffine3) -> bool {
    let determinant = map.matrix3.determinant();
    let inverse = map.inverse();
    map.is_finite() && determinant.is_normal() && inverse.matrix3.is_finite() && inverse.translation.is_finite()
}

/// Limits the brightness of a colour. Returns whether it was too bright, or no brightness at all.
fn dim(color: &mut [f32; 3]) -> bool {
    let most = BRIGHTEST as f32;
    let is_sound = color.iter().all(|component| (0.0..=most).contains(component));
    if !is_sound {
        *color = color.map(|component| if component.is_nan() { 0.0 } else { component.clamp(0.0, most) });
    }
    !is_sound
}

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    fn of(mesh: &Mesh) -> Self {
        mesh.positions.iter().fold(Self::EMPTY, |bounds, position| bounds.with(DVec3::from(position.map(f64::from))))
    }

    pub(crate) fn with(self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    pub(crate) fn united(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    fn transformed(self, map: &DAffine3) -> Self {
        let center = map.transform_point3(0.5 * (self.min + self.max));
        let half = 0.5 * (self.max - self.min);
        let axes = map.matrix3;
        let half = axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
        Self { min: center - half, max: center + half }
    }

    /// The largest coordinate of its points.
    pub(crate) fn reach(self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// The longest of its sides, but never nothing.
    pub(crate) fn size(self) -> f64 {
        (self.max - self.min).max_element().max(SMALLEST)
    }
}
