//! From radiance to what is looked at.

use std::sync::Arc;

use raggio_kernels::cpu::{Buffers, InstructionSet, dispatch};
use raggio_kernels::{Comparison, EntryPoint, FilmPixel, ToneMapper, View, Work};
use raggio_vulkan::Buffer;

use crate::pictures::film::Film;
use crate::pictures::linear_image::Image;

/// Displayable pixels, 0xAABBGGRR in sRGB, row by row from the top left.
pub enum Pixels {
    /// In the host's memory.
    Host(Vec<u32>),
    /// In the memory of the device that traced them.
    Device(Arc<Buffer>),
}

/// How a film becomes the colours of a screen or a PNG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Stops: each doubles the brightness.
    pub exposure: f32,
    /// The curve.
    pub tone_mapper: ToneMapper,
    /// What is looked at, in the film of the view's feature.
    pub view: View,
    /// Where the colours of a view end, if they have an end: the distance that is middle grey, the most rays per sample,
    /// the most samples. Positive.
    pub scale: f32,
    /// With the session's reference; nothing is compared without one, nor in views of anything but radiance.
    pub comparison: Comparison,
    /// The column from which on [`Comparison::Split`] shows the reference.
    pub split: u32,
}

impl Default for Display {
    fn default() -> Self {
        Self {
            exposure: 0.0,
            tone_mapper: ToneMapper::Neutral,
            view: View::Radiance,
            scale: 1.0,
            comparison: Comparison::Off,
            split: 0,
        }
    }
}

impl Display {
    /// `work` with these settings.
    pub(crate) fn apply(self, work: Work, has_reference: bool) -> Work {
        let comparable = has_reference && self.view == View::Radiance;
        Work {
            exposure: self.exposure,
            tone_mapper: self.tone_mapper as u32,
            view: self.view as u32,
            // The kernel divides by it; what is not a number is not positive either.
            scale: if self.scale > 0.0 { self.scale.min(f32::MAX) } else { f32::MIN_POSITIVE },
            comparison: if comparable { self.comparison } else { Comparison::Off } as u32,
            split: self.split,
            ..work
        }
    }
}

/// `image` as the display kernel reads it, for a film of this size.
pub(crate) fn reference_pixels(image: &Image, width: u32, height: u32) -> Vec<[f32; 4]> {
    let pixels = |image: &Image| image.pixels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
    if (image.width, image.height) == (width, height) { pixels(image) } else { pixels(&image.resized(width, height)) }
}

/// The display kernel over whole rows, on the calling thread. `reference` has as many pixels, or none.
pub(crate) fn display_rows(
    film: &mut [FilmPixel],
    reference: &[[f32; 4]],
    width: u32,
    display: Display,
    set: InstructionSet,
    output: &mut [u32],
) {
    let rows = (film.len() / width as usize) as u32;
    let work = display.apply(Work { width, height: rows, rows, ..Work::default() }, !reference.is_empty());
    dispatch(set, EntryPoint::Display, None, &work, Buffers { film, output, input: reference, ..Buffers::default() });
}

/// A picture as displayable pixels; its view is [`View::Radiance`].
pub fn show_image(image: &Image, display: Display) -> Pixels {
    Pixels::Host(displayed(&Film::from_image(image), Display { view: View::Radiance, ..display }))
}

/// The display kernel over a whole film, some rows at a time to keep the copies small.
pub(crate) fn displayed(film: &Film, display: Display) -> Vec<u32> {
    const ROWS: usize = 64;
    let set = InstructionSet::best().unwrap_or(InstructionSet::Baseline);
    let tile = ROWS * film.width() as usize;
    let mut output = vec![0; film.pixels().len()];
    for (pixels, output) in film.pixels().chunks(tile).zip(output.chunks_mut(tile)) {
        display_rows(&mut pixels.to_vec(), &[], film.width(), display, set, output);
    }
    output
}
