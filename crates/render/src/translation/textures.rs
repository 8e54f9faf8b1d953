//! Images as the kernels read them: all texels in one buffer, each image in it once.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use raggio_kernels::{
    MAX_TEXTURE_SIDE, TexelFormat, Texture as DeviceTexture, TextureFilter as DeviceFilter, TextureWrap,
};
use raggio_scene::{Bitmap, Texels, Texture, TextureFilter, Wrap};
use rayon::prelude::*;

use crate::devices::machine::available_bytes;
use crate::translation::error::TranslationError;

/// Meaning of an image's 8 or 16 bits as numbers; floats are linear in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Numbers encoded by the transfer function of IEC 61966-2-1, but for alpha.
    Srgb,
    /// Numbers in proportion to the bits.
    Linear,
}

/// Gathers a scene's textures. The same image is stored once, however many textures lay it in different ways. Images
/// are kept from scene to scene, as long as all are used.
#[derive(Clone, Debug, Default)]
pub struct TextureTable {
    textures: Vec<DeviceTexture>,
    texels: Arc<Vec<u32>>,
    /// Addresses of the images that this scene has used.
    used: HashSet<usize>,
    /// First words by the image's address. The image is kept, lest another come to have its address.
    images: HashMap<usize, (u32, Arc<Bitmap>)>,
    /// Indices of textures, by the textures' bytes.
    indices: HashMap<[u8; size_of::<DeviceTexture>()], u32>,
}

impl TextureTable {
    /// Begins the list of a scene.
    pub fn begin(&mut self) {
        if self.used.len() < self.images.len() {
            *self = Self::default();
        }
        self.textures.clear();
        self.indices.clear();
        self.used.clear();
    }

    /// Index of `texture`, which is added if nobody has done so before.
    ///
    /// # Errors
    /// A [`TranslationError`] when the texture's image is too large, or all images together are.
    pub fn add(&mut self, texture: &Texture, space: ColorSpace) -> Result<u32, TranslationError> {
        let [row_u, row_v] = texture.transform;
        let [wrap_u, wrap_v] = texture.wrap.map(|wrap| device_wrap(wrap) as u32);
        let device_texture = DeviceTexture {
            first_word: self.add_image(&texture.image)?,
            width: texture.image.width,
            height: texture.image.height,
            format: format(&texture.image.texels, space) as u32,
            wrap_u,
            wrap_v,
            filter: device_filter(texture.filter) as u32,
            uv_set: u32::from(texture.uv_set),
            row_u,
            row_v,
        };
        let index = *self.indices.entry(bytemuck::cast(device_texture)).or_insert(self.textures.len() as u32);
        if index as usize == self.textures.len() {
            self.textures.push(device_texture);
        }
        Ok(index)
    }

    /// Lists of the scene, for the `textures` and the `texels` of `SceneBuffers`.
    pub fn finish(&self) -> (Arc<Vec<DeviceTexture>>, Arc<Vec<u32>>) {
        (Arc::new(self.textures.clone()), self.texels.clone())
    }

    /// The word at which `image` begins.
    fn add_image(&mut self, image: &Arc<Bitmap>) -> Result<u32, TranslationError> {
        self.used.insert(Arc::as_ptr(image).addr());
        if let Some((first, _)) = self.images.get(&Arc::as_ptr(image).addr()) {
            return Ok(*first);
        }
        let (width, height) = (image.width, image.height);
        if width.max(height) > MAX_TEXTURE_SIDE {
            return Err(TranslationError::ImageTooLarge { width, height });
        }
        let first = first_word(self.texels.len(), image)?;
        check_memory(image, available_bytes())?;
        append(Arc::make_mut(&mut self.texels), &image.texels);
        self.images.insert(Arc::as_ptr(image).addr(), (first, image.clone()));
        Ok(first)
    }
}

/// Checks that there is memory for the texels of an image once more, as kernels read them.
fn check_memory(image: &Bitmap, available: Option<u64>) -> Result<(), TranslationError> {
    let needed = 4 * u64::from(format(&image.texels, ColorSpace::Linear).words()) * image.texels.len() as u64;
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    match available {
        Some(available) if needed > available => {
            Err(TranslationError::NoMemoryForTexels { needed_gib: gib(needed), available_gib: gib(available) })
        }
        _ => Ok(()),
    }
}

/// Word at which an image begins that follows `used` words; every word of it must have a number of 32 bits.
fn first_word(used: usize, image: &Bitmap) -> Result<u32, TranslationError> {
    let words = u64::from(format(&image.texels, ColorSpace::Linear).words());
    let end = used as u64 + words * image.texels.len() as u64;
    if end > 1 << 32 {
        let gib = |words: u64| words as f64 / f64::from(1 << 28);
        return Err(TranslationError::TooManyTexels { needed_gib: gib(end), limit_gib: gib(1 << 32) });
    }
    Ok(used as u32)
}

/// Appends `texels` to `words`, packed as `TexelFormat` says; large images on all cores.
fn append(words: &mut Vec<u32>, texels: &Texels) {
    /// Texels, or numbers, that are not worth a task of their own.
    const FEW: usize = 1 << 16;
    match texels {
        Texels::Rgba8(texels) => {
            words.par_extend(texels.par_iter().with_min_len(FEW).map(|texel| u32::from_le_bytes(*texel)));
        }
        Texels::Rgba16(texels) => {
            let pairs = texels.as_flattened().par_chunks_exact(2).with_min_len(FEW);
            words.par_extend(pairs.map(|pair| u32::from(pair[0]) | u32::from(pair[1]) << 16));
        }
        Texels::Rgb32F(texels) => {
            words.par_extend(texels.as_flattened().par_iter().with_min_len(FEW).map(|number| number.to_bits()));
        }
    }
}

fn format(texels: &Texels, space: ColorSpace) -> TexelFormat {
    match (texels, space) {
        (Texels::Rgba8(_), ColorSpace::Linear) => TexelFormat::Rgba8,
        (Texels::Rgba8(_), ColorSpace::Srgb) => TexelFormat::Rgba8Srgb,
        (Texels::Rgba16(_), ColorSpace::Linear) => TexelFormat::Rgba16,
        (Texels::Rgba16(_), ColorSpace::Srgb) => TexelFormat::Rgba16Srgb,
        (Texels::Rgb32F(_), _) => TexelFormat::Rgb32F,
    }
}

fn device_wrap(wrap: Wrap) -> TextureWrap {
    match wrap {
        Wrap::Repeat => TextureWrap::Repeat,
        Wrap::MirroredRepeat => TextureWrap::MirroredRepeat,
        Wrap::ClampToEdge => TextureWrap::ClampToEdge,
    }
}

fn device_filter(filter: TextureFilter) -> DeviceFilter {
    match filter {
        TextureFilter::Linear => DeviceFilter::Linear,
        TextureFilter::Nearest => DeviceFilter::Nearest,
    }
}

/// Linear red, green and blue of texel `place` of an image in `texels`.
pub(crate) fn texel(texture: &DeviceTexture, texels: &[u32], place: usize) -> [f32; 3] {
    let first = texture.first_word as usize;
    let is = |format: TexelFormat| texture.format == format as u32;
    if is(TexelFormat::Rgb32F) {
        return [0, 1, 2].map(|i| f32::from_bits(texels[first + 3 * place + i]));
    }
    let encoded = if is(TexelFormat::Rgba8) || is(TexelFormat::Rgba8Srgb) {
        let [r, g, b, _] = texels[first + place].to_le_bytes();
        [r, g, b].map(|c| f32::from(c) / 255.0)
    } else {
        let [low, high] = [texels[first + 2 * place], texels[first + 2 * place + 1]];
        [low & 0xffff, low >> 16, high & 0xffff].map(|c| c as f32 / 65535.0)
    };
    let srgb = is(TexelFormat::Rgba8Srgb) || is(TexelFormat::Rgba16Srgb);
    if srgb { encoded.map(srgb_decode) } else { encoded }
}

/// The mean of an image's texels.
pub(crate) fn mean(texture: &DeviceTexture, texels: &[u32]) -> [f32; 3] {
    let count = texture.width as usize * texture.height as usize;
    let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] + b[i]);
    let row = |y: usize| {
        let places = y * texture.width as usize..(y + 1) * texture.width as usize;
        places.map(|place| texel(texture, texels, place).map(f64::from)).fold([0.0; 3], sum)
    };
    let rows: Vec<[f64; 3]> = (0..texture.height as usize).into_par_iter().map(row).collect();
    rows.into_iter().fold([0.0; 3], sum).map(|sum| (sum / count as f64) as f32)
}

/// Linear value of an sRGB one (IEC 61966-2-1).
fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(texels: Texels) -> Arc<Bitmap> {
        Arc::new(Bitmap { width: texels.len() as u32, height: 1, texels })
    }

    #[test]
    fn images_are_stored_once() {
        let bytes = Texture::new(image(Texels::Rgba8(vec![[1, 2, 3, 4], [5, 6, 7, 8]])));
        let mirrored = Texture { wrap: [Wrap::MirroredRepeat; 2], ..bytes.clone() };
        let equal = Texture::new(image(bytes.image.texels.clone()));
        let mut table = TextureTable::default();
        let mut add = |texture: &Texture, space| table.add(texture, space).expect("there is room");
        assert_eq!(add(&bytes, ColorSpace::Linear), 0);
        assert_eq!(add(&bytes, ColorSpace::Srgb), 1);
        assert_eq!(add(&mirrored, ColorSpace::Srgb), 2);
        assert_eq!(add(&bytes.clone(), ColorSpace::Linear), 0);
        assert_eq!(add(&equal, ColorSpace::Linear), 3, "equal images need not be told from different ones");

        let (textures, texels) = table.finish();
        assert_eq!(*texels, [0x0403_0201, 0x0807_0605, 0x0403_0201, 0x0807_0605]);
        assert_eq!(textures.iter().map(|texture| texture.first_word).collect::<Vec<_>>(), [0, 0, 0, 2]);
    }

    #[test]
    fn texels_are_packed() {
        let mut words = vec![9];
        append(&mut words, &Texels::Rgba16(vec![[0x1234, 0xffff, 0, 0x8001]; 2]));
        append(&mut words, &Texels::Rgb32F(vec![[1.0, 0.5, 0.0]]));
        let pixel = [0xffff_1234, 0x8001_0000];
        let floats = [1.0f32, 0.5, 0.0].map(f32::to_bits);
        assert_eq!(words, [&[9], &pixel[..], &pixel, &floats].concat());
    }

    #[test]
    fn texels_take_no_memory_that_is_not_there() {
        let bitmap = image(Texels::Rgba16(vec![[0; 4]; 1 << 10]));
        assert_eq!(check_memory(&bitmap, Some(8 << 10)), Ok(()));
        assert_eq!(check_memory(&bitmap, None), Ok(()));
        let refused = check_memory(&bitmap, Some((8 << 10) - 1)).expect_err("too little").to_string();
        assert!(refused.starts_with("an image of the scene takes"), "{refused}");
    }

    #[test]
    fn what_cannot_be_addressed_is_refused() {
        let bitmap = image(Texels::Rgba16(vec![[0; 4]; 3]));
        assert_eq!(first_word((1 << 32) - 6, &bitmap), Ok(u32::MAX - 5));
        let error = first_word((1 << 32) - 5, &bitmap).expect_err("there is no room").to_string();
        assert!(
            error.starts_with("the scene's images take 16.0 GiB in all, and kernels can address 16 GiB"),
            "{error}"
        );

        let texels = Texels::Rgba8(vec![[0; 4]; MAX_TEXTURE_SIDE as usize + 1]);
        let error = TextureTable::default().add(&Texture::new(image(texels)), ColorSpace::Srgb).expect_err("too wide");
        assert_eq!(error.to_string(), "an image of 16777217 x 1 texels is too large: a side may have 16777216");
    }
}
