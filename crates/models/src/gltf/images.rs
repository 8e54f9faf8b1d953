//! The images that materials use, decoded once each.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use raggio_images::{Bitmap, Image, Limits, Texels};
use rayon::prelude::*;

use super::GltfOptions;
use super::asset::Asset;
use super::resources::{Resources, fetch};

/// Decoded images by their numbers; `None` where one could not be read.
pub(super) struct Images {
    bitmaps: BTreeMap<usize, Option<Arc<Bitmap>>>,
    /// Number of the first image that has these bytes, for each image.
    firsts: Vec<usize>,
}

impl Images {
    /// Reads and decodes the images that textures of materials need. One that cannot be read is a warning.
    pub(super) fn load(asset: &Asset<'_>, resources: &dyn Resources, options: &GltfOptions) -> Self {
        let infos = asset.document.materials.iter().flat_map(|material| material.textures());
        let textures: BTreeSet<usize> = infos.map(|(_, info)| info.index).collect();
        let mut images = Self { bitmaps: BTreeMap::new(), firsts: firsts(asset) };
        let left = AtomicU64::new(options.most_bytes);
        // A texture may name several images, best first: the next is read where the one before could not be.
        loop {
            let wanted = |texture: &usize| {
                images.sources(asset, *texture).find(|source| !matches!(images.bitmaps.get(source), Some(None)))
            };
            let needed: BTreeSet<usize> =
                textures.iter().filter_map(wanted).filter(|image| !images.bitmaps.contains_key(image)).collect();
            if needed.is_empty() {
                return images;
            }
            images.decode(asset, needed, resources, &left, options.most_bytes);
        }
    }

    /// The image of a texture.
    pub(super) fn of_texture(&self, asset: &Asset<'_>, texture: usize) -> Option<Arc<Bitmap>> {
        self.sources(asset, texture).find_map(|source| self.bitmaps.get(&source)?.clone())
    }

    fn sources<'a>(&'a self, asset: &'a Asset<'_>, texture: usize) -> impl Iterator<Item = usize> + 'a {
        asset.document.textures[texture].sources().map(|source| self.firsts[source])
    }

    fn decode(
        &mut self,
        asset: &Asset<'_>,
        needed: BTreeSet<usize>,
        resources: &dyn Resources,
        left: &AtomicU64,
        mut most_bytes: u64,
    ) {
        let mut read = |image| {
            let file = bytes(asset, image, resources, most_bytes);
            most_bytes = most_bytes.saturating_sub(file.as_ref().map_or(0, |file| file.len() as u64));
            (image, file)
        };
        let files: Vec<_> = needed.into_iter().map(&mut read).collect();
        let decoded: Vec<_> = files
            .into_par_iter()
            .map(|(image, file)| (image, file.and_then(|file| decode_within(&file, left))))
            .collect();
        for (number, result) in decoded {
            let name = &asset.document.images[number].name;
            let name =
                if name.is_empty() { String::new() } else { format!(" {}", crate::text::quoted(name.as_bytes())) };
            let image = result.map_err(|message| {
                let name = if name.is_empty() { String::new() } else { format!(",{name},") };
                asset.warnings.push(format!("image {number}{name} is left out: {message}"));
            });
            for warning in image.iter().flat_map(|image| &image.warnings) {
                asset.warnings.push(format!("image {number}{name}: {warning}"));
            }
            self.bitmaps.insert(number, image.ok().map(|image| Arc::new(image.bitmap)));
        }
    }
}

fn firsts(asset: &Asset<'_>) -> Vec<usize> {
    let mut known = HashMap::new();
    let images = asset.document.images.iter().enumerate();
    images.map(|(number, image)| *known.entry((&image.uri, image.buffer_view)).or_insert(number)).collect()
}

fn bytes<'a>(
    asset: &'a Asset<'_>,
    number: usize,
    resources: &dyn Resources,
    most_bytes: u64,
) -> Result<Cow<'a, [u8]>, String> {
    let image = &asset.document.images[number];
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => fetch(uri, resources, most_bytes, &asset.warnings).map(Cow::Owned),
        (None, Some(view)) => {
            let bytes = asset.view(view, &format!("images[{number}].bufferView"));
            bytes.map(Cow::Borrowed).map_err(|fault| fault.of("").message)
        }
        (None, None) => Err("it should have a `uri` or a `bufferView`".to_string()),
    }
}

/// Decodes an image and takes its texels from what is left for all of them.
fn decode_within(file: &[u8], left: &AtomicU64) -> Result<Image, String> {
    let limits = Limits { most_bytes: left.load(Ordering::Relaxed), ..Limits::default() };
    let image = Image::decode(file, &limits).map_err(|error| format!("it {error}"))?;
    let size = size(&image.bitmap);
    let taken = left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(size));
    taken.map_err(|left| format!("it takes {size} bytes: at most {left} are left for images"))?;
    Ok(image)
}

/// Size of the texels in bytes.
fn size(bitmap: &Bitmap) -> u64 {
    let texel = match &bitmap.texels {
        Texels::Rgba8(_) => 4,
        Texels::Rgba16(_) => 8,
        Texels::Rgb32F(_) => 12,
    };
    bitmap.texels.len() as u64 * texel
}
