//! Where samples add up, on the host.

use raggio_kernels::{FilmPixel, FixedSum};

use crate::pictures::linear_image::Image;

/// Sum and count of the samples of each pixel.
///
/// Sums are exact (see `kernels/film.slang`): films of different sample ranges merge to the very film that one render
/// of all samples gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<FilmPixel>,
}

/// Two films of different sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("films of {0}x{1} and {2}x{3} pixels cannot be merged")]
pub struct SizeMismatch(u32, u32, u32, u32);

/// Memory that the film of an image takes.
pub fn film_bytes(width: u32, height: u32) -> u64 {
    u64::from(width) * u64::from(height) * size_of::<FilmPixel>() as u64
}

impl Film {
    /// Without samples.
    pub fn new(width: u32, height: u32) -> Self {
        Self::from_pixels(width, height, vec![FilmPixel::default(); width as usize * height as usize])
    }

    /// From what a device has accumulated.
    ///
    /// # Panics
    /// If there are not `width` times `height` pixels.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<FilmPixel>) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize);
        Self { width, height, pixels }
    }

    /// A film that shows `image`: a sample a pixel.
    pub fn from_image(image: &Image) -> Self {
        let pixel = |rgb: &[f32; 3]| {
            let [red, green, blue] = rgb.map(|channel| FixedSum::of(f64::from(channel)));
            FilmPixel { red, green, blue, samples: 1, ..FilmPixel::default() }
        };
        Self::from_pixels(image.width, image.height, image.pixels.iter().map(pixel).collect())
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Row by row from the top left.
    pub fn pixels(&self) -> &[FilmPixel] {
        &self.pixels
    }

    pub(crate) fn pixels_mut(&mut self) -> &mut [FilmPixel] {
        &mut self.pixels
    }

    /// Adds the samples of `other`, which must be other samples of the same picture.
    pub fn merge(&mut self, other: &Film) -> Result<(), SizeMismatch> {
        if (self.width, self.height) != (other.width, other.height) {
            return Err(SizeMismatch(self.width, self.height, other.width, other.height));
        }
        for (into, from) in self.pixels.iter_mut().zip(&other.pixels) {
            into.merge(from);
        }
        Ok(())
    }

    /// Mean radiance of each pixel; black where there is no sample.
    pub fn mean(&self) -> Image {
        let pixels = self.pixels.iter().map(|pixel| pixel.mean().map(|channel| channel as f32)).collect();
        Image { width: self.width, height: self.height, pixels }
    }

    /// Samples in all pixels together.
    pub fn samples(&self) -> u64 {
        self.pixels.iter().map(|p| u64::from(p.samples)).sum()
    }

    /// The fewest and the most samples of any pixel, those left out included.
    pub fn sample_range(&self) -> (u32, u32) {
        let taken = |pixel: &FilmPixel| pixel.samples + pixel.rejected;
        let range = self.pixels.iter().map(taken).fold((u32::MAX, 0), |(low, high), n| (low.min(n), high.max(n)));
        (range.0.min(range.1), range.1)
    }

    /// Samples that were left out because they had no value that can be added up.
    pub fn rejected(&self) -> u64 {
        self.pixels.iter().map(|p| u64::from(p.rejected)).sum()
    }

    /// The luminance that clamping took off, as a share of what there was.
    pub fn clamped_share(&self) -> f64 {
        let clamped: f64 = self.pixels.iter().map(|p| p.clamped.value()).sum();
        let kept: f64 = self.pixels.iter().map(|p| p.luminance() * f64::from(p.samples)).sum();
        if clamped > 0.0 { clamped / (kept + clamped) } else { 0.0 }
    }

    /// Rays traced; exact as long as each pixel took fewer than 2^32.
    pub fn rays(&self) -> u64 {
        self.pixels.iter().map(|p| u64::from(p.rays)).sum()
    }
}
