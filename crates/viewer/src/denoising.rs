//! The picture without its noise, computed while frames go on.

use std::sync::mpsc::{Receiver, Sender, channel};

use raggio_denoise::{DenoiseError, Denoiser, Noisy};
use raggio_render::{Display, Image, Pixels};

use crate::error::ViewError;
use crate::tracer::Tracer;
use crate::viewer::Wake;

/// A picture, and the film that it is from.
type Job<T> = (u32, T);

/// A picture without noise, compared with what is on the screen.
pub enum Denoised {
    /// It is there already.
    Unchanged,
    /// It is another: pixels and size.
    Changed(Pixels, [u32; 2]),
}

/// A thread that denoises what the tracer has, at each doubling of its samples and when it is finished.
pub struct Denoising {
    jobs: Sender<Job<Image>>,
    results: Receiver<Job<Result<Image, DenoiseError>>>,
    waiting: bool,
    /// The tracer's film, by [`Tracer::generation`].
    film: u32,
    /// Samples of the last picture of that film that was handed over.
    samples: u32,
    picture: Option<Image>,
    shown: Option<Display>,
}

impl Denoising {
    /// Finds the library and starts the thread; `wake` is called when there is a picture.
    pub fn begin(wake: Wake) -> Result<Self, DenoiseError> {
        let denoiser = Denoiser::open()?;
        let (jobs, work) = channel::<Job<Image>>();
        let (done, results) = channel();
        // It ends when either side of it does.
        std::thread::spawn(move || {
            for (film, image) in work {
                let (width, height) = (image.width as usize, image.height as usize);
                let noisy = Noisy { width, height, color: &image.pixels, guides: None };
                let outcome = denoiser.denoise(noisy).map(|pixels| Image { pixels, ..image });
                if done.send((film, outcome)).is_err() {
                    return;
                }
                wake();
            }
        });
        Ok(Self { jobs, results, waiting: false, film: 0, samples: 0, picture: None, shown: None })
    }

    /// Takes what the thread has finished, and gives it what is new.
    pub fn follow(&mut self, tracer: &mut Tracer) -> Result<(), ViewError> {
        if self.film != tracer.generation() {
            self.film = tracer.generation();
            self.samples = 0;
            self.picture = None;
        }
        while let Ok((film, outcome)) = self.results.try_recv() {
            self.waiting = false;
            let picture = outcome?;
            if film == self.film {
                self.picture = Some(picture);
                self.shown = None;
            }
        }
        if !self.waiting && self.is_due(tracer) {
            let (film, samples) = tracer.radiance()?;
            self.samples = samples;
            // A thread that is gone has left its reason among the results.
            self.waiting = self.jobs.send((self.film, film.mean())).is_ok();
        }
        Ok(())
    }

    /// Something is going on, or will as soon as there are frames.
    pub fn is_busy(&self, tracer: &Tracer) -> bool {
        self.waiting || self.is_due(tracer)
    }

    fn is_due(&self, tracer: &Tracer) -> bool {
        let samples = tracer.progress().samples;
        let more = samples >= 2 * self.samples || tracer.finished() && samples > self.samples;
        tracer.is_whole() && samples > 0 && more
    }

    /// The picture, if there is one.
    pub fn picture(&mut self, display: Display) -> Option<Denoised> {
        let image = self.picture.as_ref()?;
        if self.shown == Some(display) {
            return Some(Denoised::Unchanged);
        }
        self.shown = Some(display);
        Some(Denoised::Changed(raggio_render::show_image(image, display), [image.width, image.height]))
    }
}
