//! Lights that the kernels choose from: the emitters of a scene, the tree over them, the density of its sky.
//!
//! An emitter that is not listed is found by chance alone, as everything is where nothing can be chosen: infinite planes,
//! bodies that refract (their surface may be hidden inside another's), skies without an image.

mod bounds;
mod emitters;
mod sky;
mod tree;

use std::sync::Arc;

use raggio_kernels::{Emitter, EmitterKind, LIGHT_LEAF, LightNode, NO_TEXTURE, NONE, SceneBuffers, Texture};

use bounds::LightBounds;
use emitters::Listed;

/// Lights of a scene, kept from edit to edit: what has not changed is not built anew.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lights {
    bounds: Vec<LightBounds>,
    nodes: Arc<Vec<LightNode>>,
    sky: Option<KnownSky>,
}

/// A sky whose density is known.
#[derive(Clone, Debug)]
struct KnownSky {
    texels: Arc<Vec<u32>>,
    texture: Texture,
    intensity: f32,
    density: sky::Density,
}

impl Lights {
    /// Completes the buffers of a scene, in which everything else is in place.
    pub fn share(&mut self, buffers: &mut SceneBuffers) {
        let mut listed = emitters::surfaces(buffers, MOST_EMITTERS);
        // Suns are the last of the lights.
        emitters::lights(buffers, &mut listed);
        let Listed { mut emitters, mut bounds } = listed;
        let sky_emitter = emitters.len() as u32;
        let sky_power = self.share_sky(buffers);
        if sky_power > 0.0 {
            emitters.push(Emitter { kind: EmitterKind::Sky as u32, ..Emitter::default() });
            bounds.push(LightBounds::everywhere(sky_power));
        }
        bounds::normalize(&mut bounds);
        if bounds != self.bounds {
            self.nodes = Arc::new(tree::build(&bounds));
            self.bounds = bounds;
        }
        for (place, node) in (0..).zip(self.nodes.iter()) {
            if node.flags & LIGHT_LEAF != 0 {
                emitters[node.child as usize].leaf = place;
            }
        }
        let counts = &mut buffers.constants_mut().counts;
        counts.emitters = emitters.len() as u32;
        counts.sky_emitter = if sky_power > 0.0 { sky_emitter } else { NONE };
        counts.first_sun_emitter = if counts.suns > 0 { sky_emitter - counts.suns } else { NONE };
        buffers.emitters = emitters.into();
        buffers.light_nodes = self.nodes.clone();
    }

    /// Light that the sky's image sends beyond its mean; 0 if it is not sampled.
    fn share_sky(&mut self, buffers: &mut SceneBuffers) -> f32 {
        let sky = buffers.constants().sky;
        if sky.image == NO_TEXTURE {
            self.sky = None;
            return 0.0;
        }
        let (texture, texels) = (buffers.textures[sky.image as usize], buffers.texels.clone());
        let same = |known: &KnownSky| {
            Arc::ptr_eq(&known.texels, &texels) && known.texture == texture && known.intensity == sky.intensity
        };
        let known = match self.sky.take().filter(same) {
            Some(known) => known,
            None => {
                let density = sky::Density::new(&texture, &texels, sky.intensity);
                KnownSky { texels, texture, intensity: sky.intensity, density }
            }
        };
        buffers.sky_sums = known.density.sums.clone();
        let power = known.density.power;
        self.sky = Some(known);
        power
    }
}

/// Most surfaces that are listed; more are left to chance, for each takes some 120 bytes.
const MOST_EMITTERS: usize = 1 << 24;

/// Luminance of a linear colour with Rec. 709 primaries.
fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}
