//! The picture without its noise, computed while frames go on.

use std::sync::mpsc::{Receiver, Sender, channel};

use raggio_denoise::{DenoiseError, Denoiser, Guides, Noisy};
use raggio_render::{Display, Features, Image, Pixels};

use crate::error::ViewError;
use crate::tracer::Tracer;
use crate::wake::Wake;

/// Samples that each pixel of the guides takes: it is edges alone that are noisy.
const GUIDE_SAMPLES: u32 = 16;

/// A picture to denoise.
struct Job {
    /// Number of the film, that of [`Tracer::generation`].
    film: u32,
    image: Image,
    /// Guides, sent with the first picture of a film alone.
    first_surfaces: Option<FirstSurfaces>,
}

struct FirstSurfaces {
    albedo: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
}

/// A picture without noise, compared with what is on the screen.
pub enum Denoised {
    /// The picture that is on the screen already.
    Unchanged,
    /// Another picture: its pixels, and its width and height.
    Changed(Pixels, [u32; 2]),
}

/// A thread that denoises what the tracer has, at each doubling of its samples and when it is finished.
pub struct Denoising {
    jobs: Sender<Job>,
    /// Denoised pictures, each with the number of its film.
    results: Receiver<(u32, Result<Image, DenoiseError>)>,
    waiting: bool,
    /// Number of the tracer's film, that of [`Tracer::generation`].
    film: u32,
    /// Samples of the last picture of that film that was handed over.
    samples: u32,
    /// Guides, as far as they have been rendered.
    features: Features,
    /// Whether all guides have been rendered.
    guided: bool,
    picture: Option<Image>,
    shown: Option<Display>,
}

impl Denoising {
    /// Finds the library and starts the thread; `wake` is called when there is a picture.
    pub fn begin(wake: Wake) -> Result<Self, DenoiseError> {
        let denoiser = Denoiser::open()?;
        let (jobs, work) = channel::<Job>();
        let (done, results) = channel();
        // The thread ends when either side of it does.
        std::thread::spawn(move || {
            let mut guides = None;
            for Job { film, image, first_surfaces } in work {
                let outcome = denoise(&denoiser, image, first_surfaces, &mut guides);
                if done.send((film, outcome)).is_err() {
                    return;
                }
                wake();
            }
        });
        let features = Features::default();
        let (waiting, guided) = (false, false);
        Ok(Self { jobs, results, waiting, film: 0, samples: 0, features, guided, picture: None, shown: None })
    }

    /// Spends a frame's `seconds` on guides if a picture that is due lacks them; false if none does.
    pub fn prepare(&mut self, tracer: &mut Tracer, seconds: f64) -> Result<bool, ViewError> {
        self.keep_up(tracer);
        if self.guided || !self.is_due(tracer) {
            return Ok(false);
        }
        self.guided = tracer.gather(&mut self.features, &Features::GUIDES, GUIDE_SAMPLES, seconds)?;
        Ok(true)
    }

    /// Forgets all that belongs to another film.
    fn keep_up(&mut self, tracer: &Tracer) {
        if self.film != tracer.generation() {
            self.film = tracer.generation();
            self.samples = 0;
            self.features = Features::default();
            self.guided = false;
            self.picture = None;
        }
    }

    /// Takes the picture that the thread has finished, and gives it the next one that is due.
    pub fn follow(&mut self, tracer: &mut Tracer) -> Result<(), ViewError> {
        self.keep_up(tracer);
        while let Ok((film, outcome)) = self.results.try_recv() {
            self.waiting = false;
            let picture = outcome?;
            if film == self.film {
                self.picture = Some(picture);
                self.shown = None;
            }
        }
        if self.guided && !self.waiting && self.is_due(tracer) {
            let (film, samples) = tracer.radiance()?;
            let first = self.samples == 0;
            let features = std::mem::take(&mut self.features);
            let surfaces = || FirstSurfaces { albedo: features.guide_albedos(), normal: features.guide_normals() };
            let job = Job { film: self.film, image: film.mean(), first_surfaces: first.then(surfaces) };
            self.samples = samples;
            // A thread that is gone has left its reason among the results.
            self.waiting = self.jobs.send(job).is_ok();
        }
        Ok(())
    }

    /// Whether the denoiser needs frames. While the thread works, it does not: `wake` asks for one.
    pub fn is_busy(&self, tracer: &Tracer) -> bool {
        !self.waiting && self.is_due(tracer)
    }

    /// Whether a picture without noise is on its way, or will be: none is shown yet of all samples that there are.
    pub fn is_awaited(&self, tracer: &Tracer) -> bool {
        self.waiting || self.shown.is_none() || self.is_due(tracer)
    }

    fn is_due(&self, tracer: &Tracer) -> bool {
        let samples = tracer.progress().samples;
        let more = samples >= 2 * self.samples || tracer.finished() && samples > self.samples;
        tracer.shows_radiance() && tracer.is_whole() && samples > 0 && more
    }

    /// The denoised picture, if there is one.
    pub fn picture(&mut self, display: Display) -> Option<Denoised> {
        let image = self.picture.as_ref()?;
        if self.shown == Some(display) {
            return Some(Denoised::Unchanged);
        }
        self.shown = Some(display);
        Some(Denoised::Changed(raggio_render::show_image(image, display), [image.width, image.height]))
    }
}

/// Removes the noise of `image`; `guides` are those of its film, from `first_surfaces` if it is the first.
fn denoise(
    denoiser: &Denoiser,
    image: Image,
    first_surfaces: Option<FirstSurfaces>,
    guides: &mut Option<Guides>,
) -> Result<Image, DenoiseError> {
    let (width, height) = (image.width as usize, image.height as usize);
    if let Some(FirstSurfaces { albedo, normal }) = first_surfaces {
        *guides = Some(denoiser.guides([width, height], &albedo, &normal)?);
    }
    let noisy = Noisy { width, height, color: &image.pixels, guides: guides.as_ref() };
    Ok(Image { pixels: denoiser.denoise(noisy)?, ..image })
}
