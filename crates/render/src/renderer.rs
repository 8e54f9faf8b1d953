//! Renders in portions.

use std::time::{Duration, Instant};

use crate::device::{Change, DeviceError, Session};
use crate::device_scene::DeviceScene;
use crate::film::Film;

/// Adds samples to a session's film, a portion at a time: each as long as the device has patience for.
///
/// Portions and passes never change the picture: a sample's random numbers depend on its pixel and number alone.
pub struct Renderer {
    session: Box<dyn Session>,
    width: u32,
    height: u32,
    target: u32,
    samples_per_pass: Option<u32>,
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

impl Renderer {
    /// For `target` samples per pixel of a `width` x `height` image.
    pub fn new(session: Box<dyn Session>, width: u32, height: u32, target: u32) -> Self {
        Self {
            session,
            width,
            height,
            target,
            samples_per_pass: None,
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
        self.row == self.height && self.pass.end >= self.target
    }

    /// Begins anew, with another scene, view or size; what it has learned of the device's speed stays.
    pub fn restart(&mut self, scene: &DeviceScene, change: Change) -> Result<(), DeviceError> {
        self.session.restart(scene, change)?;
        (self.width, self.height) = (scene.work.width, scene.work.height);
        self.pass = 0..0;
        self.row = self.height;
        self.slowest = f64::INFINITY;
        self.slowest_before = f64::INFINITY;
        self.sampling = Duration::ZERO;
        Ok(())
    }

    /// Changes how many samples each pixel is to have; a pass under way is finished.
    pub fn set_target(&mut self, target: u32) {
        self.target = target;
    }

    /// Samples that a pass adds to each pixel; `None`: as many as the device does in one portion.
    pub fn set_samples_per_pass(&mut self, samples: Option<u32>) {
        self.samples_per_pass = samples;
    }

    /// Samples per second, in all pixels together, as lately measured.
    pub fn rate(&self) -> f64 {
        self.rate.min(self.slowest_before)
    }

    /// The scene and the film on the device.
    pub fn session(&mut self) -> &mut dyn Session {
        &mut *self.session
    }

    /// Renders one portion, of the length that the device has patience for.
    pub fn advance(&mut self) -> Result<Progress, DeviceError> {
        self.advance_for(f64::INFINITY)
    }

    /// Renders one portion that takes about `seconds`, and no longer than the device has patience for.
    pub fn advance_for(&mut self, seconds: f64) -> Result<Progress, DeviceError> {
        let portion = self.rate() * seconds.min(self.session.patience_seconds());
        if self.finished() {
            return Ok(self.progress());
        }
        if self.row == self.height {
            self.slowest_before = std::mem::replace(&mut self.slowest, f64::INFINITY);
            // As many samples at once as one portion can give to the whole image, and at least one.
            let affordable = portion / (f64::from(self.width) * f64::from(self.height));
            let samples = self.samples_per_pass.unwrap_or(affordable as u32).clamp(1, self.target - self.pass.end);
            self.pass = self.pass.end..self.pass.end + samples;
            self.row = 0;
        }
        let row_samples = f64::from(self.width) * self.pass.len() as f64;
        let rows = ((portion / row_samples) as u32).clamp(1, self.height - self.row);

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
