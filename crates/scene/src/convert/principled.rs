//! The principled material and its textures.

use std::sync::Arc;

use raggio_images::{Bitmap, Texels};
use raggio_models::{AlphaMode, Principled, Texture, TextureFilter, Wrap};

use super::Files;
use crate::fault::{Fault, steps};
use crate::file::{
    AlphaModeFile, Color, PrincipledFile, SurfaceColor, TextureFile, TextureFilterFile, TextureTable, WrapFile,
    WrapName,
};
use crate::names;
use crate::number::BRIGHTEST;

/// Principled material of the material called `name`; faults are noted.
pub(super) fn principled(
    name: &str,
    file: &PrincipledFile,
    files: &mut Files<'_>,
    warnings: &mut Vec<Fault>,
) -> Principled {
    warn_of_alpha(name, file, warnings);
    let review = files.review;
    let mut load = |key: &str, file: &Option<TextureFile>| {
        file.as_ref().and_then(|file| review.accept(texture(name, key, &file.0, files)))
    };
    let default = Principled::default();
    Principled {
        base_color: color(file.base_color, [1.0; 3]),
        base_color_texture: load("base_color_texture", &file.base_color_texture),
        alpha: number(file.alpha, 1.0),
        alpha_mode: alpha_mode(file),
        metallic: number(file.metallic, beside(&file.metallic_roughness_texture)),
        roughness: number(file.roughness, 1.0),
        metallic_roughness_texture: load("metallic_roughness_texture", &file.metallic_roughness_texture),
        normal_texture: load("normal_map", &file.normal_map),
        normal_scale: number(file.normal_scale, 1.0),
        emissive: review.accept(emissive(name, file)).unwrap_or_default(),
        emissive_texture: load("emissive_texture", &file.emissive_texture),
        emissive_by_vertex_color: false,
        ior: number(file.ior, default.ior),
        specular: number(file.specular, 1.0),
        specular_texture: load("specular_texture", &file.specular_texture),
        specular_color: color(file.specular_color, [1.0; 3]),
        specular_color_texture: load("specular_color_texture", &file.specular_color_texture),
        transmission: number(file.transmission, beside(&file.transmission_texture)),
        transmission_texture: load("transmission_texture", &file.transmission_texture),
        diffuse_transmission: number(file.diffuse_transmission, beside(&file.diffuse_transmission_texture)),
        diffuse_transmission_texture: load("diffuse_transmission_texture", &file.diffuse_transmission_texture),
        diffuse_transmission_color: color(file.diffuse_transmission_color, [1.0; 3]),
        diffuse_transmission_color_texture: load(
            "diffuse_transmission_color_texture",
            &file.diffuse_transmission_color_texture,
        ),
        thin_walled: file.thin_walled.unwrap_or(false),
        attenuation_color: color(file.attenuation_color, [1.0; 3]),
        attenuation_distance: number(file.attenuation_distance, f32::INFINITY),
        dispersion: number(file.dispersion, 0.0),
        priority: file.priority.map_or(0, |priority| priority.0 as i32),
        clearcoat: number(file.clearcoat, beside(&file.clearcoat_texture)),
        clearcoat_texture: load("clearcoat_texture", &file.clearcoat_texture),
        clearcoat_roughness: number(file.clearcoat_roughness, beside(&file.clearcoat_roughness_texture)),
        clearcoat_roughness_texture: load("clearcoat_roughness_texture", &file.clearcoat_roughness_texture),
        clearcoat_normal_texture: load("clearcoat_normal_map", &file.clearcoat_normal_map),
        clearcoat_normal_scale: number(file.clearcoat_normal_scale, 1.0),
        sheen_color: color(file.sheen_color, [beside(&file.sheen_color_texture); 3]),
        sheen_color_texture: load("sheen_color_texture", &file.sheen_color_texture),
        sheen_roughness: number(file.sheen_roughness, beside(&file.sheen_roughness_texture)),
        sheen_roughness_texture: load("sheen_roughness_texture", &file.sheen_roughness_texture),
        anisotropy: number(file.anisotropy, beside(&file.anisotropy_texture)),
        // Angles are reduced while they are precise.
        anisotropy_rotation: file.anisotropy_rotation.map_or(0.0, |it| it.0.rem_euclid(360.0).to_radians() as f32),
        anisotropy_texture: load("anisotropy_texture", &file.anisotropy_texture),
        iridescence: number(file.iridescence, beside(&file.iridescence_texture)),
        iridescence_texture: load("iridescence_texture", &file.iridescence_texture),
        iridescence_ior: number(file.iridescence_ior, default.iridescence_ior),
        iridescence_thickness_minimum: number(
            file.iridescence_thickness_minimum,
            default.iridescence_thickness_minimum,
        ),
        iridescence_thickness_maximum: number(
            file.iridescence_thickness_maximum,
            default.iridescence_thickness_maximum,
        ),
        iridescence_thickness_texture: load("iridescence_thickness_texture", &file.iridescence_thickness_texture),
    }
}

fn number<T: Into<f64>>(file: Option<T>, default: f32) -> f32 {
    file.map_or(default, |number| number.into() as f32)
}

fn color<T: Into<f64>>(file: Option<Color<T>>, default: [f32; 3]) -> [f32; 3] {
    file.map_or(default, |color| color.linear().map(|component| component as f32))
}

/// Default of a factor that is 0 on its own, but must not make its texture void.
fn beside(texture: &Option<TextureFile>) -> f32 {
    if texture.is_some() { 1.0 } else { 0.0 }
}

fn alpha_mode(file: &PrincipledFile) -> AlphaMode {
    match file.alpha_mode {
        None | Some(AlphaModeFile::Opaque) => AlphaMode::Opaque,
        Some(AlphaModeFile::Mask) => AlphaMode::Mask(number(file.alpha_cutoff, 0.5)),
        Some(AlphaModeFile::Blend) => AlphaMode::Blend,
    }
}

fn warn_of_alpha(name: &str, file: &PrincipledFile, warnings: &mut Vec<Fault>) {
    let mut warn = |key: &str, without: &str| {
        let path = steps!["materials", name, "principled", key];
        let message = format!("`{key}` in {} does nothing without {without}", place(name));
        warnings.push(Fault::key(path, message));
    };
    let is_opaque = alpha_mode(file) == AlphaMode::Opaque;
    if is_opaque && file.alpha.is_some() {
        warn("alpha", "`alpha_mode = \"blend\"` or `\"mask\"`");
    }
    if file.alpha_cutoff.is_some() && file.alpha_mode != Some(AlphaModeFile::Mask) {
        warn("alpha_cutoff", "`alpha_mode = \"mask\"`");
    }
}

fn place(name: &str) -> String {
    format!("[materials.{}.principled]", names::key(name))
}

/// Emitted radiance; it is white by default where a strength or a texture is given, as its writer wants to see light.
fn emissive(name: &str, file: &PrincipledFile) -> Result<[f32; 3], Fault> {
    let shines = file.emissive_strength.is_some() || file.emissive_texture.is_some();
    let color = file.emissive.map_or([f64::from(shines); 3], Color::linear);
    let emissive = color.map(|component| component * file.emissive_strength.map_or(1.0, f64::from));
    if emissive.into_iter().fold(0.0, f64::max) <= BRIGHTEST {
        return Ok(emissive.map(|component| component as f32));
    }
    let message = format!("`emissive_strength` times `emissive` in {} must be at most 1e9", place(name));
    Err(Fault::value(steps!["materials", name, "principled", "emissive_strength"], message))
}

fn texture(name: &str, key: &str, file: &TextureTable, files: &mut Files<'_>) -> Result<Texture, Fault> {
    let wrong = |what: &str| {
        let message = format!("`{key}` in {} {what}", place(name));
        Err(Fault::value(steps!["materials", name, "principled", key], message))
    };
    let image = match (&file.image, &file.checker) {
        // Files that give only a path have no `image` below, and the path is what is found.
        (Some(image), None) => files.image(image, steps!["materials", name, "principled", key, "image"])?,
        (None, Some(_)) if file.wrap.is_some() => {
            return wrong("is a checkerboard, which has no edge: leave out `wrap`");
        }
        (None, Some(_)) if file.filter.is_some() => {
            return wrong("is a checkerboard, which has no texels: leave out `filter`");
        }
        (None, Some(colors)) if !(2..=16).contains(&colors.len()) => {
            return wrong(&format!("needs 2 to 16 colours in `checker`, not {}", colors.len()));
        }
        (None, Some(colors)) => return Ok(checker(colors, file)),
        (Some(_), Some(_)) => return wrong("has both `image` and `checker`: choose one of them"),
        (None, None) => return wrong("needs `image` or `checker`"),
    };
    Ok(Texture {
        uv_set: file.uv_set.map_or(0, |set| set.0 as u8),
        transform: transform(file),
        wrap: match file.wrap {
            None => [Wrap::Repeat; 2],
            Some(WrapFile::Both(name)) => [wrap(name); 2],
            Some(WrapFile::Each(names)) => names.map(wrap),
        },
        filter: match file.filter {
            None | Some(TextureFilterFile::Linear) => TextureFilter::Linear,
            Some(TextureFilterFile::Nearest) => TextureFilter::Nearest,
        },
        ..Texture::new(image)
    })
}

/// Checkerboard of n colours: an image of n by n texels, in which each row begins one colour later.
fn checker(colors: &[SurfaceColor], file: &TextureTable) -> Texture {
    let n = colors.len();
    let color = |i: usize| colors[(i % n + i / n) % n].linear().map(|channel| channel as f32);
    let texels = Texels::Rgb32F((0..n * n).map(color).collect());
    Texture {
        uv_set: file.uv_set.map_or(0, |set| set.0 as u8),
        // The image has n fields along each side.
        transform: transform(file).map(|row| row.map(|number| number / n as f32)),
        wrap: [Wrap::Repeat; 2],
        filter: TextureFilter::Nearest,
        ..Texture::new(Arc::new(Bitmap { width: n as u32, height: n as u32, texels }))
    }
}

fn wrap(name: WrapName) -> Wrap {
    match name {
        WrapName::Repeat => Wrap::Repeat,
        WrapName::MirroredRepeat => Wrap::MirroredRepeat,
        WrapName::ClampToEdge => Wrap::ClampToEdge,
    }
}

/// Texture transform as KHR_texture_transform has it: scale, then turn, then move. It turns counter-clockwise for the
/// eye, v being downwards.
fn transform(file: &TextureTable) -> [[f32; 3]; 2] {
    let [x, y] = file.offset.map_or([0.0; 2], |offset| offset.map(f64::from));
    let [u, v] = file.scale.map_or([1.0; 2], |scale| scale.map(f64::from));
    let degrees = file.rotation_degrees.map_or(0.0, |degrees| degrees.0.rem_euclid(360.0));
    let (sine, cosine) = degrees.to_radians().sin_cos();
    [[cosine * u, sine * v, x], [-sine * u, cosine * v, y]].map(|row| row.map(|number| number as f32))
}
