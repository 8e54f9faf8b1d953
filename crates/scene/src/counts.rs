//! Counts of the things in a scene.

use std::collections::HashSet;
use std::ptr::from_ref;

use raggio_models::{Principled, Texture};

use crate::scene::{Environment, Geometry, Scene};

/// Counts of the things in a scene; shared ones count once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Number of triangles of all meshes.
    pub triangles: usize,
    /// Number of meshes, however often they are seen.
    pub meshes: usize,
    /// Number of shapes that show a mesh.
    pub instances: usize,
    /// Number of images of materials and of the environment.
    pub textures: usize,
}

/// Number and noun, in the plural where there is not just one: `1 sample`, `2 samples`.
pub fn counted(number: usize, noun: &str) -> String {
    let ending = match noun {
        _ if number == 1 => "",
        _ if noun.ends_with("sh") => "es",
        _ => "s",
    };
    format!("{number} {noun}{ending}")
}

impl Scene {
    /// Counts the things that take memory.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        let mut meshes = HashSet::new();
        for shape in &self.shapes {
            let Geometry::Mesh { mesh, .. } = &shape.geometry else { continue };
            counts.instances += 1;
            if meshes.insert(from_ref(mesh.as_ref())) {
                counts.triangles += mesh.triangles.len();
            }
        }
        let surfaces = self.materials.iter().filter_map(|material| material.principled.as_deref());
        let textures = surfaces.flat_map(textures).map(|texture| from_ref(texture.image.as_ref()));
        let sky = match &self.environment {
            Environment::Image { image, .. } => Some(from_ref(image.as_ref())),
            _ => None,
        };
        let images: HashSet<_> = textures.chain(sky).collect();
        Counts { meshes: meshes.len(), textures: images.len(), ..counts }
    }
}

fn textures(surface: &Principled) -> impl Iterator<Item = &Texture> {
    let textures = [
        &surface.base_color_texture,
        &surface.metallic_roughness_texture,
        &surface.normal_texture,
        &surface.emissive_texture,
        &surface.specular_texture,
        &surface.specular_color_texture,
        &surface.transmission_texture,
        &surface.diffuse_transmission_texture,
        &surface.diffuse_transmission_color_texture,
        &surface.clearcoat_texture,
        &surface.clearcoat_roughness_texture,
        &surface.clearcoat_normal_texture,
        &surface.sheen_color_texture,
        &surface.sheen_roughness_texture,
        &surface.anisotropy_texture,
        &surface.iridescence_texture,
        &surface.iridescence_thickness_texture,
    ];
    textures.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn nouns_agree_with_their_number() {
        assert_eq!(counted(0, "shape"), "0 shapes");
        assert_eq!(counted(1, "mesh"), "1 mesh");
        assert_eq!(counted(2, "mesh"), "2 meshes");
    }
}
