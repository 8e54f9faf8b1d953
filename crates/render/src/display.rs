//! From radiance to what is looked at.

use raggio_kernels::cpu::{Buffers, InstructionSet, dispatch};
use raggio_kernels::{EntryPoint, FilmPixel, ToneMapper, Work};

use crate::film::Film;

/// How radiance becomes the colours of a screen or a PNG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Stops: each doubles the brightness.
    pub exposure: f32,
    /// The curve.
    pub tone_mapper: ToneMapper,
}

impl Default for Display {
    fn default() -> Self {
        Self { exposure: 0.0, tone_mapper: ToneMapper::Neutral }
    }
}

impl Display {
    /// `work` with these settings.
    pub(crate) fn apply(self, work: Work) -> Work {
        Work { exposure: self.exposure, tone_mapper: self.tone_mapper as u32, ..work }
    }
}

/// The display kernel over whole rows, on the calling thread.
pub(crate) fn display_rows(
    film: &mut [FilmPixel],
    width: u32,
    display: Display,
    set: InstructionSet,
    output: &mut [u32],
) {
    let rows = (film.len() / width as usize) as u32;
    let work = display.apply(Work { width, height: rows, rows, ..Work::default() });
    dispatch(set, EntryPoint::Display, None, &work, Buffers { film, output, ..Buffers::default() });
}

/// The display kernel over a whole film, some rows at a time to keep the copies small.
pub(crate) fn displayed(film: &Film, display: Display) -> Vec<u32> {
    const ROWS: usize = 64;
    let set = InstructionSet::best().unwrap_or(InstructionSet::Baseline);
    let tile = ROWS * film.width() as usize;
    let mut output = vec![0; film.pixels().len()];
    for (pixels, output) in film.pixels().chunks(tile).zip(output.chunks_mut(tile)) {
        display_rows(&mut pixels.to_vec(), film.width(), display, set, output);
    }
    output
}
