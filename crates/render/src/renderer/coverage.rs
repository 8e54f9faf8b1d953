//! Coverage of pixels by what the camera sees first, for the alpha channel.

use std::collections::BTreeSet;
use std::ops::{ControlFlow, Range};
use std::time::Instant;

use raggio_kernels::Feature;

use super::{GROWTH, Renderer};
use crate::devices::adaptive::Blocks;
use crate::devices::device::DeviceError;
use crate::pictures::film::Film;

/// Samples a pixel with which whoever cannot wait has to be content: fewer make stairs of edges.
const FEWEST: u32 = 16;

impl Renderer {
    /// Film of coverage of the very samples that `radiance`, this renderer's film, has: as many of each pixel, so that both
    /// have the same edges with the same noise. Once `proceed`, which is asked after each portion, no longer lets it, pixels
    /// get no more than a few. The film that is shown stays as it is.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn coverage(
        &mut self,
        radiance: &Film,
        mut proceed: impl FnMut() -> ControlFlow<()>,
    ) -> Result<Film, DeviceError> {
        self.showing_coverage(|renderer| {
            renderer.cover(radiance, f64::INFINITY, &mut proceed)?;
            renderer.session.film()
        })
    }

    /// Spends about `seconds` on the film of [`Renderer::coverage`], which is returned once it is whole.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn advance_coverage(&mut self, radiance: &Film, seconds: f64) -> Result<Option<Film>, DeviceError> {
        self.showing_coverage(|renderer| {
            let is_whole = renderer.cover(radiance, seconds, &mut || ControlFlow::Continue(()))?;
            is_whole.then(|| renderer.session.film()).transpose()
        })
    }

    /// Does something to the film of coverage, and shows the one before again.
    fn showing_coverage<T>(
        &mut self,
        what: impl FnOnce(&mut Self) -> Result<T, DeviceError>,
    ) -> Result<T, DeviceError> {
        let shown = self.feature();
        let done = self.show(Feature::Coverage).and_then(|()| what(self));
        let resting = self.session.rest(self.adaptive.as_ref().map(|adaptive| &adaptive.blocks));
        self.show(shown)?;
        resting.and(done)
    }

    /// Adds what coverage lacks of the samples of `radiance`, for about `seconds`. Returns whether it has them all.
    fn cover(
        &mut self,
        radiance: &Film,
        seconds: f64,
        proceed: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<bool, DeviceError> {
        let begun = Instant::now();
        let wanted = taken(radiance);
        let has = taken(&self.session.film()?);
        let levels: BTreeSet<u32> = has.iter().chain(&wanted).copied().collect();
        let levels: Vec<u32> = levels.into_iter().collect();
        let patience = self.session.patience_seconds().min(seconds);
        let mut portion = self.rate() * patience;
        let mut most = u32::MAX;
        // Pixels that have fewer samples than others are in blocks that rest, or in rows that a pass has not come to.
        for step in levels.windows(2) {
            let (from, to) = (step[0], step[1].min(most));
            let lacks = |pixel: usize| has[pixel] <= from && wanted[pixel] >= step[1];
            let Some(rows) = rows_with(self.width, self.height, lacks).filter(|_| from < to) else { continue };
            let blocks = Blocks::resting_but(self.width, self.height, rows.clone(), lacks);
            self.session.rest(Some(&blocks))?;
            let pixels = blocks.active_pixels(rows.clone()).max(1) as f64;
            let mut samples = from..from;
            while samples.end < to.min(most) {
                samples = samples.end..samples.end + ((portion / pixels) as u32).clamp(1, to.min(most) - samples.end);
                let mut row = rows.start;
                while row < rows.end {
                    let row_samples = pixels / rows.len() as f64 * samples.len() as f64;
                    let left = rows.end - row;
                    let count =
                        ((portion / row_samples) as u32).clamp(self.session.rows_at_once().clamp(1, left), left);
                    let start = Instant::now();
                    let numbers = self.samples.start + samples.start..self.samples.start + samples.end;
                    self.session.add_samples(row..row + count, numbers)?;
                    row += count;
                    let rate = f64::from(count) * row_samples / start.elapsed().as_secs_f64().max(1e-6);
                    portion = (rate * patience).min(GROWTH * portion);
                    if begun.elapsed().as_secs_f64() >= seconds {
                        return Ok(false);
                    }
                    if proceed().is_break() {
                        most = FEWEST;
                    }
                }
            }
        }
        Ok(true)
    }
}

/// Number of samples that each pixel has been given.
fn taken(film: &Film) -> Vec<u32> {
    film.pixels().iter().map(|pixel| pixel.samples + pixel.rejected).collect()
}

/// Rows from the first to the last with pixels that `lacks` is true of.
fn rows_with(width: u32, height: u32, lacks: impl Fn(usize) -> bool) -> Option<Range<u32>> {
    let width = width as usize;
    let has_any = |row: &u32| (*row as usize * width..(*row as usize + 1) * width).any(&lacks);
    Some((0..height).find(has_any)?..(0..height).rev().find(has_any)? + 1)
}
