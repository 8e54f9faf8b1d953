//! Display of films: exposure, tone mapping, views and comparison.

use std::sync::Arc;

use raggio_kernels::cpu::{Buffers, InstructionSet, dispatch};
use raggio_kernels::{Comparison, EntryPoint, FilmPixel, ToneMapper, View, Work};
use raggio_vulkan::Buffer;

use crate::pictures::film::Film;
use crate::pictures::linear_image::Image;

/// Displayable pixels, 0xAABBGGRR in sRGB, row by row from the top left.
pub enum Pixels {
    /// Pixels in the host's memory.
    Host(Vec<u32>),
    /// Pixels in the memory of the device that traced them.
    Device(Arc<Buffer>),
}

/// Settings by which a film becomes the colours of a screen or a PNG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Exposure in stops, each of which doubles the brightness.
    pub exposure: f32,
    /// Curve that squeezes radiance into what a display can show.
    pub tone_mapper: ToneMapper,
    /// Way of looking at the film, which is that of the view's feature.
    pub view: View,
    /// End of the colours of a view, if they have one: the distance that is middle grey, the most rays per sample, the
    /// most samples. Positive.
    pub scale: f32,
    /// Comparison with the session's reference; nothing is compared without one, nor in views of anything but radiance.
    pub comparison: Comparison,
    /// Column of pixels from which on [`Comparison::Split`] shows the reference.
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
    /// Work of the display kernel: `work` with these settings.
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

/// Pixels of `image` as the display kernel reads them, resized to a film of `width` x `height` pixels.
pub(crate) fn reference_pixels(image: &Image, width: u32, height: u32) -> Vec<[f32; 4]> {
    let pixels = |image: &Image| image.pixels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
    if (image.width, image.height) == (width, height) { pixels(image) } else { pixels(&image.resized(width, height)) }
}

/// Runs the display kernel over whole rows, on the calling thread. `reference` has as many pixels, or none.
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

/// Runs the display kernel over a whole film, some rows at a time to keep the copies small.
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
