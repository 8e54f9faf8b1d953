//! Renders in portions.

mod coverage;
mod identity;
mod resume;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use raggio_kernels::Feature;

use crate::checkpoint::Gathered;
use crate::devices::adaptive::{Blocks, next_judgement};
use crate::devices::device::{DeviceError, Session};
use crate::devices::films::Films;
use crate::pictures::film::{Film, Label, Portion};
use crate::translation::device_scene::DeviceScene;

use identity::Identity;

pub(crate) use identity::{LateLabel, motion_hash, scene_hash, settings};

/// Adds samples to the film that a session shows, a portion at a time: each as long as the device has patience for.
///
/// Portions and passes never change the picture: a sample's random numbers depend on its pixel and number alone.
/// Renderers of ranges that follow each other make films that [merge](Film::merge) to the film of the whole, bit for
/// bit.
pub struct Renderer {
    session: Box<dyn Session>,
    width: u32,
    height: u32,
    /// Numbers of the samples that each pixel is to have.
    samples: Range<u32>,
    samples_per_pass: Option<u32>,
    /// Most samples that a pass adds to each pixel.
    longest_pass: u32,
    /// Most rays of a path, shadow rays among them.
    longest_path: f64,
    /// Flag of who wants the portion under way to end at once.
    stop: Arc<AtomicBool>,
    courses: Films<Course>,
    adaptive: Option<Adaptive>,
    identity: Arc<Identity>,
    /// Part of the device's patience that portions take: less after each time that it was lost.
    haste: f64,
}

/// Sampling until the error is small enough, for the film of radiance.
struct Adaptive {
    noise: f64,
    blocks: Blocks,
    /// Number of the picture's pixels that take samples.
    active: u64,
    /// Samples at which blocks are judged next.
    judgement: u32,
    /// Largest error of a block when they were judged last; infinite before.
    error: f64,
}

/// Progress of a film, and its speed.
struct Course {
    /// Samples that the pass under way adds to every pixel.
    pass: Range<u32>,
    /// Row that the pass under way has come to; the picture's height once it is finished.
    row: u32,
    /// Rate of the last portion, in samples per second; before the first a guess.
    rate: f64,
    /// Samples of the last portion. The first is as small as can be, and each may be only so much larger than the last:
    /// nobody knows what a path costs before some are done.
    last: f64,
    /// Rate of the slowest portion of the pass under way, and of the pass before: rows of glass cost many times what
    /// rows of sky do.
    slowest: f64,
    slowest_before: f64,
    sampling: Duration,
    /// Number of samples that were added in the time of `sampling`, in all pixels together.
    total: u64,
}

/// Part of the time of portions that those after a failure of the device take.
const HASTE: f64 = 0.25;
/// Multiple of its time after which a portion is cut short.
const PATIENCE: f64 = 1.5;
/// Factor by which a portion may be larger than the one before.
const GROWTH: f64 = 4.0;
/// Multiple of its time that a portion of rows of which nothing is known may take, should all their paths be as long as
/// they may be where those before had a single ray: not every device can be stopped midway.
const SURPRISE: f64 = 32.0;
const SHORTEST_MEASURE: Duration = Duration::from_millis(1);

/// Progress of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Number of samples that every pixel has.
    pub samples: u32,
    /// Number of samples in all pixels together.
    pub total_samples: u64,
    /// Part of the whole that is done, 0 to 1: of the samples, or of the pixels that need no more, or of the time.
    pub fraction: f64,
    /// Sampling by the error that is left, if that is what ends it.
    pub noise: Option<NoiseProgress>,
    /// Time spent sampling, in seconds.
    pub seconds: f64,
}

/// Progress of sampling by the error that is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseProgress {
    /// Largest relative standard error of a part of the picture; infinite until it is known.
    pub error: f64,
    /// Part of the pixels that need no more samples, 0 to 1.
    pub resting: f64,
}

impl Renderer {
    /// Renderer of the samples `samples` of each pixel of `scene`, which `session` has [loaded](crate::Device::load).
    pub fn new(session: Box<dyn Session>, scene: &DeviceScene, samples: Range<u32>) -> Self {
        let (width, height) = (scene.work.width, scene.work.height);
        let course = Course::new(height, samples.start, 2e5, 0.0);
        Self {
            session,
            width,
            height,
            samples,
            samples_per_pass: None,
            longest_pass: u32::MAX,
            longest_path: longest_path(scene),
            stop: Arc::default(),
            courses: Films::new(course),
            adaptive: None,
            identity: Arc::new(Identity::new(scene)),
            haste: 1.0,
        }
    }

    /// Gives pixels no more samples than bring the relative standard error of their block's luminance below `noise`:
    /// see [`Blocks`]. Has to be called before the first sample.
    pub fn set_noise(&mut self, noise: f64) {
        let blocks = Blocks::new(self.width, self.height);
        let active = u64::from(self.width) * u64::from(self.height);
        self.adaptive = Some(Adaptive { noise, blocks, active, judgement: next_judgement(0), error: f64::INFINITY });
    }

    /// Adaptive sampling of the film that is shown, if it is sampled so.
    fn adaptive(&self) -> Option<&Adaptive> {
        self.adaptive.as_ref().filter(|_| self.feature() == Feature::Radiance)
    }

    /// Whether every pixel has all its samples.
    pub fn finished(&self) -> bool {
        let course = self.courses.shown();
        let rested = self.adaptive().is_some_and(|adaptive| adaptive.active == 0);
        course.row == self.height && (course.pass.end >= self.samples.end || rested)
    }

    /// Finds out between passes which blocks need no more samples, if it is time to. Returns how many samples each
    /// pixel may get until it is time again.
    fn judge(&mut self) -> Result<u32, DeviceError> {
        let samples = self.courses.shown().pass.end - self.samples.start;
        let due = self.adaptive().is_some_and(|adaptive| samples >= adaptive.judgement);
        let film = if due { Some(self.session.film()?) } else { None };
        let Some(adaptive) = self.adaptive.as_mut().filter(|_| self.courses.feature() == Feature::Radiance) else {
            return Ok(u32::MAX);
        };
        if let Some(film) = film {
            let mut blocks = adaptive.blocks.clone();
            let error = blocks.judge(&film, adaptive.noise);
            // Only what the device knows counts: it may fail here, and be asked again.
            self.session.rest(Some(&blocks))?;
            adaptive.active = blocks.active_pixels(0..self.height);
            adaptive.judgement = next_judgement(samples);
            adaptive.error = error;
            adaptive.blocks = blocks;
        }
        Ok(adaptive.judgement - samples)
    }

    /// Shows the film of `feature` as [`Session::show`] does; each film goes on from where it was left.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails or has no memory for another film.
    pub fn show(&mut self, feature: Feature) -> Result<(), DeviceError> {
        // No feature takes longer than radiance.
        let (rate, last) = (self.rate(), self.courses.shown().last);
        let Self { session, courses, height, samples, .. } = self;
        // A course begins only where the session could make a film for it.
        courses.show(feature, || {
            session.show(feature)?;
            Ok::<_, DeviceError>(Course::new(*height, samples.start, rate, last))
        })?;
        session.show(feature)
    }

    /// The feature whose film is shown.
    pub fn feature(&self) -> Feature {
        self.courses.feature()
    }

    /// Begins anew, with another scene, view or size; what is known of the device's speed stays.
    ///
    /// # Errors
    /// A [`DeviceError`] when the scene's indices are wrong, or the device fails or has no memory for it.
    pub fn restart(&mut self, scene: &DeviceScene) -> Result<(), DeviceError> {
        self.session.restart(scene)?;
        self.begin_with(scene)
    }

    /// Begins anew as [`Renderer::restart`] does, on a device that was lost.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device stays lost; only another try can follow.
    pub(crate) fn restart_lost(&mut self, scene: &DeviceScene) -> Result<(), DeviceError> {
        self.session.revive(scene)?;
        self.courses = Films::new(Course::new(self.height, self.samples.start, self.rate(), 0.0));
        self.begin_with(scene)
    }

    fn begin_with(&mut self, scene: &DeviceScene) -> Result<(), DeviceError> {
        (self.width, self.height) = (scene.work.width, scene.work.height);
        self.identity = Arc::new(Identity::new(scene));
        self.longest_path = longest_path(scene);
        if let Some(noise) = self.adaptive.as_ref().map(|adaptive| adaptive.noise) {
            self.set_noise(noise);
            self.session.rest(None)?;
        }
        for course in self.courses.iter_mut() {
            *course = Course::new(self.height, self.samples.start, course.lasting_rate(), course.last);
        }
        Ok(())
    }

    /// Gives up memory that only [`restart`](Self::restart) could need again, which should not follow: it would take longer.
    pub fn settle(&mut self) {
        self.session.settle();
        self.identity = Arc::new(self.identity.settled());
    }

    /// Begins anew after a failure of the device with `scene`, which has not changed: from `gathered`, or from the first sample.
    /// Returns what has been done about the failure, in words.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device stays lost; only another try can follow.
    pub(crate) fn revive(&mut self, scene: &DeviceScene, gathered: Option<&Gathered>) -> Result<String, DeviceError> {
        let done = self.session.revive(scene)?;
        // A driver may have lost patience.
        self.haste *= HASTE;
        let shown = Course::new(self.height, self.samples.start, self.rate(), 0.0);
        self.courses = Films::new(shown);
        if let Some(noise) = self.adaptive.as_ref().map(|adaptive| adaptive.noise) {
            self.set_noise(noise);
        }
        if let Some(Gathered { film, state, .. }) = gathered {
            let adaptive = self.adaptive_of(state).flatten();
            self.go_on(film, state, adaptive)?;
        }
        Ok(done)
    }

    /// Begins anew with other samples of `scene`, which is the very one that this renderer has.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn restart_with(&mut self, samples: Range<u32>, scene: &DeviceScene) -> Result<(), DeviceError> {
        self.samples = samples;
        // Its hash may be known already.
        let identity = self.identity.clone();
        self.restart(scene)?;
        self.identity = identity;
        Ok(())
    }

    /// Numbers of the samples that each pixel is to have at most.
    pub fn samples(&self) -> Range<u32> {
        self.samples.clone()
    }

    /// Number of samples that each pixel is to have at most.
    pub fn target(&self) -> u32 {
        self.samples.end - self.samples.start
    }

    /// Changes how many samples each pixel is to have; a pass under way is finished.
    pub fn set_target(&mut self, target: u32) {
        self.samples.end = self.samples.start.saturating_add(target);
    }

    /// Sets the number of samples that a pass adds to each pixel; `None`: as many as the device does in one portion.
    pub fn set_samples_per_pass(&mut self, samples: Option<u32>) {
        self.samples_per_pass = samples;
    }

    /// Samples per second, in all pixels together, as lately measured; before the first portion a guess.
    pub fn rate(&self) -> f64 {
        let course = self.courses.shown();
        course.rate.min(course.slowest_before)
    }

    /// Part of a portion's time for which work is planned. In the first pass nobody knows the rows that come: they may be
    /// of the sky, or of a closed room.
    fn caution(&self) -> f64 {
        let course = self.courses.shown();
        let is_first = course.pass.start == self.samples.start && (course.pass.is_empty() || course.row < self.height);
        if is_first { (SURPRISE / self.longest_path).min(1.0) } else { 1.0 }
    }

    /// Flag that ends the portion under way as soon as the device can, when it is set: what the portion has done stays,
    /// and the next one goes on from there.
    pub fn stop_flag(&self) -> Arc<AtomicBool> {
        self.stop.clone()
    }

    /// The scene and the films on the device. Films are changed by [`Renderer::show`].
    pub fn session(&mut self) -> &mut dyn Session {
        &mut *self.session
    }

    /// Renders one portion, of the length that the device has patience for.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn advance(&mut self) -> Result<Progress, DeviceError> {
        self.advance_for(f64::INFINITY)
    }

    /// Renders one portion that takes about `seconds`, and no longer than the device has patience for.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn advance_for(&mut self, seconds: f64) -> Result<Progress, DeviceError> {
        if self.finished() {
            return Ok(self.progress());
        }
        self.session.prepare()?;
        let seconds = seconds.min(self.session.patience_seconds() * self.haste);
        let portion = (self.rate() * self.caution() * seconds).min(GROWTH * self.courses.shown().last);
        if self.courses.shown().row == self.height {
            let unjudged = self.judge()?;
            if self.finished() {
                return Ok(self.progress());
            }
            let pixels = self.active_pixels();
            let course = self.courses.shown_mut();
            course.slowest_before = std::mem::replace(&mut course.slowest, f64::INFINITY);
            // A pass adds as many samples as one portion can give to the whole image, and at least one.
            let affordable = (portion / pixels) as u32;
            let most = unjudged.min(self.samples.end - course.pass.end).min(self.longest_pass);
            let samples = self.samples_per_pass.unwrap_or(affordable).clamp(1, most);
            course.pass = course.pass.end..course.pass.end + samples;
            course.row = 0;
        }
        let row_samples = self.active_pixels() / f64::from(self.height) * self.courses.shown().pass.len() as f64;
        let course = self.courses.shown();
        let left = self.height - course.row;
        let rows = ((portion / row_samples) as u32).clamp(self.session.rows_at_once().clamp(1, left), left);

        let (first, pass) = (course.row, course.pass.clone());
        let start = Instant::now();
        // Rows differ in cost: what takes much longer than it was thought to is cut short.
        let most = Duration::from_secs_f64(PATIENCE * seconds);
        let stop = || self.stop.load(Ordering::Relaxed) || start.elapsed() > most;
        let rows = self.session.add_samples_until(first..first + rows, pass.clone(), &stop)?;
        let elapsed = start.elapsed();
        let active = self.adaptive().map(|adaptive| adaptive.blocks.active_pixels(first..first + rows));
        let samples = active.unwrap_or(u64::from(rows) * u64::from(self.width)) * pass.len() as u64;

        let course = self.courses.shown_mut();
        course.sampling += elapsed;
        course.total += samples;
        course.row += rows;
        course.last = samples.max(1) as f64;
        let measured = course.last / elapsed.as_secs_f64().max(1e-6);
        // Shorter portions measure the call: the rate is that at least. The very first measures the driver's preparations.
        course.rate = if elapsed > SHORTEST_MEASURE { measured } else { course.rate.max(measured) };
        if elapsed > SHORTEST_MEASURE && course.sampling > elapsed {
            course.slowest = course.slowest.min(measured);
        }
        Ok(self.progress())
    }

    /// Renders portions for about `seconds`, though no more than one pass if passes have a [fixed
    /// number](Self::set_samples_per_pass) of samples. Returns whether every pixel has all its samples.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn run_for(&mut self, seconds: f64) -> Result<bool, DeviceError> {
        let start = Instant::now();
        while !self.finished() {
            let left = seconds - start.elapsed().as_secs_f64();
            // The time left is too short to be worth a call.
            if left <= 0.05 * seconds {
                break;
            }
            let before = self.progress().samples;
            let after = self.advance_for(left)?.samples;
            if self.samples_per_pass.is_some() && after > before {
                break;
            }
        }
        Ok(self.finished())
    }

    /// Renders what is left of the pass under way: then all pixels have equally many samples.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn finish_pass(&mut self) -> Result<(), DeviceError> {
        while self.courses.shown().row < self.height {
            self.advance()?;
        }
        Ok(())
    }

    /// Progress of the film that is shown.
    pub fn progress(&self) -> Progress {
        let Course { pass, row, sampling, total, .. } = self.courses.shown();
        let total_samples = *total;
        let first = self.samples.start;
        let done = f64::from(pass.start - first) + f64::from(*row) / f64::from(self.height) * pass.len() as f64;
        let fraction = done / f64::from(self.target());
        let pixels = f64::from(self.width) * f64::from(self.height);
        let noise = self.adaptive().map(|Adaptive { error, active, .. }| NoiseProgress {
            error: *error,
            resting: 1.0 - *active as f64 / pixels,
        });
        Progress {
            samples: if *row == self.height { pass.end } else { pass.start } - first,
            total_samples,
            fraction: noise.map_or(fraction, |noise| noise.resting.max(fraction)),
            noise,
            seconds: sampling.as_secs_f64(),
        }
    }

    /// Number of pixels that take samples.
    fn active_pixels(&self) -> f64 {
        let all = u64::from(self.width) * u64::from(self.height);
        self.adaptive().map_or(all, |adaptive| adaptive.active) as f64
    }

    /// Film that is shown, as it is now, without a label.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn film(&self) -> Result<Film, DeviceError> {
        self.session.film()
    }

    /// Film of radiance as it is now, with its label: it can be written to a file, and merged with films of other
    /// samples. The first call hashes the scene, which takes a second for each few gigabytes.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn labelled_film(&mut self) -> Result<Film, DeviceError> {
        self.showing(Feature::Radiance, |renderer| Ok(renderer.session.film()?.with_label(renderer.label())))
    }

    /// Film of radiance as it is now, with all that a checkpoint takes but its notes. Whoever `takes` it asks the device for
    /// it no more.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub(crate) fn gather(&mut self, takes: bool) -> Result<Gathered, DeviceError> {
        self.showing(Feature::Radiance, |renderer| {
            let session = &mut renderer.session;
            Ok(Gathered {
                film: if takes { session.take_film()? } else { session.film()? },
                label: renderer.late_label(),
                notes: vec![],
                state: renderer.sampling_state(),
                progress: renderer.progress(),
            })
        })
    }

    /// Does something to the film of `feature`, and shows the one before again.
    fn showing<T>(
        &mut self,
        feature: Feature,
        what: impl FnOnce(&mut Self) -> Result<T, DeviceError>,
    ) -> Result<T, DeviceError> {
        let shown = self.feature();
        self.show(feature)?;
        let done = what(self);
        self.show(shown)?;
        done
    }

    /// Makes passes add no more than `samples` samples, at least one, to each pixel.
    pub(crate) fn set_longest_pass(&mut self, samples: u32) {
        self.longest_pass = samples.max(1);
    }

    /// Makes the next portion as small as can be: the last was too much for the device.
    pub(crate) fn begin_small(&mut self) {
        self.courses.shown_mut().last = 0.0;
    }

    fn label(&self) -> Label {
        self.late_label().make()
    }

    /// Label of the film of radiance, which has to be shown, as it is now.
    pub(crate) fn late_label(&self) -> LateLabel {
        let Course { pass, row, .. } = self.courses.shown();
        self.late_label_at(pass, *row)
    }

    /// Label of the film of radiance when the pass `pass` has come to `row`.
    fn late_label_at(&self, pass: &Range<u32>, row: u32) -> LateLabel {
        let whole = Portion { samples: self.samples.start..pass.start, rows: 0..self.height };
        let unfinished = Portion { samples: pass.clone(), rows: 0..row };
        let noise = self.adaptive.as_ref().map(|adaptive| adaptive.noise);
        let settings = settings(self.identity.settings(), noise);
        LateLabel::new(self.identity.clone(), settings, vec![whole, unfinished])
    }
}

/// Most rays of a path, each with a shadow ray.
fn longest_path(scene: &DeviceScene) -> f64 {
    2.0 * f64::from(scene.work.max_depth)
}

impl Course {
    /// Rate that is likely to last: the last portion may have been of the sky alone, so that the average counts too.
    fn lasting_rate(&self) -> f64 {
        let seconds = self.sampling.as_secs_f64();
        if seconds > 0.0 { self.rate.min(self.total as f64 / seconds) } else { self.rate }
    }

    fn new(height: u32, first: u32, rate: f64, last: f64) -> Self {
        Self {
            pass: first..first,
            row: height,
            rate,
            last,
            slowest: f64::INFINITY,
            slowest_before: f64::INFINITY,
            sampling: Duration::ZERO,
            total: 0,
        }
    }
}
