//! Limits of how large an image may be.

use crate::error::Problem;

/// Sizes above which an image is refused before it is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most pixels, width times height.
    pub most_pixels: u64,
    /// Most bytes of the file, and of the texels in memory. Decoding takes up to three times as much.
    pub most_bytes: u64,
}

impl Default for Limits {
    /// Limits of 16384 x 16384 pixels and 4 GiB.
    fn default() -> Self {
        Self { most_pixels: 1 << 28, most_bytes: 4 << 30 }
    }
}

impl Limits {
    /// Checks a declared size; `texel_bytes` are the bytes that a texel takes in memory.
    pub(crate) fn check(&self, width: u64, height: u64, texel_bytes: u64) -> Result<(), Problem> {
        let pixels = width.saturating_mul(height);
        // A side of a bitmap is a `u32`.
        let fits = pixels > 0
            && pixels <= self.most_pixels
            && pixels.saturating_mul(texel_bytes) <= self.most_bytes
            && width.max(height) <= u64::from(u32::MAX);
        let Self { most_pixels, most_bytes } = *self;
        fits.then_some(()).ok_or(Problem::TooManyPixels { width, height, most_pixels, most_bytes })
    }
}
