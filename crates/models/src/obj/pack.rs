//! Channels of several images in one.

use raggio_images::{Bitmap, Texels};

/// Source of a channel.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    /// The value 1 everywhere.
    One,
    /// A channel of an image: 0 red, 1 green, 2 blue, 3 alpha.
    Channel(&'a Bitmap, usize),
}

/// An image as large as the largest of the sources, with 8 bits where they all have, or else 16. Smaller ones are
/// enlarged by the nearest texel, and of float images 1 is full.
pub(super) fn packed(sources: [Source<'_>; 4]) -> Bitmap {
    let [width, height] = size(&sources);
    let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let wide = places.map(|place| sources.map(|source| source.value(place, [width, height])));
    let is_wide = |image: &Bitmap| !matches!(image.texels, Texels::Rgba8(_));
    let texels = if sources.iter().filter_map(Source::image).any(is_wide) {
        Texels::Rgba16(wide.collect())
    } else {
        Texels::Rgba8(wide.map(|texel| texel.map(|value| (value / 257) as u8)).collect())
    };
    Bitmap { width, height, texels }
}

/// Most bytes that the texels of [`packed`] take.
pub(super) fn packed_bytes(sources: &[Source<'_>; 4]) -> u64 {
    let [width, height] = size(sources).map(u64::from);
    width.saturating_mul(height).saturating_mul(8)
}

fn size(sources: &[Source<'_>; 4]) -> [u32; 2] {
    let images = || sources.iter().filter_map(Source::image);
    let width = images().map(|image| image.width).max();
    [width, images().map(|image| image.height).max()].map(|side| side.unwrap_or(1))
}

impl<'a> Source<'a> {
    /// The channel, or 1 where there is no image.
    pub(super) fn of(image: Option<&'a Bitmap>, channel: usize) -> Self {
        image.map_or(Self::One, |image| Self::Channel(image, channel))
    }

    fn image(&self) -> Option<&Bitmap> {
        match self {
            Self::One => None,
            Self::Channel(image, _) => Some(image),
        }
    }

    /// Value at a place of a grid of that size, 65535 being 1.
    fn value(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> u16 {
        let Self::Channel(image, channel) = *self else { return u16::MAX };
        let scaled = |at: u32, from: u32, to: u32| (u64::from(at) * u64::from(to) / u64::from(from)) as usize;
        let index = scaled(y, height, image.height) * image.width as usize + scaled(x, width, image.width);
        match &image.texels {
            Texels::Rgba8(texels) => u16::from(texels[index][channel]) * 257,
            Texels::Rgba16(texels) => texels[index][channel],
            // A float as an integer saturates; alpha is 1.
            Texels::Rgb32F(texels) => {
                texels[index].get(channel).map_or(u16::MAX, |value| (value * 65535.0 + 0.5) as u16)
            }
        }
    }
}
