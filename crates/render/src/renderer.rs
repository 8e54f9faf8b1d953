//! Renders in portions.

use std::time::{Duration, Instant};

use crate::device::{DeviceError, Session};
use crate::film::Film;

/// Adds samples to a session's film, a portion at a time: each as long as the device has patience for.
///
/// Portions and passes never change the picture: a sample's random numbers depend on its pixel and number alone.
pub struct Renderer<'a> {
    session: Box<dyn Session + 'a>,
    width: u32,
    height: u32,
    target: u32,
    /// The pass under way adds these samples to every pixel...
    pass: std::ops::Range<u32>,
    /// ...and has come as far as this row.
    row: u32,
    /// Of the last portion, in samples per second; before the first a guess that is safe for any device.
    rate: f64,
    /// Of the slowest portion of the pass under way, and of the pass before: rows of glass cost many times what rows of
    /// sky do.
    slowest: f64,
    slowest_before: f64,
    sampling: Duration,
}

const SHORTEST_MEASURE: Duration = Duration::from_millis(1);

/// How far a render has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Samples that every pixel has.
    pub samples: u32,
    /// Samples in all pixels together.
    pub total_samples: u64,
    /// Of the whole, 0 to 1.
    pub fraction: f64,
    /// Spent sampling.
    pub seconds: f64,
}

impl<'a> Renderer<'a> {
    /// For `target` samples per pixel of a `width` x `height` image.
    pub fn new(session: Box<dyn Session + 'a>, width: u32, height: u32, target: u32) -> Self {
        Self {
            session,
            width,
            height,
            target,
            pass: 0..0,
            row: height,
            rate: 2e5,
            slowest: f64::INFINITY,
            slowest_before: f64::INFINITY,
            sampling: Duration::ZERO,
        }
    }

    /// True once every pixel has all its samples.
    pub fn finished(&self) -> bool {
        self.row == self.height && self.pass.end == self.target
    }

    /// Renders one portion.
    pub fn advance(&mut self) -> Result<Progress, DeviceError> {
        if self.finished() {
            return Ok(self.progress());
        }
        if self.row == self.height {
            self.slowest_before = std::mem::replace(&mut self.slowest, f64::INFINITY);
            // As many samples at once as one portion can give to the whole image, and at least one.
            let affordable = self.portion() / (f64::from(self.width) * f64::from(self.height));
            let samples = (affordable as u32).clamp(1, self.target - self.pass.end);
            self.pass = self.pass.end..self.pass.end + samples;
            self.row = 0;
        }
        let row_samples = f64::from(self.width) * self.pass.len() as f64;
        let rows = ((self.portion() / row_samples) as u32).clamp(1, self.height - self.row);

        let start = Instant::now();
        self.session.add_samples(self.row..self.row + rows, self.pass.clone())?;
        let elapsed = start.elapsed();

        self.sampling += elapsed;
        self.row += rows;
        // Rows differ in cost: follow the measurement, but grow no faster than fourfold.
        let measured = f64::from(rows) * row_samples / elapsed.as_secs_f64().max(1e-6);
        self.rate = measured.min(4.0 * self.rate);
        // Shorter portions measure the call, and the very first the driver's preparations.
        if elapsed > SHORTEST_MEASURE && self.sampling > elapsed {
            self.slowest = self.slowest.min(measured);
        }
        Ok(self.progress())
    }

    /// Samples that the device has the patience for, in all pixels together.
    fn portion(&self) -> f64 {
        self.rate.min(self.slowest_before) * self.session.patience_seconds()
    }

    /// How far it has come.
    pub fn progress(&self) -> Progress {
        let width = u64::from(self.width);
        let pixels = width * u64::from(self.height);
        let total_samples = u64::from(self.pass.start) * pixels + u64::from(self.row) * width * self.pass.len() as u64;
        Progress {
            samples: if self.row == self.height { self.pass.end } else { self.pass.start },
            total_samples,
            fraction: total_samples as f64 / (pixels * u64::from(self.target)) as f64,
            seconds: self.sampling.as_secs_f64(),
        }
    }

    /// The film as it is now.
    pub fn film(&self) -> Result<Film, DeviceError> {
        self.session.film()
    }
}
