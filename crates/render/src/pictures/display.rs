//! Display of films: exposure, tone mapping, views and comparison.

use std::borrow::Cow;
use std::sync::Arc;

use raggio_kernels::cpu::{Buffers, InstructionSet, dispatch};
use raggio_kernels::{Comparison, EntryPoint, FilmPixel, Probe, ToneMapper, View, Work};
use raggio_vulkan::Buffer;
use rayon::prelude::*;

use crate::pictures::film::Film;
use crate::pictures::linear_image::Image;
use crate::pictures::runs::collect;

/// Displayable pixels, 0xAABBGGRR in sRGB, row by row from the top left.
pub enum Pixels {
    /// Pixels in the host's memory.
    Host(Vec<u32>),
    /// Pixels in the memory of the device that traced them.
    Device(Arc<Buffer>),
}

/// Picture without its noise, as far as there is one in the memory of the device that traced it.
pub enum Denoised {
    /// The denoiser does not work there: who wants the picture takes the way through the host.
    Elsewhere,
    /// A driver compiles the kernels that this takes.
    NotYet,
    /// Displayable pixels.
    Shown(Pixels),
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

/// A picture as displays show it: colours of sRGB and, where it has one, its alpha, which no curve bends. Colours are those of
/// what is covered, whatever its part of the pixel.
pub(crate) struct Shown<T> {
    pub colors: Vec<[T; 3]>,
    pub alpha: Option<Vec<T>>,
}

/// A film's picture of 256 steps to a channel.
pub(crate) fn shown(film: &Film, display: Display) -> Shown<u8> {
    let (film, alpha) = straight(film);
    let pixels = displayed(&film, display);
    let colors = collect(pixels.len(), |i| [0, 8, 16].map(|shift| (pixels[i] >> shift) as u8));
    Shown { colors, alpha: alpha.map(|alpha| collect(alpha.len(), |i| (alpha[i] * 255.0).round() as u8)) }
}

impl<T: Copy> Shown<T> {
    /// Red, green, blue and, where there is one, alpha of each pixel.
    pub fn values(&self) -> Cow<'_, [T]> {
        match &self.alpha {
            None => Cow::Borrowed(self.colors.as_flattened()),
            Some(alpha) => self.colors.iter().zip(alpha).flat_map(|(&[r, g, b], alpha)| [r, g, b, *alpha]).collect(),
        }
    }
}

/// A picture as bytes of sRGB: red, green, blue and, where it has one, alpha of each pixel, row by row from the top left.
pub fn show_bytes(image: &Image, display: Display) -> Vec<u8> {
    shown(&Film::from_image(image), Display { view: View::Radiance, ..display }).values().into_owned()
}

/// A film's picture of 65536 steps to a channel.
pub(crate) fn shown_16_bits(film: &Film, display: Display) -> Shown<u16> {
    let (film, alpha) = straight(film);
    let colors = displayed_16_bits(&film, display);
    Shown { colors, alpha: alpha.map(|alpha| alpha.iter().map(|alpha| (alpha * 65535.0).round() as u16).collect()) }
}

/// The film whose colours are to be shown, and its alpha.
fn straight(film: &Film) -> (Cow<'_, Film>, Option<Vec<f32>>) {
    match film.alpha() {
        None => (Cow::Borrowed(film), None),
        Some(alpha) => (Cow::Owned(Film::from_image(&film.mean().straight())), Some(alpha)),
    }
}

/// A picture as displayable pixels; its view is [`View::Radiance`].
pub fn show_image(image: &Image, display: Display) -> Pixels {
    Pixels::Host(displayed(&Film::from_image(image), Display { view: View::Radiance, ..display }))
}

/// Runs the display kernel over a whole film, some rows at a time to keep the copies small, on all threads.
pub(crate) fn displayed(film: &Film, display: Display) -> Vec<u32> {
    // The copies stay in a core's own cache.
    const ROWS: usize = 4;
    let set = InstructionSet::best().unwrap_or(InstructionSet::Baseline);
    let tile = ROWS * film.width() as usize;
    let mut output = bytemuck::zeroed_vec(film.pixels().len());
    film.pixels().par_chunks(tile).zip(output.par_chunks_mut(tile)).for_each(|(pixels, output)| {
        display_rows(&mut pixels.to_vec(), &[], film.width(), display, set, output);
    });
    output
}

/// Runs the display kernel's tone mapper over a whole film, for 65536 steps of each channel; red, green and blue, row by
/// row from the top left. Views other than that of radiance are colours for screens, and have the steps of those.
pub(crate) fn displayed_16_bits(film: &Film, display: Display) -> Vec<[u16; 3]> {
    const PIXELS: usize = 1 << 14;
    if display.view != View::Radiance {
        let pixels = displayed(film, display);
        return collect(pixels.len(), |i| [0, 8, 16].map(|shift| (pixels[i] >> shift & 0xff) as u16 * 0x101));
    }
    let set = InstructionSet::best().unwrap_or(InstructionSet::Baseline);
    let brightening = display.exposure.exp2();
    let radiance = film.mean().pixels;
    let mut output = vec![[0; 3]; radiance.len()];
    radiance.par_chunks(PIXELS).zip(output.par_chunks_mut(PIXELS)).for_each(|(pixels, output)| {
        let question = |pixel: &[f32; 3]| {
            let [r, g, b] = pixel.map(|channel| channel * brightening);
            [[r, g, b, display.tone_mapper as u32 as f32], [0.0; 4], [0.0; 4]]
        };
        let questions: Vec<[[f32; 4]; 3]> = pixels.iter().map(question).collect();
        let mut answers = vec![0u32; 12 * questions.len()];
        let work = Work { probe: Probe::ToneMap as u32, count: questions.len() as u32, ..Work::default() };
        let buffers = Buffers { output: &mut answers, input: questions.as_flattened(), ..Buffers::default() };
        dispatch(set, EntryPoint::Probe, None, &work, buffers);
        for (answer, output) in answers.chunks_exact(12).zip(output) {
            let steps = |channel: usize| (srgb_encode(f32::from_bits(answer[channel]).into()) * 65535.0).round() as u16;
            *output = [0, 1, 2].map(steps);
        }
    });
    output
}

/// The sRGB transfer function (IEC 61966-2-1); linear values in [0, 1].
fn srgb_encode(x: f64) -> f64 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}
