//! The film on the host, where samples add up.

mod file;
mod label;
mod totals;

use std::ops::Range;

use raggio_kernels::{FilmPixel, FixedSum};

use crate::pictures::linear_image::Image;
use crate::pictures::runs::{collect, fill, in_runs};

use totals::{Known, Totals};

pub use file::FilmError;
pub(crate) use label::Note;
pub use label::{Label, MergeError, Portion};

/// Sum and count of the samples of each pixel.
///
/// Sums are exact (see `kernels/film.slang`): films of different sample ranges [merge](Film::merge) to the very film that
/// one render of all samples gives. A film that has a [`Label`] says which picture it is of and which samples it has, and
/// can be [written to a file](Film::write).
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<FilmPixel>,
    label: Option<Label>,
    coverage: Option<Box<Film>>,
    known: Known,
}

/// Memory that the film of an image takes, in bytes.
pub fn film_bytes(width: u32, height: u32) -> u64 {
    u64::from(width) * u64::from(height) * size_of::<FilmPixel>() as u64
}

impl Film {
    /// Film of `width` x `height` pixels without samples and without a label.
    pub fn new(width: u32, height: u32) -> Self {
        // Memory that the system gives zeroed is touched by those alone who add samples.
        Self::from_pixels(width, height, bytemuck::zeroed_vec(width as usize * height as usize))
    }

    /// Film of the sums that a device has accumulated, row by row from the top left; without a label.
    ///
    /// # Panics
    /// A panic unless there are `width` times `height` pixels.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<FilmPixel>) -> Self {
        assert_eq!(pixels.len(), width as usize * height as usize);
        Self { width, height, pixels, label: None, coverage: None, known: Known::default() }
    }

    /// Film that shows `image`: a sample a pixel; without a label.
    pub fn from_image(image: &Image) -> Self {
        let pixel = |rgb: &[f32; 3]| {
            let [red, green, blue] = rgb.map(|channel| FixedSum::of(f64::from(channel)));
            FilmPixel { red, green, blue, samples: 1, ..FilmPixel::default() }
        };
        let pixels = collect(image.pixels.len(), |i| pixel(&image.pixels[i]));
        let film = Self::from_pixels(image.width, image.height, pixels);
        let covered = |alpha: &f32| pixel(&[*alpha, 1.0, 0.0]);
        let coverage = image.alpha.as_ref().map(|alpha| alpha.iter().map(covered).collect());
        film.with_coverage(coverage.map(|pixels| Self::from_pixels(image.width, image.height, pixels)))
    }

    /// The film with that of [`Feature::Coverage`](crate::Feature::Coverage) of the same samples, or without one.
    ///
    /// # Panics
    /// A panic unless both are of one size.
    pub fn with_coverage(self, coverage: Option<Self>) -> Self {
        assert!(coverage.iter().all(|coverage| (coverage.width, coverage.height) == (self.width, self.height)));
        Self { coverage: coverage.map(Box::new), ..self }
    }

    /// Film of coverage, if the picture has an alpha channel.
    pub fn coverage(&self) -> Option<&Self> {
        self.coverage.as_deref()
    }

    /// Whether the film is of a picture that should have an alpha channel, and has none: it was not finished, or had one that
    /// was not added to it.
    pub fn lacks_coverage(&self) -> bool {
        let has_alpha = |label: &Label| label.settings().any(|setting| setting == ("alpha", "true"));
        self.coverage.is_none() && self.label.as_ref().is_some_and(has_alpha)
    }

    /// Alpha of each pixel, 0 to 1: the part of it that is covered by what the camera sees first. `None` for pictures with
    /// their background.
    pub fn alpha(&self) -> Option<Vec<f32>> {
        // Weights of the samples come to 1 in the mean of all pixels, and not in each; their quotient is that of the
        // covered ones.
        let alpha = |pixel: &FilmPixel| match pixel.mean() {
            [covered, all, _] if all != 0.0 => (covered / all).clamp(0.0, 1.0) as f32,
            [covered, ..] => covered.clamp(0.0, 1.0) as f32,
        };
        let coverage = self.coverage.as_ref()?;
        Some(collect(coverage.pixels.len(), |i| alpha(&coverage.pixels[i])))
    }

    /// The film with `label`, which says what it is of.
    pub(crate) fn with_label(self, label: Label) -> Self {
        Self { label: Some(label), ..self }
    }

    /// Label that says which picture the film is of, and which samples it has; `None` for sums alone.
    pub fn label(&self) -> Option<&Label> {
        self.label.as_ref()
    }

    /// The film with these notes on its label, if it has one.
    pub(crate) fn with_notes(self, notes: Vec<Note>) -> Self {
        Self { label: self.label.map(|label| label.with_notes(notes)), ..self }
    }

    /// Samples that are missing up to the last that the film has; empty for films without labels.
    pub fn missing(&self) -> Vec<Portion> {
        self.label.as_ref().map(|label| label.missing(self.height)).unwrap_or_default()
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Sums of the pixels, row by row from the top left.
    pub fn pixels(&self) -> &[FilmPixel] {
        &self.pixels
    }

    pub(crate) fn pixels_mut(&mut self) -> &mut [FilmPixel] {
        self.known = Known::default();
        &mut self.pixels
    }

    /// Adds the samples of `other`, which must be other samples of the same picture.
    ///
    /// # Errors
    /// A [`MergeError`] when labels show that the films are of different pictures, or have samples in common; when one
    /// film alone has a label; when sizes differ. This film stays as it was then. Films without labels are the caller's
    /// responsibility. Coverage is kept where both have it.
    pub fn merge(&mut self, other: &Film) -> Result<(), MergeError> {
        if (self.width, self.height) != (other.width, other.height) {
            return Err(MergeError::Size([self.width, self.height], [other.width, other.height]));
        }
        match (&mut self.label, &other.label) {
            (Some(label), Some(other)) => label.merge(other)?,
            (None, None) => {}
            _ => return Err(MergeError::Unlabelled),
        }
        fill(self.pixels_mut(), |first, run| {
            run.iter_mut().zip(&other.pixels[first..]).for_each(|(into, from)| into.merge(from));
        });
        match (&mut self.coverage, &other.coverage) {
            (Some(coverage), Some(other)) => coverage.merge(other)?,
            _ => self.coverage = None,
        }
        Ok(())
    }

    /// Mean radiance of each pixel, with its alpha if it has one; black where there is no sample.
    pub fn mean(&self) -> Image {
        let mean = |i: usize| self.pixels[i].mean().map(|channel| channel as f32);
        let pixels = collect(self.pixels.len(), mean);
        Image { width: self.width, height: self.height, pixels, alpha: self.alpha() }
    }

    fn totals(&self) -> &Totals {
        self.known.of(&self.pixels)
    }

    /// Number of samples in all pixels together.
    pub fn samples(&self) -> u64 {
        self.totals().samples
    }

    /// Fewest and most samples of any pixel, those left out included.
    pub fn sample_range(&self) -> (u32, u32) {
        let totals = self.totals();
        (totals.fewest_taken.min(totals.most_taken), totals.most_taken)
    }

    /// Most samples that any pixel has.
    pub fn most_samples(&self) -> u32 {
        self.totals().most_samples
    }

    /// Number of samples that were left out because they had no value that can be added up.
    pub fn rejected(&self) -> u64 {
        self.totals().rejected
    }

    /// Share of the luminance that clamping took off, 0 to 1.
    pub fn clamped_share(&self) -> f64 {
        let clamped = self.totals().clamped;
        if clamped <= 0.0 {
            return 0.0;
        }
        let luminance = |pixel: &FilmPixel| pixel.luminance() * f64::from(pixel.samples);
        let run = |run: Range<usize>| self.pixels[run].iter().map(luminance).sum::<f64>();
        let kept: f64 = in_runs(self.pixels.len(), run).into_iter().sum();
        clamped / (kept + clamped)
    }

    /// Number of rays traced; exact as long as each pixel took fewer than 2^32.
    pub fn rays(&self) -> u64 {
        self.totals().rays
    }
}
