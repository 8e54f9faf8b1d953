//! The picture without its noise: in the memory of the GPU that traces, where the denoiser works there, and else computed
//! beside the frames.

mod beside;

use std::sync::Arc;
use std::time::Instant;

use raggio_choice::choice;
use raggio_denoise::{Care, DenoiseError, Denoiser, Gpu};
use raggio_render::{Denoised as OnDevice, Display, Pixels};

use crate::error::ViewError;
use crate::tracer::Tracer;
use crate::wake::Wake;

use beside::{Beside, Found};

choice! {
    /// Whether pictures lose their noise while the camera moves.
    pub enum InMotion: "way in motion" {
        /// Where the denoiser is fast enough for the display's frames.
        Auto = "auto",
        /// In each frame, however long it takes.
        Always = "always",
        /// Only once the camera rests.
        Never = "never",
    }
}

/// Most seconds that the denoiser may take in each frame, where nobody has said that it may take longer.
const FAST: f64 = 0.012;

/// A picture without noise, compared with what is on the screen.
pub enum Denoised {
    /// The picture that is on the screen already.
    Unchanged,
    /// Another picture: its pixels, and its width and height.
    Changed(Pixels, [u32; 2]),
}

/// Denoiser of what the tracer has: on the tracer's GPU in each frame while the camera moves, and else at each doubling of its
/// samples and when it is finished.
pub struct Denoising {
    denoiser: Arc<Denoiser>,
    beside: Beside,
    /// Whether it is known what the denoiser works on: a GPU takes a while to open.
    is_open: bool,
    /// Whether nothing is gained by the tracer's GPU.
    is_elsewhere: bool,
    /// Sentence on why it is not the tracer's GPU that works, which nobody has heard yet.
    complaint: Option<String>,
    /// Film whose picture was last denoised on the GPU, the samples of each pixel that it had, 0 for one in motion, and of all
    /// pixels together.
    last: Option<(u32, u32, u64)>,
    shown: Option<Display>,
    pace: Pace,
}

/// Time that the GPU takes for a picture, smoothed, of one size.
#[derive(Default)]
struct Pace {
    size: [u32; 2],
    /// Number of pictures that have been made so quickly as they can be, the first of which takes longer.
    pictures: u32,
    seconds: f64,
}

impl Denoising {
    /// Finds the library; then a thread opens its device for `gpu`, the tracer's, and does what the GPU cannot do in its frames.
    /// `wake` is called when there is something new.
    pub fn begin(gpu: Option<Gpu>, wake: Wake) -> Result<Self, DenoiseError> {
        let denoiser = Arc::new(Denoiser::open()?);
        Ok(Self {
            beside: Beside::begin(denoiser.clone(), gpu, wake),
            denoiser,
            is_open: false,
            is_elsewhere: false,
            complaint: None,
            last: None,
            shown: None,
            pace: Pace::default(),
        })
    }

    /// Name of the denoiser and of what it works on, in words.
    pub fn describe(&self) -> String {
        if !self.is_open {
            return format!("{} begins", self.denoiser.name());
        }
        let milliseconds = 1000.0 * self.pace.seconds;
        let pace = if self.pace.pictures > 1 { format!(", {milliseconds:.1} ms") } else { String::new() };
        format!("{} on {}{pace}", self.denoiser.name(), self.denoiser.place())
    }

    /// Sentence on why it is not the tracer's GPU that works, once.
    pub fn complaint(&mut self) -> Option<String> {
        self.complaint.take()
    }

    /// Spends a frame's `seconds` on guides if a picture that is due lacks them; false if none does.
    pub fn prepare(&mut self, tracer: &mut Tracer, seconds: f64) -> Result<bool, ViewError> {
        if self.is_open && self.is_elsewhere { self.beside.prepare(tracer, seconds) } else { Ok(false) }
    }

    /// Whether frames in motion lose their noise, for which they have to be of full size.
    pub fn is_in_motion(&self, in_motion: InMotion) -> bool {
        let is_fast = self.pace.pictures < 2 || self.pace.seconds <= FAST;
        self.is_open && !self.is_elsewhere && (in_motion == InMotion::Always || in_motion == InMotion::Auto && is_fast)
    }

    /// Takes what the thread has finished, and gives it the next picture that is due.
    pub fn follow(&mut self, tracer: &mut Tracer) -> Result<(), ViewError> {
        while let Some(found) = self.beside.take()? {
            match found {
                Found::Opened => {
                    self.is_open = true;
                    self.is_elsewhere = !shares_memory(&self.denoiser);
                    self.complaint = self.denoiser.complaint();
                }
                Found::Picture => self.shown = None,
            }
        }
        if self.is_open && self.is_elsewhere { self.beside.follow(tracer) } else { Ok(()) }
    }

    /// Whether the denoiser needs frames. While the thread works, it does not: that asks for one.
    pub fn is_busy(&self, tracer: &Tracer) -> bool {
        match (self.is_open, self.is_elsewhere) {
            (false, _) => false,
            (_, true) => self.beside.is_busy(tracer),
            _ => self.is_due(tracer),
        }
    }

    /// Whether a picture without noise is on its way, or will be: none is shown yet of all samples that there are.
    pub fn is_awaited(&self, tracer: &Tracer) -> bool {
        let is_due = if self.is_elsewhere { self.beside.is_awaited(tracer) } else { self.is_due(tracer) };
        !self.is_open || self.shown.is_none() || is_due
    }

    /// Whether a picture at rest is worth to be denoised on the GPU.
    fn is_due(&self, tracer: &Tracer) -> bool {
        let before = self.last.filter(|(film, ..)| *film == tracer.generation()).map_or(0, |(_, samples, _)| samples);
        is_worth_it(tracer, before)
    }

    /// Forgets what is on the screen: it is something else now.
    pub fn forget_shown(&mut self) {
        self.shown = None;
    }

    /// The picture without its noise, if there is one.
    pub fn picture(
        &mut self,
        tracer: &mut Tracer,
        display: Display,
        in_motion: InMotion,
    ) -> Result<Option<Denoised>, ViewError> {
        if !self.is_open {
            return Ok(None);
        }
        if !self.is_elsewhere {
            let found = self.picture_on_device(tracer, display, in_motion)?;
            if !self.is_elsewhere {
                return Ok(found);
            }
        }
        let Some(image) = self.beside.picture() else { return Ok(None) };
        if self.shown == Some(display) {
            return Ok(Some(Denoised::Unchanged));
        }
        self.shown = Some(display);
        Ok(Some(Denoised::Changed(raggio_render::show_image(image, display), [image.width, image.height])))
    }

    fn picture_on_device(
        &mut self,
        tracer: &mut Tracer,
        display: Display,
        in_motion: InMotion,
    ) -> Result<Option<Denoised>, ViewError> {
        let (film, progress) = (tracer.generation(), tracer.progress());
        let is_of_this_film = self.last.is_some_and(|(last, ..)| last == film);
        let moves = !tracer.settled();
        if progress.samples == 0 || !tracer.has_full_size() || !tracer.shows_radiance() {
            return Ok(None);
        }
        if moves && !self.is_in_motion(in_motion) {
            return Ok(None);
        }
        // One that was made in motion is not what a picture at rest can be.
        let now = (film, if moves { 0 } else { progress.samples }, progress.total_samples);
        let is_due = if moves { self.last != Some(now) } else { self.is_due(tracer) };
        if !is_due && is_of_this_film && self.shown == Some(display) {
            return Ok(Some(Denoised::Unchanged));
        }
        if self.pace.size != tracer.film_size() {
            self.pace = Pace { size: tracer.film_size(), ..Pace::default() };
        }
        // The very first picture makes what those in motion take: a hand should not wait for that.
        if moves || self.pace.pictures == 0 {
            let start = Instant::now();
            let found = tracer.denoise(&self.denoiser, Care::Quick, display)?;
            self.take_time(start, &found);
            if moves || !matches!(found, OnDevice::Shown(_)) {
                return Ok(self.take(found, now, display, tracer));
            }
        }
        let found = tracer.denoise(&self.denoiser, Care::Thorough, display)?;
        Ok(self.take(found, now, display, tracer))
    }

    fn take_time(&mut self, start: Instant, found: &OnDevice) {
        if !matches!(found, OnDevice::Shown(_)) {
            return;
        }
        let seconds = start.elapsed().as_secs_f64();
        self.pace.pictures += 1;
        self.pace.seconds = match self.pace.pictures {
            // The first has made filters and images too.
            1 => 0.0,
            2 => seconds,
            _ => self.pace.seconds + 0.2 * (seconds - self.pace.seconds),
        };
    }

    fn take(&mut self, found: OnDevice, film: (u32, u32, u64), display: Display, tracer: &Tracer) -> Option<Denoised> {
        match found {
            OnDevice::Shown(pixels) => {
                (self.last, self.shown) = (Some(film), Some(display));
                Some(Denoised::Changed(pixels, tracer.film_size()))
            }
            OnDevice::NotYet => None,
            OnDevice::Elsewhere => {
                self.is_elsewhere = true;
                self.complaint = self.denoiser.complaint();
                None
            }
        }
    }
}

/// Whether a picture at rest has so many more samples than the `before` of the last one that was denoised that its noise is
/// another.
fn is_worth_it(tracer: &Tracer, before: u32) -> bool {
    let samples = tracer.progress().samples;
    let more = samples >= 2 * before || tracer.finished() && samples > before;
    tracer.shows_radiance() && tracer.is_whole() && samples > 0 && more
}

#[cfg(unix)]
fn shares_memory(denoiser: &Denoiser) -> bool {
    denoiser.shares_memory()
}

#[cfg(not(unix))]
fn shares_memory(_: &Denoiser) -> bool {
    false
}
