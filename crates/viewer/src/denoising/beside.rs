//! Pictures that are denoised while frames go on, on a thread of their own.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use raggio_denoise::{DenoiseError, Denoiser, Gpu, Guides, Noisy};
use raggio_render::{Features, Image};

use super::is_worth_it;
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

/// Something that the thread has done.
enum Done {
    Opened,
    /// Picture of the film of this number.
    Picture(u32, Result<Image, DenoiseError>),
}

/// Something that the thread has done, and that matters.
pub enum Found {
    /// The denoiser has opened what it works on.
    Opened,
    /// There is a picture.
    Picture,
}

/// The thread, and what it needs to know of the tracer's film.
pub struct Beside {
    jobs: Sender<Job>,
    done: Receiver<Done>,
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
}

impl Beside {
    /// Starts the thread, which has `denoiser` open its device for `gpu` first.
    pub fn begin(denoiser: Arc<Denoiser>, gpu: Option<Gpu>, wake: Wake) -> Self {
        let (jobs, work) = channel::<Job>();
        let (tell, done) = channel();
        // The thread ends when either side of it does.
        std::thread::spawn(move || {
            gpu.iter().for_each(|gpu| denoiser.prefer(gpu));
            let mut is_heard = tell.send(Done::Opened).is_ok();
            wake();
            let mut guides = None;
            for Job { film, image, first_surfaces } in work {
                let outcome = denoise(&denoiser, image, first_surfaces, &mut guides);
                is_heard &= tell.send(Done::Picture(film, outcome)).is_ok();
                if !is_heard {
                    return;
                }
                wake();
            }
        });
        let features = Features::default();
        Self { jobs, done, waiting: false, film: 0, samples: 0, features, guided: false, picture: None }
    }

    /// Spends a frame's `seconds` on guides if a picture that is due lacks them; false if none does.
    pub fn prepare(&mut self, tracer: &mut Tracer, seconds: f64) -> Result<bool, ViewError> {
        self.keep_up(tracer);
        if self.guided || !is_worth_it(tracer, self.samples) {
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

    /// Takes what the thread has done next, if that matters.
    pub fn take(&mut self) -> Result<Option<Found>, DenoiseError> {
        while let Ok(done) = self.done.try_recv() {
            match done {
                Done::Opened => return Ok(Some(Found::Opened)),
                Done::Picture(film, outcome) => {
                    self.waiting = false;
                    let picture = outcome?;
                    if film == self.film {
                        self.picture = Some(picture);
                        return Ok(Some(Found::Picture));
                    }
                }
            }
        }
        Ok(None)
    }

    /// Gives the thread the next picture that is due.
    pub fn follow(&mut self, tracer: &mut Tracer) -> Result<(), ViewError> {
        self.keep_up(tracer);
        if self.guided && !self.waiting && is_worth_it(tracer, self.samples) {
            let (film, samples) = tracer.radiance()?;
            let first = self.samples == 0;
            let features = std::mem::take(&mut self.features);
            let surfaces = || FirstSurfaces { albedo: features.guide_albedos(), normal: features.guide_normals() };
            let job = Job { film: self.film, image: film.mean(), first_surfaces: first.then(surfaces) };
            self.samples = samples;
            // A thread that is gone has left its reason among what is done.
            self.waiting = self.jobs.send(job).is_ok();
        }
        Ok(())
    }

    /// Whether frames are needed. While the thread works, they are not: `wake` asks for one.
    pub fn is_busy(&self, tracer: &Tracer) -> bool {
        !self.waiting && is_worth_it(tracer, self.samples)
    }

    /// Whether the thread works, or is to work.
    pub fn is_awaited(&self, tracer: &Tracer) -> bool {
        self.waiting || is_worth_it(tracer, self.samples)
    }

    /// The picture without its noise, if there is one of the tracer's film.
    pub fn picture(&self) -> Option<&Image> {
        self.picture.as_ref()
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
