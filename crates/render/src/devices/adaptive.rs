//! Adaptive sampling: the parts of a picture that need more samples.

use std::ops::Range;

use raggio_kernels::BLOCK;

use crate::pictures::film::Film;

/// Samples a pixel before anything is judged: fewer say little about their own error.
const FIRST: u32 = 64;
/// Part of the picture's luminance that a block's error is relative to besides its own: nobody sees noise in black.
const DARKEST: f64 = 0.01;

/// Samples a pixel at which blocks are judged next: 64, 80, 96, 112, 128, 160, and so on, four times in each doubling.
/// These numbers are fixed, so that what is judged, and with it the picture, does not depend on portions or passes.
pub(crate) fn next_judgement(samples: u32) -> u32 {
    if samples < FIRST {
        return FIRST;
    }
    let step = 1 << (samples.ilog2() - 2);
    (samples / step + 1).saturating_mul(step)
}

/// The blocks of a picture, as the kernels divide it, and which of them take no more samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    width: u32,
    height: u32,
    words: Vec<u32>,
}

impl Blocks {
    /// Blocks of a picture of `width` x `height` pixels, none of which rests.
    pub fn new(width: u32, height: u32) -> Self {
        let blocks = width.div_ceil(BLOCK) as usize * height.div_ceil(BLOCK) as usize;
        Self { width, height, words: vec![0; blocks.div_ceil(32)] }
    }

    /// Blocks that rest as `words` say; `None` if these are not as many as such a picture has.
    pub(crate) fn from_words(width: u32, height: u32, words: Vec<u32>) -> Option<Self> {
        let empty = Self::new(width, height);
        (words.len() == empty.words.len()).then_some(Self { words, ..empty })
    }

    /// Blocks of which all rest but those with pixels, in these rows, that `is_active` is true of; pixels are counted row by
    /// row from the top left.
    pub(crate) fn resting_but(width: u32, height: u32, rows: Range<u32>, is_active: impl Fn(usize) -> bool) -> Self {
        let mut blocks = Self::new(width, height);
        blocks.words.fill(u32::MAX);
        let columns = blocks.columns();
        for y in rows {
            for x in (0..width).filter(|x| is_active((y * width + x) as usize)) {
                let block = y / BLOCK * columns + x / BLOCK;
                blocks.words[block as usize / 32] &= !(1 << (block % 32));
            }
        }
        blocks
    }

    /// Bits of the blocks, row by row, 32 to a word, lowest first, as the kernels read them: 1 where a block rests.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Whether the block in this column and row of blocks rests.
    pub fn rests(&self, column: u32, row: u32) -> bool {
        let block = (row * self.columns() + column) as usize;
        self.words[block / 32] >> (block % 32) & 1 != 0
    }

    /// Number of pixels of `rows` that take samples.
    pub fn active_pixels(&self, rows: Range<u32>) -> u64 {
        let width = |column: u32| u64::from(BLOCK.min(self.width - column * BLOCK));
        let row = |y: u32| (0..self.columns()).filter(|&column| !self.rests(column, y / BLOCK)).map(width).sum::<u64>();
        rows.map(row).sum()
    }

    /// Lets blocks rest whose relative error, and that of the blocks around them, is below `noise`. A block that rests
    /// does so for good. Judging neighbours together keeps a block from resting early because it has missed what they
    /// have found. Returns the largest error of the blocks.
    pub(crate) fn judge(&mut self, film: &Film, noise: f64) -> f64 {
        let (columns, rows) = (self.columns(), self.height.div_ceil(BLOCK));
        let least = DARKEST * mean_luminance(film, 0..self.width, 0..self.height);
        let errors: Vec<f64> = (0..columns * rows).map(|i| self.error(film, i % columns, i / columns, least)).collect();
        for block in 0..columns * rows {
            let (x, y) = (block % columns, block / columns);
            let around = (y.saturating_sub(1)..rows.min(y + 2))
                .flat_map(|y| (x.saturating_sub(1)..columns.min(x + 2)).map(move |x| y * columns + x));
            if around.map(|i| errors[i as usize]).fold(0.0, f64::max) < noise {
                self.words[block as usize / 32] |= 1 << (block % 32);
            }
        }
        errors.into_iter().fold(0.0, f64::max)
    }

    fn columns(&self) -> u32 {
        self.width.div_ceil(BLOCK)
    }

    /// Root mean square of the standard errors of a block's pixels, over its luminance.
    fn error(&self, film: &Film, column: u32, row: u32, least: f64) -> f64 {
        let part = |place: u32, size: u32| place * BLOCK..size.min((place + 1) * BLOCK);
        let (columns, rows) = (part(column, self.width), part(row, self.height));
        let errors = pixels(film, columns.clone(), rows.clone()).map(|p| p.luminance_error().unwrap_or(f64::INFINITY));
        let count = (columns.len() * rows.len()) as f64;
        let error = (errors.map(|error| error * error).sum::<f64>() / count).sqrt();
        if error > 0.0 { error / (mean_luminance(film, columns, rows) + least) } else { 0.0 }
    }
}

fn mean_luminance(film: &Film, columns: Range<u32>, rows: Range<u32>) -> f64 {
    let count = columns.len() as f64 * rows.len() as f64;
    pixels(film, columns, rows).map(|pixel| pixel.luminance().abs()).sum::<f64>() / count
}

fn pixels(film: &Film, columns: Range<u32>, rows: Range<u32>) -> impl Iterator<Item = &raggio_kernels::FilmPixel> {
    let width = film.width() as usize;
    rows.flat_map(move |y| &film.pixels()[y as usize * width..][columns.start as usize..columns.end as usize])
}

#[cfg(test)]
mod tests {
    use raggio_kernels::{FilmPixel, FixedSum};

    use super::*;

    #[test]
    fn judgements_come_four_times_in_each_doubling() {
        let mut samples = 0;
        let found: Vec<u32> = std::iter::repeat_with(|| {
            samples = next_judgement(samples);
            samples
        })
        .take(10)
        .collect();
        assert_eq!(found, [64, 80, 96, 112, 128, 160, 192, 224, 256, 320]);
        assert_eq!(next_judgement(70), 80);
        assert!(next_judgement(i32::MAX as u32) > i32::MAX as u32);
    }

    /// Luminance 1 everywhere, and in one pixel a standard error of 10 %.
    #[test]
    fn noise_keeps_its_neighbourhood_awake() {
        let quiet = FilmPixel {
            red: FixedSum::of(64.0),
            green: FixedSum::of(64.0),
            blue: FixedSum::of(64.0),
            squares: FixedSum::of(64.0),
            samples: 64,
            ..FilmPixel::default()
        };
        let mut pixels = vec![quiet; 40 * 20];
        pixels[0].squares = FixedSum::of(64.0 + 0.01 * 64.0 * 63.0);
        let film = Film::from_pixels(40, 20, pixels);
        let mut blocks = Blocks::new(40, 20);
        assert_eq!(blocks.active_pixels(0..20), 800);
        // Over the 64 pixels of its block the root mean square is 0.1 / 8, and the picture adds a hundredth of its light.
        blocks.judge(&film, 0.0125 / 1.01 * 0.99);
        let resting: Vec<_> =
            (0..3).map(|row| (0..5).map(|column| blocks.rests(column, row)).collect::<Vec<_>>()).collect();
        assert_eq!(resting[0], [false, false, true, true, true]);
        assert_eq!(resting[1], [false, false, true, true, true]);
        assert_eq!(resting[2], [true; 5]);
        assert_eq!(blocks.active_pixels(0..20), 256);
        assert_eq!(blocks.active_pixels(15..17), 16);
        blocks.judge(&film, 0.0125);
        assert_eq!(blocks.active_pixels(0..20), 0);
    }
}
