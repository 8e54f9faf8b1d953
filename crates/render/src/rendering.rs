//! A render from its scene to its picture: what all front ends without a window share.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use raggio_kernels::MAX_NESTED_MEDIA;
use raggio_scene::Scene;

use crate::devices::device::{Device, DeviceError};
use crate::devices::machine::{TooLarge, check_films};
use crate::pictures::aov::Features;
use crate::pictures::film::Film;
use crate::pictures::image_file::Extras;
use crate::pictures::metadata::Metadata;
use crate::pictures::picture::{Guides, Picture};
use crate::renderer::{Progress, Renderer};
use crate::request::{Observer, RenderRequest};
use crate::translation::device_scene::DeviceScene;
use crate::translation::error::TranslationError;

/// Most samples a pixel of layers and guides: their noise is that of edges alone.
const MOST_FEATURE_SAMPLES: u64 = 1024;
/// Seconds of the shortest portion before a time limit: what is shorter costs more than it brings.
const SHORTEST_PORTION: f64 = 0.005;

/// A render whose scene is on its device.
pub struct Rendering {
    renderer: Renderer,
    scene: DeviceScene,
    request: RenderRequest,
    metadata: Metadata,
}

/// A render that has come to its end.
#[derive(Debug)]
pub struct Rendered {
    /// Picture of all samples that there are.
    pub picture: Picture,
    /// Progress at the end.
    pub progress: Progress,
    /// Whether every pixel has all samples that were asked for.
    pub finished: bool,
    /// Error of the device that ended the render early; layers and guides are missing then.
    pub failure: Option<DeviceError>,
    /// Number of shapes in the scene.
    pub shapes: usize,
    /// Number of triangles in the scene, those of each mesh once.
    pub triangles: usize,
}

/// Reasons why a render cannot begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A picture that this machine has no memory for.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// A scene that is too much for any device.
    #[error(transparent)]
    Translation(#[from] TranslationError),
    /// A device that failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

impl Rendering {
    /// Brings `scene` to `device`. The scene's own warnings are for whoever has read it.
    ///
    /// # Errors
    /// A [`RenderError`] when the picture or the scene is too large, or the device fails.
    pub fn begin(scene: &Scene, device: &dyn Device, request: RenderRequest) -> Result<Self, RenderError> {
        check_films(scene.render.width, scene.render.height, request.films_beside())?;
        let device_scene = DeviceScene::new(scene)?;
        let session = device.load(&device_scene)?;
        let mut renderer = Renderer::new(session, &device_scene, request.stop.samples(&scene.render));
        if let Some(noise) = request.stop.noise {
            renderer.set_noise(noise.into());
        }
        let metadata = Metadata::new(scene, &request.name);
        Ok(Self { renderer, scene: device_scene, request, metadata })
    }

    /// Numbers of the samples that each pixel has at most.
    pub fn samples(&self) -> Range<u32> {
        self.renderer.samples()
    }

    /// Makes ready what sampling needs. [`Rendering::run`] does so too, but whoever calls this first can tell the user why
    /// it takes a while: drivers compile kernels.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn prepare(&mut self) -> Result<(), DeviceError> {
        self.renderer.session().prepare()
    }

    /// Changes how many samples each pixel is to have, for [`Rendering::sample`] to go on.
    pub fn set_target(&mut self, samples: u32) {
        self.renderer.set_target(samples);
    }

    /// Begins anew with another scene; what both have in common stays on the device.
    ///
    /// # Errors
    /// The errors of [`Rendering::begin`]; only another change of the scene can follow them.
    pub fn change(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.check_memory(scene)?;
        self.scene.update(scene)?;
        self.restart(scene)
    }

    /// Begins anew with another camera, size or other settings; `scene` differs from that before in nothing else.
    ///
    /// # Errors
    /// The errors of [`Rendering::begin`].
    pub fn look(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.check_memory(scene)?;
        self.scene.set_view(scene)?;
        self.restart(scene)
    }

    fn check_memory(&self, scene: &Scene) -> Result<(), TooLarge> {
        check_films(scene.render.width, scene.render.height, self.request.films_beside())
    }

    fn restart(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.renderer.restart(&self.scene)?;
        self.metadata = Metadata::new(scene, &self.request.name);
        Ok(())
    }

    /// Flag that ends sampling at once, when it is set: also while the device is at work.
    pub fn stop_flag(&self) -> Arc<AtomicBool> {
        self.renderer.stop_flag()
    }

    /// Takes samples until there are enough, `observer` breaks off, or the device fails; then come layers and guides.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails and the film is lost with it.
    pub fn run(mut self, observer: &mut dyn Observer) -> Result<Rendered, DeviceError> {
        let failure = self.sample(observer).err();
        self.develop(observer, failure)
    }

    /// Makes the picture of the samples that there are, with layers and guides unless the device has met a `failure`. The
    /// rendering stays as it is, and more samples may follow.
    ///
    /// # Errors
    /// `failure`, or another [`DeviceError`], when the film is lost with the device.
    pub fn develop(
        &mut self,
        observer: &mut dyn Observer,
        mut failure: Option<DeviceError>,
    ) -> Result<Rendered, DeviceError> {
        let progress = self.renderer.progress();
        // A lost device has usually lost the film with it: then its first failure is what to report.
        let film = if self.request.label { self.renderer.labelled_film() } else { self.renderer.film() };
        let film = match (film, failure.take()) {
            (Ok(film), first) => {
                failure = first;
                film
            }
            (Err(_), Some(first)) => return Err(first),
            (Err(error), None) => return Err(error),
        };
        if film.rejected() > 0 {
            observer.warn(&format!(
                "{} samples had no finite value, or more than {MAX_NESTED_MEDIA} dielectrics overlapped there; they were left out",
                film.rejected(),
            ));
        }
        let mut features = None;
        if failure.is_none() {
            match self.features(observer, &film) {
                Ok(found) => features = Some(found),
                Err(error) => failure = Some(error),
            }
        }
        let finished = self.renderer.finished();
        let (shapes, triangles) = (self.scene.shapes(), self.scene.triangles());
        Ok(Rendered { picture: self.picture(film, features), progress, finished, failure, shapes, triangles })
    }

    /// Takes samples until there are enough, or `observer` breaks off.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn sample(&mut self, observer: &mut dyn Observer) -> Result<(), DeviceError> {
        let start = Instant::now();
        let limit = self.request.stop.time_limit.map_or(f64::INFINITY, f64::from);
        while !self.renderer.finished() {
            let left = limit - start.elapsed().as_secs_f64();
            if left <= 0.0 {
                break;
            }
            let mut progress = self.renderer.advance_for(left.max(SHORTEST_PORTION))?;
            progress.fraction = progress.fraction.max(start.elapsed().as_secs_f64() / limit).min(1.0);
            if observer.progress(&progress).is_break() || self.stop_flag().load(Ordering::Relaxed) {
                break;
            }
        }
        // What follows is not to be stopped by who has stopped this.
        self.stop_flag().store(false, Ordering::Relaxed);
        Ok(())
    }

    /// Renders what the layers and the denoiser need to know of first surfaces.
    fn features(&mut self, observer: &mut dyn Observer, film: &Film) -> Result<Features, DeviceError> {
        let wanted = self.request.features();
        // The mean number, where parts of the picture have more than others; an early end ends these films early too.
        let samples = (film.samples() / film.pixels().len() as u64).clamp(1, MOST_FEATURE_SAMPLES) as u32;
        let progress = self.renderer.progress();
        Features::render(&mut self.renderer, &wanted, samples, || observer.progress(&progress))
    }

    fn picture(&self, film: Film, features: Option<Features>) -> Picture {
        let mut extras = Extras { channels: vec![], metadata: Some(self.metadata.clone()) };
        if let Some(metadata) = &mut extras.metadata {
            metadata.samples = film.pixels().iter().map(|pixel| pixel.samples).max().unwrap_or(0);
        }
        let mut guides = None;
        if let Some(features) = features {
            let layers = self.request.layers.iter();
            extras.channels = layers.flat_map(|aov| aov.channels(&film, &features, &self.scene)).collect();
            guides = self
                .request
                .denoise
                .then(|| Guides { albedos: features.guide_albedos(), normals: features.guide_normals() });
        }
        Picture { film, extras, guides }
    }
}
