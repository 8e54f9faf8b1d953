//! Textures of MTL, read once each and laid out as principled materials have them.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use raggio_images::{Bitmap, Limits, Texels};

use super::mtl::MtlMap;
use super::pack::{Source, packed, packed_bytes};
use crate::file::{LoadOptions, path_near};
use crate::material::{Texture, Wrap};
use crate::text::{escaped, quoted};

/// The textures of one file, and what could not be made of its materials.
pub(crate) struct Textures<'a> {
    folder: &'a Path,
    options: &'a LoadOptions,
    bytes_left: u64,
    /// Images by path; `None` for those that cannot be read.
    images: HashMap<PathBuf, Option<Arc<Bitmap>>>,
    /// Images put together, by use and sources; the places in memory stay, because `images` keeps all images.
    packed: HashMap<(Use, [*const Bitmap; 2]), Arc<Bitmap>>,
    warnings: Vec<String>,
    warned: HashSet<String>,
}

/// Purpose for which images are put together.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Use {
    Coverage,
    MetallicRoughness,
}

impl<'a> Textures<'a> {
    pub(crate) fn new(folder: &'a Path, options: &'a LoadOptions) -> Self {
        let (images, packed, warnings, warned) = Default::default();
        Self { folder, options, bytes_left: options.most_bytes, images, packed, warnings, warned }
    }

    /// Keeps a sentence for the user, once.
    pub(crate) fn warn(&mut self, warning: &str) {
        if self.warned.insert(warning.to_string()) {
            self.warnings.push(escaped(warning));
        }
    }

    pub(crate) fn into_warnings(self) -> Vec<String> {
        self.warnings
    }

    /// The texture, or a warning where it cannot be read.
    pub(crate) fn load(&mut self, map: &MtlMap) -> Option<Texture> {
        let Some(path) = path_near(self.folder, &map.file, self.options) else {
            self.warn(&format!("the texture {} is not read: it is not inside the folder", quoted(map.file.as_bytes())));
            return None;
        };
        let image = match self.images.get(&path) {
            Some(image) => image.clone(),
            None => {
                let image = self.read(&path, &map.file);
                self.images.insert(path, image.clone());
                image
            }
        };
        let wrap = if map.clamp { Wrap::ClampToEdge } else { Wrap::Repeat };
        Some(Texture { transform: transform(map), wrap: [wrap; 2], ..Texture::new(image?) })
    }

    fn read(&mut self, path: &Path, name: &str) -> Option<Arc<Bitmap>> {
        let limits = Limits { most_bytes: self.bytes_left, ..Limits::default() };
        match raggio_images::load(path, &limits) {
            Ok(bitmap) => {
                self.bytes_left = self.bytes_left.saturating_sub(texel_bytes(&bitmap));
                Some(Arc::new(bitmap))
            }
            Err(error) => {
                self.warn(&format!("the texture {} is not used: it {}", quoted(name.as_bytes()), error.problem));
                None
            }
        }
    }

    /// The colours of one texture with the coverage of another: its alpha where it has one, or else its red.
    pub(crate) fn with_coverage(&mut self, color: Option<Texture>, coverage: Texture) -> Option<Texture> {
        let laid_out = color.as_ref().is_none_or(|color| is_laid_out_alike(color, &coverage));
        if !laid_out {
            self.warn("the coverage of a material is not used: its texture lies otherwise than the colour's");
            return color;
        }
        let channel = if has_alpha(&coverage.image) { 3 } else { 0 };
        let image = color.as_ref().map(|color| Arc::clone(&color.image));
        let [r, g, b] = [0, 1, 2].map(|i| Source::of(image.as_deref(), i));
        let sources = [r, g, b, Source::of(Some(&coverage.image), channel)];
        match self.pack(Use::Coverage, [image.as_ref(), Some(&coverage.image)], sources) {
            Some(image) => Some(Texture { image, ..coverage }),
            None => color,
        }
    }

    /// Roughness in green and metalness in blue, from the red of each.
    pub(crate) fn metallic_roughness(&mut self, rough: Option<Texture>, metal: Option<Texture>) -> Option<Texture> {
        let laid_out = rough.as_ref().zip(metal.as_ref()).is_none_or(|(rough, metal)| is_laid_out_alike(rough, metal));
        if !laid_out {
            self.warn("the metalness of a material is not used: its texture lies otherwise than the roughness");
        }
        let metal = metal.filter(|_| laid_out);
        let images = [&rough, &metal].map(|texture| texture.as_ref().map(|texture| Arc::clone(&texture.image)));
        let [green, blue] = images.each_ref().map(|image| Source::of(image.as_deref(), 0));
        let texture = rough.or(metal)?;
        let sources = [Source::One, green, blue, Source::One];
        let image = self.pack(Use::MetallicRoughness, images.each_ref().map(Option::as_ref), sources)?;
        Some(Texture { image, ..texture })
    }

    fn pack(&mut self, what: Use, images: [Option<&Arc<Bitmap>>; 2], sources: [Source<'_>; 4]) -> Option<Arc<Bitmap>> {
        let key = (what, images.map(|image| image.map_or(std::ptr::null(), Arc::as_ptr)));
        if let Some(image) = self.packed.get(&key) {
            return Some(Arc::clone(image));
        }
        // A wide image and a high one need more together than both of them.
        let Some(bytes_left) = self.bytes_left.checked_sub(packed_bytes(&sources)) else {
            self.warn("textures are left out: put together they take more memory than is allowed");
            return None;
        };
        self.bytes_left = bytes_left;
        let image = Arc::new(packed(sources));
        self.packed.insert(key, Arc::clone(&image));
        Some(image)
    }
}

/// Transform of the coordinates: MTL's begin at the bottom left, an image's at its top left.
fn transform(map: &MtlMap) -> [[f32; 3]; 2] {
    let ([su, sv], [ou, ov]) = (map.scale, map.offset);
    [[su, 0.0, ou], [0.0, -sv, 1.0 - ov]]
}

fn is_laid_out_alike(a: &Texture, b: &Texture) -> bool {
    a.transform == b.transform && a.wrap == b.wrap
}

fn has_alpha(image: &Bitmap) -> bool {
    match &image.texels {
        Texels::Rgba8(texels) => texels.iter().any(|texel| texel[3] != u8::MAX),
        Texels::Rgba16(texels) => texels.iter().any(|texel| texel[3] != u16::MAX),
        Texels::Rgb32F(_) => false,
    }
}

fn texel_bytes(image: &Bitmap) -> u64 {
    let each = match &image.texels {
        Texels::Rgba8(_) => 4,
        Texels::Rgba16(_) => 8,
        Texels::Rgb32F(_) => 12,
    };
    each * image.texels.len() as u64
}
