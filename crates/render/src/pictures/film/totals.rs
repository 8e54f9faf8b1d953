//! What all pixels of a film come to together, found in one pass over them and known from then on.

use std::sync::OnceLock;

use raggio_kernels::FilmPixel;

use crate::pictures::runs::in_runs;

/// Counts of all pixels together, and their extremes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Totals {
    pub samples: u64,
    pub rejected: u64,
    pub rays: u64,
    /// Fewest and most samples of a pixel, those left out included.
    pub fewest_taken: u32,
    pub most_taken: u32,
    /// Most samples of a pixel in its sums.
    pub most_samples: u32,
    /// Luminance that clamping took off.
    pub clamped: f64,
}

impl Totals {
    const NONE: Self =
        Self { samples: 0, rejected: 0, rays: 0, fewest_taken: u32::MAX, most_taken: 0, most_samples: 0, clamped: 0.0 };

    fn of(pixels: &[FilmPixel]) -> Self {
        pixels.iter().fold(Self::NONE, |sum, pixel| {
            let taken = pixel.samples + pixel.rejected;
            let is_clamped = [pixel.clamped.low, pixel.clamped.middle, pixel.clamped.high] != [0; 3];
            Self {
                samples: sum.samples + u64::from(pixel.samples),
                rejected: sum.rejected + u64::from(pixel.rejected),
                rays: sum.rays + u64::from(pixel.rays),
                fewest_taken: sum.fewest_taken.min(taken),
                most_taken: sum.most_taken.max(taken),
                most_samples: sum.most_samples.max(pixel.samples),
                clamped: if is_clamped { sum.clamped + pixel.clamped.value() } else { sum.clamped },
            }
        })
    }

    fn and(self, other: Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            rejected: self.rejected + other.rejected,
            rays: self.rays + other.rays,
            fewest_taken: self.fewest_taken.min(other.fewest_taken),
            most_taken: self.most_taken.max(other.most_taken),
            most_samples: self.most_samples.max(other.most_samples),
            clamped: self.clamped + other.clamped,
        }
    }
}

/// Totals of a film's pixels, once somebody has asked for them. They follow from the pixels, so that films with the same
/// pixels are equal whoever has asked.
#[derive(Clone, Debug, Default)]
pub(super) struct Known(OnceLock<Totals>);

impl Known {
    /// Totals of `pixels`, which are the film's.
    pub fn of(&self, pixels: &[FilmPixel]) -> &Totals {
        let in_parts = || in_runs(pixels.len(), |run| Totals::of(&pixels[run]));
        self.0.get_or_init(|| in_parts().into_iter().fold(Totals::NONE, Totals::and))
    }
}

impl PartialEq for Known {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
