//! KHR_materials_pbrSpecularGlossiness, translated as KHR_materials_specular tells to: an infinite refractive index
//! leaves the specular colour alone to say what is reflected at normal incidence.

use std::sync::Arc;

use raggio_images::{Bitmap, Texels};

use super::{Translator, with_image};
use crate::error::Fault;
use crate::gltf::document::material::SpecularGlossiness;
use crate::material::Principled;

impl Translator<'_> {
    pub(super) fn specular_glossiness(
        &self,
        written: &SpecularGlossiness,
        surface: &mut Principled,
    ) -> Result<(), Fault> {
        let [red, green, blue, alpha] = written.diffuse_factor;
        surface.base_color = self.unit3("diffuseFactor", [red, green, blue]);
        surface.alpha = self.unit("diffuseFactor[3]", alpha);
        surface.base_color_texture = self.texture(written.diffuse_texture.as_ref())?;
        surface.metallic = 0.0;
        surface.ior = 0.0;
        surface.specular_color = self.unit3("specularFactor", written.specular_factor);
        let glossiness = self.unit("glossinessFactor", written.glossiness_factor);
        surface.roughness = 1.0 - glossiness;
        surface.metallic_roughness_texture = None;
        surface.specular_color_texture = self.texture(written.specular_glossiness_texture.as_ref())?;
        if let Some(texture) = &surface.specular_color_texture {
            let pixels = texture.image.texels.len();
            self.asset.budget.take(pixels, size_of::<[u16; 4]>(), format!("{}.glossiness", self.path))?;
            surface.metallic_roughness_texture =
                Some(with_image(texture, Arc::new(roughness_image(&texture.image, glossiness))));
            surface.roughness = 1.0;
        }
        Ok(())
    }
}

/// Roughness in G where the image has glossiness in A; float images have no A: it is 1.
fn roughness_image(image: &Bitmap, glossiness: f32) -> Bitmap {
    let roughness = |alpha: f32| 1.0 - glossiness * alpha;
    let texels = match &image.texels {
        Texels::Rgba8(texels) => {
            let byte = |alpha: u8| (255.0 * roughness(f32::from(alpha) / 255.0)).round() as u8;
            Texels::Rgba8(texels.iter().map(|[_, _, _, alpha]| [0, byte(*alpha), 0, 255]).collect())
        }
        Texels::Rgba16(texels) => {
            let word = |alpha: u16| (65535.0 * roughness(f32::from(alpha) / 65535.0)).round() as u16;
            Texels::Rgba16(texels.iter().map(|[_, _, _, alpha]| [0, word(*alpha), 0, u16::MAX]).collect())
        }
        Texels::Rgb32F(texels) => Texels::Rgb32F(vec![[0.0, roughness(1.0), 0.0]; texels.len()]),
    };
    Bitmap { width: image.width, height: image.height, texels }
}
