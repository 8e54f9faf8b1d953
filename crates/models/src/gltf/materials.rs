//! Translation of glTF's materials into ours, which have glTF's meaning: mostly from one name to the other.

mod glossiness;

use std::sync::Arc;

use super::asset::Asset;
use super::document::material::{AlphaMode as Alpha, MaterialExtensions, TextureInfo, Transform, Volume};
use super::document::{Material as Written, Sampler};
use super::fault::at;
use super::images::Images;
use crate::error::Fault;
use crate::material::{AlphaMode, Principled, Texture, TextureFilter, Wrap};
use crate::model::Material;

/// All materials of the document.
pub(super) fn translate(asset: &Asset<'_>, images: &Images) -> Result<Vec<Material>, Fault> {
    let translate = |(number, written): (usize, &Written)| {
        let translator = Translator { asset, images, path: format!("materials[{number}]") };
        Ok(Material { name: written.name.clone(), surface: translator.surface(written)? })
    };
    let materials = &asset.document.materials;
    asset.budget.take(materials.len(), size_of::<Material>(), "materials")?;
    materials.iter().enumerate().map(translate).collect()
}

struct Translator<'a> {
    asset: &'a Asset<'a>,
    images: &'a Images,
    /// Path of the material in the document.
    path: String,
}

impl Translator<'_> {
    fn surface(&self, written: &Written) -> Result<Principled, Fault> {
        let mut surface = self.core(written)?;
        let extensions = written.extensions();
        self.dielectric(extensions, &mut surface)?;
        self.transmission(extensions, &mut surface)?;
        self.layers(extensions, &mut surface)?;
        self.iridescence_and_anisotropy(extensions, &mut surface)?;
        if let Some(written) = &extensions.specular_glossiness {
            self.specular_glossiness(written, &mut surface)?;
        }
        if extensions.unlit.is_some() {
            make_unlit(&mut surface);
        }
        Ok(surface)
    }

    fn core(&self, written: &Written) -> Result<Principled, Fault> {
        let pbr = &written.pbr_metallic_roughness;
        let [red, green, blue, alpha] = pbr.base_color_factor;
        let strength = written.extensions().emissive_strength.as_ref().map_or(1.0, |e| e.emissive_strength);
        let emissive = self.positive3("emissiveFactor", written.emissive_factor)?;
        let strength = self.positive("emissiveStrength", strength)?;
        let cutoff = self.positive("alphaCutoff", written.alpha_cutoff)?;
        let normal_scale = self.scale("normalTexture.scale", written.normal_texture.as_ref())?;
        Ok(Principled {
            base_color: self.unit3("pbrMetallicRoughness.baseColorFactor", [red, green, blue]),
            base_color_texture: self.texture(pbr.base_color_texture.as_ref())?,
            alpha: self.unit("pbrMetallicRoughness.baseColorFactor[3]", alpha),
            alpha_mode: match written.alpha_mode {
                Alpha::Opaque => AlphaMode::Opaque,
                Alpha::Mask => AlphaMode::Mask(cutoff),
                Alpha::Blend => AlphaMode::Blend,
            },
            metallic: self.unit("pbrMetallicRoughness.metallicFactor", pbr.metallic_factor),
            roughness: self.unit("pbrMetallicRoughness.roughnessFactor", pbr.roughness_factor),
            metallic_roughness_texture: self.texture(pbr.metallic_roughness_texture.as_ref())?,
            normal_texture: self.texture(written.normal_texture.as_ref())?,
            normal_scale,
            emissive: emissive.map(|e| (e * strength).min(f32::MAX)),
            emissive_texture: self.texture(written.emissive_texture.as_ref())?,
            ..Principled::default()
        })
    }

    fn dielectric(&self, extensions: &MaterialExtensions, surface: &mut Principled) -> Result<(), Fault> {
        if let Some(written) = &extensions.ior {
            // 0 means infinite; nothing else below 1 means anything.
            surface.ior = if written.ior == 0.0 { 0.0 } else { self.within("ior", written.ior, 1.0, f32::MAX) };
        }
        if let Some(written) = &extensions.specular {
            surface.specular = self.unit("specularFactor", written.specular_factor);
            surface.specular_texture = self.texture(written.specular_texture.as_ref())?;
            surface.specular_color = self.positive3("specularColorFactor", written.specular_color_factor)?;
            surface.specular_color_texture = self.texture(written.specular_color_texture.as_ref())?;
        }
        if let Some(written) = &extensions.dispersion {
            surface.dispersion = self.positive("dispersion", written.dispersion)?;
        }
        Ok(())
    }

    fn transmission(&self, extensions: &MaterialExtensions, surface: &mut Principled) -> Result<(), Fault> {
        if let Some(written) = &extensions.transmission {
            surface.transmission = self.unit("transmissionFactor", written.transmission_factor);
            surface.transmission_texture = self.texture(written.transmission_texture.as_ref())?;
        }
        if let Some(written) = &extensions.diffuse_transmission {
            let factor = self.unit("diffuseTransmissionFactor", written.diffuse_transmission_factor);
            let color = self.unit3("diffuseTransmissionColorFactor", written.diffuse_transmission_color_factor);
            surface.diffuse_transmission = factor;
            surface.diffuse_transmission_texture = self.texture(written.diffuse_transmission_texture.as_ref())?;
            surface.diffuse_transmission_color = color;
            surface.diffuse_transmission_color_texture =
                self.texture(written.diffuse_transmission_color_texture.as_ref())?;
        }
        let none = Volume::default();
        let volume = extensions.volume.as_ref().unwrap_or(&none);
        let transmits = surface.transmission > 0.0 || surface.diffuse_transmission > 0.0;
        surface.thin_walled = transmits && volume.thickness_factor <= 0.0;
        surface.attenuation_color = self.unit3("attenuationColor", volume.attenuation_color);
        surface.attenuation_distance = volume.attenuation_distance;
        if volume.attenuation_distance <= 0.0 {
            // Programs that have no way to write infinity write this.
            self.warn("attenuationDistance", &format!("is {}: nothing is absorbed", volume.attenuation_distance));
            surface.attenuation_distance = f32::INFINITY;
        }
        if volume.thickness_texture.is_some() {
            self.warn("thicknessTexture", "is not used: the body is as thick as its surface makes it");
        }
        Ok(())
    }

    fn layers(&self, extensions: &MaterialExtensions, surface: &mut Principled) -> Result<(), Fault> {
        if let Some(written) = &extensions.clearcoat {
            let normal = written.clearcoat_normal_texture.as_ref();
            surface.clearcoat = self.unit("clearcoatFactor", written.clearcoat_factor);
            surface.clearcoat_texture = self.texture(written.clearcoat_texture.as_ref())?;
            surface.clearcoat_roughness = self.unit("clearcoatRoughnessFactor", written.clearcoat_roughness_factor);
            surface.clearcoat_roughness_texture = self.texture(written.clearcoat_roughness_texture.as_ref())?;
            surface.clearcoat_normal_texture = self.texture(normal)?;
            surface.clearcoat_normal_scale = self.scale("clearcoatNormalTexture.scale", normal)?;
        }
        if let Some(written) = &extensions.sheen {
            surface.sheen_color = self.unit3("sheenColorFactor", written.sheen_color_factor);
            surface.sheen_color_texture = self.texture(written.sheen_color_texture.as_ref())?;
            surface.sheen_roughness = self.unit("sheenRoughnessFactor", written.sheen_roughness_factor);
            surface.sheen_roughness_texture = self.texture(written.sheen_roughness_texture.as_ref())?;
        }
        Ok(())
    }

    fn iridescence_and_anisotropy(
        &self,
        extensions: &MaterialExtensions,
        surface: &mut Principled,
    ) -> Result<(), Fault> {
        if let Some(written) = &extensions.iridescence {
            let (minimum, maximum) = (written.iridescence_thickness_minimum, written.iridescence_thickness_maximum);
            surface.iridescence = self.unit("iridescenceFactor", written.iridescence_factor);
            surface.iridescence_texture = self.texture(written.iridescence_texture.as_ref())?;
            surface.iridescence_ior = self.within("iridescenceIor", written.iridescence_ior, 1.0, f32::MAX);
            surface.iridescence_thickness_minimum = self.positive("iridescenceThicknessMinimum", minimum)?;
            surface.iridescence_thickness_maximum = self.positive("iridescenceThicknessMaximum", maximum)?;
            surface.iridescence_thickness_texture = self.texture(written.iridescence_thickness_texture.as_ref())?;
        }
        if let Some(written) = &extensions.anisotropy {
            surface.anisotropy = self.unit("anisotropyStrength", written.anisotropy_strength);
            surface.anisotropy_rotation = self.finite("anisotropyRotation", written.anisotropy_rotation)?;
            surface.anisotropy_texture = self.texture(written.anisotropy_texture.as_ref())?;
        }
        Ok(())
    }

    fn texture(&self, info: Option<&TextureInfo>) -> Result<Option<Texture>, Fault> {
        let Some(info) = info else { return Ok(None) };
        let Some(image) = self.images.of_texture(self.asset, info.index) else { return Ok(None) };
        let transform = info.extensions.transform.as_deref();
        let uv_set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord);
        if uv_set > 1 {
            let message = format!("is left out: it uses TEXCOORD_{uv_set}, and only the sets 0 and 1 are read");
            self.asset.warnings.push(format!("{}: texture {} {message}", self.path, info.index));
            return Ok(None);
        }
        let rows = transform.map_or(Texture::IDENTITY, rows);
        if !rows.as_flattened().iter().all(|x| x.is_finite()) {
            return Err(at(&self.path, format!("the transform of texture {} should be finite", info.index)));
        }
        let texture = Texture { uv_set: uv_set as u8, transform: rows, ..Texture::new(image) };
        let sampler = self.asset.document.textures[info.index].sampler;
        Ok(Some(sampler.map_or(texture.clone(), |sampler| self.sampled(texture, sampler))))
    }

    fn sampled(&self, texture: Texture, number: usize) -> Texture {
        let Sampler { mag_filter, wrap_s, wrap_t } = self.asset.document.samplers[number];
        let warn = |key: &str, code: u32, default: &str| {
            self.asset
                .warnings
                .push(format!("samplers[{number}].{key} is {code}, which has no meaning: {default} is used"));
        };
        let wrap = |key: &str, code: Option<u32>| match code {
            Some(33071) => Wrap::ClampToEdge,
            Some(33648) => Wrap::MirroredRepeat,
            None | Some(10497) => Wrap::Repeat,
            Some(code) => {
                warn(key, code, "10497 (repeat)");
                Wrap::Repeat
            }
        };
        let filter = match mag_filter {
            Some(9728) => TextureFilter::Nearest,
            None | Some(9729) => TextureFilter::Linear,
            Some(code) => {
                warn("magFilter", code, "9729 (linear)");
                TextureFilter::Linear
            }
        };
        Texture { wrap: [wrap("wrapS", wrap_s), wrap("wrapT", wrap_t)], filter, ..texture }
    }

    fn warn(&self, name: &str, message: &str) {
        self.asset.warnings.push(format!("{}.{name} {message}", self.path));
    }

    /// The value within a range, clamped with a warning.
    fn within(&self, name: &str, value: f32, low: f32, high: f32) -> f32 {
        let clamped = value.clamp(low, high);
        if value != clamped {
            self.warn(name, &format!("is {value}: {clamped} is used instead"));
        }
        clamped
    }

    fn unit(&self, name: &str, value: f32) -> f32 {
        self.within(name, value, 0.0, 1.0)
    }

    fn unit3(&self, name: &str, value: [f32; 3]) -> [f32; 3] {
        value.map(|value| self.unit(name, value))
    }

    fn finite(&self, name: &str, value: f32) -> Result<f32, Fault> {
        if value.is_finite() { Ok(value) } else { Err(at(format!("{}.{name}", self.path), "should be finite")) }
    }

    /// The value, clamped with a warning to be not negative and finite.
    fn positive(&self, name: &str, value: f32) -> Result<f32, Fault> {
        Ok(self.within(name, self.finite(name, value)?, 0.0, f32::MAX))
    }

    fn positive3(&self, name: &str, value: [f32; 3]) -> Result<[f32; 3], Fault> {
        let [a, b, c] = value.map(|value| self.positive(name, value));
        Ok([a?, b?, c?])
    }

    fn scale(&self, name: &str, info: Option<&TextureInfo>) -> Result<f32, Fault> {
        self.finite(name, info.and_then(|info| info.scale).unwrap_or(1.0))
    }
}

/// Rows of the map that scales, then rotates, then offsets. The rotation is counter-clockwise as one looks at an image
/// whose v runs downwards, as the extension's example has it.
fn rows(transform: &Transform) -> [[f32; 3]; 2] {
    let (sine, cosine) = transform.rotation.sin_cos();
    let ([x, y], [u, v]) = (transform.scale, transform.offset);
    [[x * cosine, y * sine, u], [-x * sine, y * cosine, v]]
}

/// Makes a material unlit (KHR_materials_unlit): the reflected colour is emitted, that of vertices included, and nothing is
/// reflected. The texture stays for its alpha.
fn make_unlit(surface: &mut Principled) {
    *surface = Principled {
        base_color: [0.0; 3],
        base_color_texture: surface.base_color_texture.clone(),
        alpha: surface.alpha,
        alpha_mode: surface.alpha_mode,
        emissive: surface.base_color,
        emissive_texture: surface.base_color_texture.clone(),
        emissive_by_vertex_color: true,
        specular: 0.0,
        ..Principled::default()
    };
}

/// The texture with `image` in place of its own, which textures that are otherwise alike may share.
fn with_image(texture: &Texture, image: Arc<raggio_images::Bitmap>) -> Texture {
    Texture { image, ..texture.clone() }
}
