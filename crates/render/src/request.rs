//! Requests of front ends, and reports to them meanwhile.

use std::ops::{ControlFlow, Range};
use std::path::Path;

use raggio_choice::choice;
use raggio_kernels::Feature;
use raggio_scene::{RenderSettings, Scene};

use crate::checkpoint::Checkpoints;
use crate::devices::machine::{TooLarge, check_films};
use crate::pictures::aov::{Aov, Features};
use crate::renderer::Progress;

/// Samples a pixel of a render that stops by its noise alone, in case it never does.
const MOST_ADAPTIVE_SAMPLES: u32 = 65536;
/// Samples a pixel of a render that stops by time alone.
pub const UNLIMITED_SAMPLES: u32 = i32::MAX as u32;

/// Request for a picture of a scene. The scene itself says size, depth, seed and filter.
#[derive(Clone, Debug, Default)]
pub struct RenderRequest {
    /// Name of the scene in the picture's metadata.
    pub name: String,
    /// Layers beside the picture.
    pub layers: Vec<Aov>,
    /// Whether the picture is to be [denoised](crate::Picture::denoised), which takes guides.
    pub denoise: bool,
    /// Whether the film is to have a [label](crate::Film::label), so that it can be kept in a file and merged; it takes
    /// a hash of the whole scene.
    pub label: bool,
    /// End of sampling.
    pub stop: Stop,
    /// Files from which the render goes on after whatever has ended it early; `None`: none are kept.
    pub checkpoints: Option<Checkpoints>,
}

impl RenderRequest {
    /// Checks that this machine has the memory for the picture of `scene`, with all that is asked for beside it.
    ///
    /// # Errors
    /// A [`TooLarge`] when it needs more than is available.
    pub fn check_memory(&self, scene: &Scene) -> Result<(), TooLarge> {
        check_films(scene.render.width, scene.render.height, self.films_beside(scene.render.alpha))
    }

    /// Features that layers and guides are made from, each once.
    pub(crate) fn features(&self) -> Vec<Feature> {
        let guides: &[_] = if self.denoise { &Features::GUIDES } else { &[] };
        let mut wanted = vec![];
        for feature in self.layers.iter().flat_map(|aov| aov.features()).chain(guides) {
            if !wanted.contains(feature) {
                wanted.push(*feature);
            }
        }
        wanted
    }

    /// Features whose films are sampled, each once; with `alpha`, coverage is one of them.
    pub(crate) fn films(&self, alpha: bool) -> Vec<Feature> {
        let mut films = vec![Feature::Radiance];
        films.extend(alpha.then_some(Feature::Coverage));
        films.extend(self.features());
        films
    }

    /// Number of films beside that of the picture whose memory layers, guides and, with `alpha`, coverage take.
    pub(crate) fn films_beside(&self, alpha: bool) -> u64 {
        // What a denoiser works in is about as large as two films.
        let denoiser = if self.denoise { 2 } else { 0 };
        self.features().len() as u64 + u64::from(alpha) + denoiser
    }
}

/// End of sampling: whichever of these limits comes first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stop {
    /// Numbers of the samples of each pixel. `None`: as many as the scene says, from 0 on; with a noise or a time limit
    /// that number does not count.
    pub samples: Option<Range<u32>>,
    /// Relative standard error below which a part of the picture takes no more samples: see
    /// [`Renderer::set_noise`](crate::Renderer::set_noise).
    pub noise: Option<f32>,
    /// Longest time of sampling, in seconds.
    pub time_limit: Option<f32>,
}

impl Stop {
    /// Numbers of the samples that each pixel has at most.
    pub fn samples(&self, settings: &RenderSettings) -> Range<u32> {
        self.samples.clone().unwrap_or(match self {
            Self { noise: Some(_), .. } => 0..MOST_ADAPTIVE_SAMPLES,
            Self { time_limit: Some(_), .. } => 0..UNLIMITED_SAMPLES,
            _ => 0..settings.samples,
        })
    }
}

choice! {
    /// Phase of a render.
    pub enum Phase: "phase" {
        /// The driver compiles the kernels that sampling takes.
        Compiling = "compiling",
        /// Rays are traced for the picture.
        Sampling = "sampling",
        /// Rays are traced for its layers, and for what guides the denoiser.
        Layers = "layers",
        /// The picture is denoised.
        Denoising = "denoising",
        /// Files are written.
        Writing = "writing",
    }
}

/// A front end that wants to hear how a render goes. A closure of the progress is one that hears no warnings.
pub trait Observer {
    /// Takes a warning, one sentence for the user.
    fn warn(&mut self, _warning: &str) {}

    /// Hears of a phase that begins.
    fn begin(&mut self, _phase: Phase) {}

    /// Hears a few times a second for how many `seconds` the render has waited for kernels.
    fn compiling(&mut self, _seconds: f64) {}

    /// Hears of a checkpoint that has been written.
    fn saved(&mut self, _checkpoint: &Path) {}

    /// Takes the progress after each portion of work. [`ControlFlow::Break`] ends the render early: what there is
    /// becomes the picture.
    fn progress(&mut self, progress: &Progress) -> ControlFlow<()>;
}

impl<F: FnMut(&Progress) -> ControlFlow<()>> Observer for F {
    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        self(progress)
    }
}
