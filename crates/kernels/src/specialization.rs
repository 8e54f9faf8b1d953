//! What a scene has, for which pipelines of GPUs are specialised: see kernels/variant.slang.

use crate::layout::{EmitterKind, NO_TEXTURE, Part, Principled, SceneBuffers, ShapeKind};

/// Values of the specialization constants, each at the place of its number.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Specialization {
    /// The one [`Probe`](crate::Probe) that the kernel of probes answers.
    pub probe: u32,
    /// Kinds of shapes, in bits `1 << ShapeKind`.
    pub shape_kinds: u32,
    /// Kinds of emitters, in bits `1 << EmitterKind`.
    pub emitter_kinds: u32,
    /// Kinds of textures, in bits `1 << PrincipledTexture`.
    pub texture_kinds: u32,
    /// Parts, in bits `1 << Part`.
    pub parts: u32,
}

impl Specialization {
    /// Kernels that know all that scenes can have.
    pub const GENERAL: Self = Self { probe: 0, shape_kinds: !0, emitter_kinds: !0, texture_kinds: !0, parts: !0 };

    /// Kernels that know what `scene` has, and no more.
    pub fn of(scene: &SceneBuffers) -> Self {
        let Some(constants) = scene.constants.first() else { return Self::GENERAL };
        let (counts, sky) = (constants.counts, constants.sky);
        let kinds = |kinds: &mut dyn Iterator<Item = u32>| kinds.fold(0, |all, kind| all | 1 << kind);
        let any = |has: &dyn Fn(&Principled) -> bool| scene.principled.iter().any(has);
        let holes = scene.order.iter().any(|shape| shape.has_holes != 0)
            || scene.instances.iter().any(|instance| instance.has_holes != 0);
        let parts = [
            (Part::Hierarchy, !scene.nodes.is_empty() && counts.tried < counts.shapes),
            (Part::Holes, holes),
            (Part::Bodies, scene.materials.iter().any(|material| material.refractive_index > 0.0)),
            (Part::Absorption, counts.absorbing != 0),
            (Part::ClearSheets, counts.clear != 0),
            (Part::SkyImage, sky.image != NO_TEXTURE),
            (
                Part::Emission,
                scene.materials.iter().any(|material| material.emission != [0.0; 3])
                    || any(&|material| material.emissive != [0.0; 3]),
            ),
            (
                Part::DarkSky,
                counts.suns == 0
                    && [sky.horizon, sky.zenith] == [[0.0; 3]; 2]
                    && (sky.image == NO_TEXTURE || sky.intensity == 0.0),
            ),
            (Part::Media, scene.has_media()),
            (Part::Clearcoat, any(&|material| material.clearcoat > 0.0)),
            (Part::Sheen, any(&|material| material.sheen_color != [0.0; 3])),
            (Part::Iridescence, any(&|material| material.iridescence > 0.0)),
            (Part::Transmission, any(&|material| material.transmission > 0.0)),
            (Part::DiffuseTransmission, any(&|material| material.diffuse_transmission > 0.0)),
            (Part::Anisotropy, any(&|material| material.anisotropy != 0.0)),
        ];
        Self {
            probe: 0,
            shape_kinds: kinds(&mut scene.order.iter().map(|shape| shape.kind)),
            emitter_kinds: kinds(&mut scene.emitters.iter().map(|emitter| emitter.kind)),
            texture_kinds: scene.principled.iter().fold(0, |all, material| all | material.texture_kinds),
            parts: parts.into_iter().fold(0, |all, (part, is_there)| all | u32::from(is_there) << part as u32),
        }
    }

    /// Whether kernels with this specialization trace all that those with `other` do.
    pub fn covers(&self, other: &Self) -> bool {
        let masks = |of: &Self| [of.shape_kinds, of.emitter_kinds, of.texture_kinds, of.parts];
        self.probe == other.probe && masks(self).iter().zip(masks(other)).all(|(own, other)| own & other == other)
    }
}

const _: () = assert!(ShapeKind::ALL.len() <= 32 && EmitterKind::ALL.len() <= 32 && Part::ALL.len() <= 32);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn general_kernels_cover_all_and_others_what_they_know() {
        let general = Specialization::GENERAL;
        let spheres = Specialization { shape_kinds: 1 << ShapeKind::Sphere as u32, ..general };
        assert!(general.covers(&spheres) && spheres.covers(&spheres));
        assert!(!spheres.covers(&general));
        assert!(!general.covers(&Specialization { probe: 1, ..general }));
    }
}
