//! Textures of MTL, read once each and laid out as principled materials have them.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use raggio_images::{Bitmap, Image, Limits, Texels};

use super::bump::{holds_normals, normals_of_heights};
use super::lookup::{Found, Lookup};
use super::mtl::MtlMap;
use super::pack::{Source, packed, packed_bytes};
use crate::file::{LoadOptions, read};
use crate::inside::Named;
use crate::material::{Texture, Wrap};
use crate::text::{escaped, quoted};

/// The textures of one file, and what could not be made of its materials.
pub(crate) struct Textures<'a> {
    lookup: Lookup<'a>,
    /// Folder of the library at hand, as [`MtlMaterial::folder`](super::mtl::MtlMaterial::folder) has it.
    folder: String,
    bytes_left: u64,
    /// Paths of the images that are called so in a folder; `None` for those that are not found.
    paths: HashMap<[String; 2], Option<PathBuf>>,
    /// Images by path; `None` for those that cannot be read.
    images: HashMap<PathBuf, Option<Arc<Bitmap>>>,
    /// Normal maps by the height maps they are of and whether they are clamped; the places in memory stay, because `images`
    /// keeps all images.
    bumps: HashMap<(*const Bitmap, bool), Arc<Bitmap>>,
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
    pub(crate) fn new(folder: &'a Path, options: &LoadOptions) -> Self {
        let lookup = Lookup::new(folder, options.allow_outside);
        let (folder, paths, images, bumps, packed, warnings, warned) = Default::default();
        Self { lookup, folder, bytes_left: options.most_bytes, paths, images, bumps, packed, warnings, warned }
    }

    /// Says in which folder the next textures are looked for first: that of their library.
    pub(crate) fn look_beside(&mut self, folder: &str) {
        self.folder = folder.to_string();
    }

    /// Keeps a sentence for the user, once.
    pub(crate) fn warn(&mut self, warning: &str) {
        if self.warned.insert(warning.to_string()) {
            self.warnings.push(escaped(warning));
        }
    }

    /// Sentences for the user, and the images that were looked for.
    pub(crate) fn finish(self) -> (Vec<String>, Named) {
        (self.warnings, self.lookup.into_named())
    }

    /// The texture, or a warning where it cannot be read.
    pub(crate) fn load(&mut self, map: &MtlMap) -> Option<Texture> {
        let key = [self.folder.clone(), map.file.clone()];
        let path = match self.paths.get(&key) {
            Some(path) => path.clone(),
            None => {
                let path = self.find(&map.file);
                self.paths.insert(key, path.clone());
                path
            }
        }?;
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

    fn find(&mut self, name: &str) -> Option<PathBuf> {
        let shown = quoted(name.as_bytes());
        // Most files mean a place beside the library, some one beside the object.
        let beside = [self.folder.as_str(), ""];
        let beside = if self.folder.is_empty() { &beside[1..] } else { &beside };
        match self.lookup.find(beside, name) {
            Ok(Found { path, instead }) => {
                if let Some(instead) = instead {
                    let instead = quoted(instead.as_bytes());
                    self.warn(&format!("the texture {shown} is not there: {instead} is read instead"));
                }
                Some(path)
            }
            Err(refusal) => {
                self.warn(&format!("the texture {shown} is not used: it {refusal}"));
                None
            }
        }
    }

    fn read(&mut self, path: &Path, name: &str) -> Option<Arc<Bitmap>> {
        let limits = Limits { most_bytes: self.bytes_left, ..Limits::default() };
        let image = read(path, self.bytes_left)
            .and_then(|bytes| Image::decode(&bytes, &limits).map_err(|error| error.problem.to_string()));
        let name = quoted(name.as_bytes());
        match image {
            Ok(Image { bitmap, warnings }) => {
                warnings.iter().for_each(|warning| self.warn(&format!("the texture {name}: {warning}")));
                self.bytes_left = self.bytes_left.saturating_sub(texel_bytes(&bitmap));
                Some(Arc::new(bitmap))
            }
            Err(problem) => {
                self.warn(&format!("the texture {name} is not used: it {problem}"));
                None
            }
        }
    }

    /// The normal map that a bump map stands for. Programs that know nothing but normal maps write those as bump maps.
    pub(crate) fn bump(&mut self, map: &MtlMap) -> Option<Texture> {
        let texture = self.load(map)?;
        if holds_normals(&texture.image) {
            let name = quoted(map.file.as_bytes());
            self.warn(&format!("the bump map {name} is read as a normal map: it holds normals, not heights"));
            return Some(texture);
        }
        let key = (Arc::as_ptr(&texture.image), map.clamp);
        let image = match self.bumps.get(&key) {
            Some(image) => Arc::clone(image),
            None => {
                let bytes = 8 * texture.image.texels.len() as u64;
                self.take_bytes(bytes, "a bump map is not used: its normals take more memory than is allowed")?;
                let image = Arc::new(normals_of_heights(&texture.image, map.clamp));
                self.bumps.insert(key, Arc::clone(&image));
                image
            }
        };
        Some(Texture { image, ..texture })
    }

    /// Takes bytes of a new image from those that are left, if they are.
    fn take_bytes(&mut self, bytes: u64, otherwise: &str) -> Option<()> {
        let left = self.bytes_left.checked_sub(bytes);
        match left {
            Some(left) => self.bytes_left = left,
            None => self.warn(otherwise),
        }
        left.map(drop)
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
        let otherwise = "textures are left out: put together they take more memory than is allowed";
        self.take_bytes(packed_bytes(&sources), otherwise)?;
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
