//! Uncompressed formats: up to four channels of one type.

use exr::prelude::f16;
use ktx2::Format;

use super::malformed;
use crate::bitmap::Texels;
use crate::error::Problem;
use crate::guard::{filled, radiance};

/// Layout of the bytes of a texel.
pub(super) struct Layout {
    /// The colour of each channel in the file, in its order: 0 red, 1 green, 2 blue, 3 alpha.
    channels: &'static [usize],
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    Unorm8,
    Unorm16,
    Half,
    Float,
}

impl Layout {
    pub(super) fn of(format: Format) -> Option<Self> {
        const RGBA: &[usize] = &[0, 1, 2, 3];
        let (channels, kind) = match format {
            Format::R8_UNORM | Format::R8_SRGB => (&RGBA[..1], Kind::Unorm8),
            Format::R8G8_UNORM | Format::R8G8_SRGB => (&RGBA[..2], Kind::Unorm8),
            Format::R8G8B8_UNORM | Format::R8G8B8_SRGB => (&RGBA[..3], Kind::Unorm8),
            Format::R8G8B8A8_UNORM | Format::R8G8B8A8_SRGB => (RGBA, Kind::Unorm8),
            Format::B8G8R8_UNORM | Format::B8G8R8_SRGB => ([2, 1, 0].as_slice(), Kind::Unorm8),
            Format::B8G8R8A8_UNORM | Format::B8G8R8A8_SRGB => ([2, 1, 0, 3].as_slice(), Kind::Unorm8),
            Format::R16_UNORM => (&RGBA[..1], Kind::Unorm16),
            Format::R16G16_UNORM => (&RGBA[..2], Kind::Unorm16),
            Format::R16G16B16_UNORM => (&RGBA[..3], Kind::Unorm16),
            Format::R16G16B16A16_UNORM => (RGBA, Kind::Unorm16),
            Format::R16_SFLOAT => (&RGBA[..1], Kind::Half),
            Format::R16G16_SFLOAT => (&RGBA[..2], Kind::Half),
            Format::R16G16B16_SFLOAT => (&RGBA[..3], Kind::Half),
            Format::R16G16B16A16_SFLOAT => (RGBA, Kind::Half),
            Format::R32_SFLOAT => (&RGBA[..1], Kind::Float),
            Format::R32G32_SFLOAT => (&RGBA[..2], Kind::Float),
            Format::R32G32B32_SFLOAT => (&RGBA[..3], Kind::Float),
            Format::R32G32B32A32_SFLOAT => (RGBA, Kind::Float),
            _ => return None,
        };
        Some(Self { channels, kind })
    }

    /// Bytes of a level in the file; the limits have made sure that their number fits.
    pub(super) fn bytes(&self, width: u32, height: u32) -> usize {
        let sample = match self.kind {
            Kind::Unorm8 => 1,
            Kind::Unorm16 | Kind::Half => 2,
            Kind::Float => 4,
        };
        width as usize * height as usize * self.channels.len() * sample
    }

    /// Most bytes that a texel takes, in memory or in the file.
    pub(super) fn texel_bytes(&self) -> u64 {
        match self.kind {
            Kind::Unorm8 => 4,
            Kind::Unorm16 => 8,
            Kind::Half | Kind::Float => 16,
        }
    }

    pub(super) fn texels(&self, level: &[u8]) -> Result<Texels, Problem> {
        let half = |bytes| radiance(f16::from_bits(u16::from_le_bytes(bytes)).to_f32(), f16::MAX.to_f32());
        let float = |bytes| radiance(f32::from_le_bytes(bytes), f32::MAX);
        Ok(match self.kind {
            Kind::Unorm8 => Texels::Rgba8(self.each(level, [0, 0, 0, u8::MAX], |[byte]| byte)?),
            Kind::Unorm16 => Texels::Rgba16(self.each(level, [0, 0, 0, u16::MAX], u16::from_le_bytes)?),
            Kind::Half => Texels::Rgb32F(self.each(level, [0.0; 3], half)?),
            Kind::Float => Texels::Rgb32F(self.each(level, [0.0; 3], float)?),
        })
    }

    /// Texels of a level, each number made by `value` from its bytes. Channels that the file lacks come from `missing`,
    /// channels beyond those of `missing` are dropped.
    fn each<T: Copy, const N: usize, const M: usize>(
        &self,
        level: &[u8],
        missing: [T; M],
        value: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<[T; M]>, Problem> {
        let (samples, rest) = level.as_chunks();
        let mut texels = filled(samples.len() / self.channels.len(), missing)?;
        for (texel, samples) in texels.iter_mut().zip(samples.chunks_exact(self.channels.len())) {
            for (color, sample) in self.channels.iter().zip(samples) {
                if let Some(color) = texel.get_mut(*color) {
                    *color = value(*sample);
                }
            }
        }
        if rest.is_empty() { Ok(texels) } else { Err(malformed("its first level ends within a number")) }
    }
}
