//! A render from its scene to its picture: what all front ends without a window share.

use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use raggio_kernels::MAX_NESTED_MEDIA;
use raggio_scene::Scene;

use crate::checkpoint::{Checkpoint, CheckpointError, Checkpoints, Every, Keeper, SamplingState};
use crate::devices::device::{Device, DeviceError};
use crate::devices::machine::{TooLarge, check_films};
use crate::pictures::aov::Features;
use crate::pictures::film::{Film, Portion};
use crate::pictures::image_file::Extras;
use crate::pictures::metadata::Metadata;
use crate::pictures::output_file::write_free;
use crate::pictures::picture::{Guides, Picture};
use crate::renderer::{LateLabel, Progress, Renderer};
use crate::request::{Observer, Phase, RenderRequest};
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
    keeper: Option<Keeper>,
    resumed: Option<PathBuf>,
    /// Seconds that were spent before a checkpoint was written, and until now.
    spent: f64,
    /// Whether sampling has come to its own end.
    is_done: bool,
    /// Warnings for the observer, who is not there yet.
    warnings: Vec<String>,
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
    /// Path of the checkpoint of this very picture, if there is one: elsewhere than was asked for if that place does not
    /// take it.
    pub checkpoint: Option<PathBuf>,
    /// Number of shapes in the scene.
    pub shapes: usize,
    /// Number of triangles in the scene, those of each mesh once.
    pub triangles: usize,
    keeper: Option<Keeper>,
    /// Label and state of the film, for who needs them after all.
    unsaved: Option<(LateLabel, SamplingState)>,
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
    /// A checkpoint of something else, or a place where none can be.
    #[error(transparent)]
    Checkpoint(CheckpointError),
    /// A device that failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

impl From<CheckpointError> for RenderError {
    fn from(error: CheckpointError) -> Self {
        match error {
            CheckpointError::Device(error) => error.into(),
            error => Self::Checkpoint(error),
        }
    }
}

impl Rendering {
    /// Brings `scene` to `device`, and goes on from a checkpoint if that is asked for and there is one. The scene's own
    /// warnings are for whoever has read it.
    ///
    /// # Errors
    /// A [`RenderError`] when the picture or the scene is too large, the checkpoint is of something else, or the device
    /// fails.
    pub fn begin(scene: &Scene, device: &dyn Device, request: RenderRequest) -> Result<Self, RenderError> {
        check_films(scene.render.width, scene.render.height, request.films_beside(scene.render.alpha))?;
        let device_scene = DeviceScene::new(scene)?;
        Self::begin_translated(scene, device_scene, device, request)
    }

    /// Begins as [`Rendering::begin`] does, with what `scene` has been translated to.
    ///
    /// # Errors
    /// The errors of [`Rendering::begin`].
    pub fn begin_translated(
        scene: &Scene,
        device_scene: DeviceScene,
        device: &dyn Device,
        request: RenderRequest,
    ) -> Result<Self, RenderError> {
        check_films(scene.render.width, scene.render.height, request.films_beside(scene.render.alpha))?;
        let session = device.load(&device_scene)?;
        let mut renderer = Renderer::new(session, &device_scene, request.stop.samples(&scene.render));
        if let Some(noise) = request.stop.noise {
            renderer.set_noise(noise.into());
        }
        let metadata = Metadata::new(scene, &request.name);
        let mut rendering = Self {
            renderer,
            scene: device_scene,
            request,
            metadata,
            keeper: None,
            resumed: None,
            spent: 0.0,
            is_done: false,
            warnings: vec![],
        };
        rendering.keep_checkpoints()?;
        Ok(rendering)
    }

    /// Goes on with the next frame of a sequence, which has been translated to `device_scene` and has checkpoints of its own.
    ///
    /// # Errors
    /// The errors of [`Rendering::begin`].
    pub fn next_frame(
        &mut self,
        scene: &Scene,
        device_scene: DeviceScene,
        checkpoints: Option<Checkpoints>,
    ) -> Result<(), RenderError> {
        self.check_memory(scene)?;
        self.scene = device_scene;
        self.restart(scene)?;
        self.request.checkpoints = checkpoints;
        self.keep_checkpoints()
    }

    /// Keeps the checkpoints that are asked for, and goes on from one if there is one and that is asked for too.
    fn keep_checkpoints(&mut self) -> Result<(), RenderError> {
        (self.keeper, self.resumed) = (None, None);
        let Some(wanted) = &self.request.checkpoints else { return Ok(()) };
        let mut keeper = Keeper::new(wanted)?;
        if let Every::Samples(samples) = wanted.every {
            self.renderer.set_longest_pass(samples);
        }
        let found = if wanted.resume { keeper.find(&mut |warning| self.warnings.push(warning))? } else { None };
        if let Some((path, checkpoint)) = found {
            self.renderer.resume(&checkpoint, &path)?;
            (self.resumed, self.spent) = (Some(path), checkpoint.state.spent);
        }
        self.keeper = Some(keeper);
        Ok(())
    }

    /// Path of the checkpoint that the render goes on from, if there is one.
    pub fn resumed(&self) -> Option<&Path> {
        self.resumed.as_deref()
    }

    /// Progress so far: what the checkpoint has.
    pub fn progress(&self) -> Progress {
        self.renderer.progress()
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

    /// Begins anew with other samples of the same picture.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn restart_with(&mut self, samples: Range<u32>) -> Result<(), DeviceError> {
        self.renderer.restart_with(samples, &self.scene)?;
        self.spent = 0.0;
        Ok(())
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
        check_films(scene.render.width, scene.render.height, self.request.films_beside(scene.render.alpha))
    }

    fn restart(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.renderer.restart(&self.scene)?;
        self.spent = 0.0;
        self.metadata = Metadata::new(scene, &self.request.name);
        Ok(())
    }

    /// Flag that ends sampling at once, when it is set: also while the device is at work.
    pub fn stop_flag(&self) -> Arc<AtomicBool> {
        self.renderer.stop_flag()
    }

    /// Takes samples until there are enough, `observer` breaks off, or the device fails; then come layers and guides. What
    /// there is after an early end is in a checkpoint, if there is to be one.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails and the film is lost with it, but for what a checkpoint has.
    pub fn run(mut self, observer: &mut dyn Observer) -> Result<Rendered, DeviceError> {
        let failure = self.sample(observer).err();
        self.develop(observer, failure)
    }

    /// Makes the picture of the samples that there are, with layers and guides unless the device has met a `failure`. The
    /// rendering stays as it is, and more samples may follow; its checkpoints go with the picture.
    ///
    /// # Errors
    /// `failure`, or another [`DeviceError`], when the film is lost with the device, but for what a checkpoint has.
    pub fn develop(
        &mut self,
        observer: &mut dyn Observer,
        mut failure: Option<DeviceError>,
    ) -> Result<Rendered, DeviceError> {
        let progress = self.renderer.progress();
        let mut finished = self.renderer.finished();
        let (film, unsaved, checkpoint) = match self.end(&progress, failure.is_some(), observer) {
            Ok((film, checkpoint)) => (film, Some((self.renderer.late_label(), self.sampling_state())), checkpoint),
            // A lost device has usually lost the film with it: then its first failure is what to report, and the picture
            // is that of the last checkpoint.
            Err(error) => {
                let error = failure.take().unwrap_or(error);
                let Some(keeper) = &self.keeper else { return Err(error) };
                let Some(checkpoint) = keeper.newest() else { return Err(error) };
                failure = Some(error);
                finished = false;
                (checkpoint.film, None, Some(keeper.path().to_owned()))
            }
        };
        if film.rejected() > 0 {
            observer.warn(&format!(
                "{} samples had no finite value, or more than {MAX_NESTED_MEDIA} dielectrics overlapped there; they were left out",
                film.rejected(),
            ));
        }
        let keeper = self.keeper.take();
        let picture = self.finish(film, &progress, &mut failure, observer);
        let (shapes, triangles) = (self.scene.shapes(), self.scene.triangles());
        Ok(Rendered { picture, progress, finished, failure, checkpoint, shapes, triangles, keeper, unsaved })
    }

    /// Makes the picture of a film that others have sampled in `seconds` and that was found at `path`, with layers and guides
    /// as [`Rendering::develop`] does.
    ///
    /// # Errors
    /// A [`CheckpointError`] when the film is of another picture.
    pub fn develop_film(
        &mut self,
        film: Film,
        path: &Path,
        seconds: f64,
        observer: &mut dyn Observer,
    ) -> Result<Rendered, RenderError> {
        self.renderer.check_film(&film, path)?;
        let whole = Portion { samples: self.samples(), rows: 0..film.height() };
        let finished = film.label().is_some_and(|label| label.portions() == [whole]);
        let samples = film.sample_range().0;
        let progress = Progress {
            samples,
            total_samples: film.samples() + film.rejected(),
            fraction: f64::from(samples) / f64::from(self.renderer.target()),
            noise: None,
            seconds,
        };
        let mut failure = None;
        let picture = self.finish(film, &progress, &mut failure, observer);
        let (shapes, triangles) = (self.scene.shapes(), self.scene.triangles());
        let checkpoint = Some(path.to_owned());
        Ok(Rendered {
            picture,
            progress,
            finished,
            failure,
            checkpoint,
            shapes,
            triangles,
            keeper: None,
            unsaved: None,
        })
    }

    /// Adds to a film what belongs to its picture, unless the device has met a `failure` or meets one now.
    fn finish(
        &mut self,
        film: Film,
        progress: &Progress,
        failure: &mut Option<DeviceError>,
        observer: &mut dyn Observer,
    ) -> Picture {
        let mut features = None;
        let mut coverage = None;
        if failure.is_none() {
            match self.features(observer, &film, progress) {
                Ok(found) => (features, coverage) = (Some(found.0), found.1),
                Err(error) => *failure = Some(error),
            }
        }
        let film = if coverage.is_some() { film.with_coverage(coverage) } else { film };
        self.picture(film, features)
    }

    /// Takes samples until there are enough, in number or by the clock, or `observer` breaks off.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn sample(&mut self, observer: &mut dyn Observer) -> Result<(), DeviceError> {
        std::mem::take(&mut self.warnings).iter().for_each(|warning| observer.warn(warning));
        observer.begin(Phase::Sampling);
        self.is_done = false;
        let start = Instant::now();
        // Whoever goes on has spent some of the time already.
        let before = self.spent;
        let limit = self.request.stop.time_limit.map_or(f64::INFINITY, f64::from);
        let mut is_second_try = false;
        let mut is_done = true;
        if let Some(keeper) = &mut self.keeper {
            keeper.begin(self.renderer.progress().samples);
        }
        while !self.renderer.finished() {
            self.spent = before + start.elapsed().as_secs_f64();
            if self.spent >= limit {
                break;
            }
            let mut progress = match self.renderer.advance_for((limit - self.spent).max(SHORTEST_PORTION)) {
                // Less of it may fit.
                Err(error) if error.is_out_of_memory() && !is_second_try => {
                    is_second_try = true;
                    self.renderer.begin_small();
                    continue;
                }
                advanced => advanced?,
            };
            is_second_try = false;
            self.spent = before + start.elapsed().as_secs_f64();
            progress.fraction = progress.fraction.max(self.spent / limit).min(1.0);
            let proceeds = observer.progress(&progress).is_continue() && !self.stop_flag().load(Ordering::Relaxed);
            if !proceeds {
                is_done = self.renderer.finished();
                break;
            }
            if !self.renderer.finished() && self.keeper.as_ref().is_some_and(|keeper| keeper.is_due(&progress)) {
                let checkpoint = self.checkpoint()?;
                self.save(&checkpoint, &progress, observer);
            }
        }
        // What follows is not to be stopped by who has stopped this.
        self.stop_flag().store(false, Ordering::Relaxed);
        self.is_done = is_done;
        Ok(())
    }

    /// Reads the film at the end of sampling, and keeps it in a checkpoint where there is to be one, until its files are
    /// written.
    fn end(
        &mut self,
        progress: &Progress,
        has_failed: bool,
        observer: &mut dyn Observer,
    ) -> Result<(Film, Option<PathBuf>), DeviceError> {
        let is_wanted = |keeper: &Keeper| has_failed || keeper.owns() || keeper.is_worth_it(progress);
        if !self.keeper.as_ref().is_some_and(is_wanted) && !self.request.label {
            return Ok((self.renderer.film()?, None));
        }
        let checkpoint = self.checkpoint()?;
        let mut path = None;
        if self.keeper.as_ref().is_some_and(is_wanted) {
            path = self.save(&checkpoint, progress, observer);
            // Who is done writes files next, and saves the film elsewhere only if these cannot be written.
            if let (None, Some(keeper)) = (&path, self.keeper.as_ref().filter(|_| !self.is_done)) {
                path = keeper.save_elsewhere(&checkpoint, &refuges());
            }
        }
        Ok((checkpoint.film, path))
    }

    fn checkpoint(&mut self) -> Result<Checkpoint, DeviceError> {
        let film = self.renderer.labelled_film()?.with_notes(self.metadata.notes());
        Ok(Checkpoint { film, state: self.sampling_state() })
    }

    /// State of the sampling of radiance, whose film is shown but for while layers are rendered.
    fn sampling_state(&self) -> SamplingState {
        SamplingState { spent: self.spent, ..self.renderer.sampling_state() }
    }

    /// Writes a checkpoint, and returns its path if it could be written.
    fn save(&mut self, checkpoint: &Checkpoint, progress: &Progress, observer: &mut dyn Observer) -> Option<PathBuf> {
        let keeper = self.keeper.as_mut()?;
        let saved = keeper.save(checkpoint, progress.samples, &mut |warning| observer.warn(warning));
        let path = saved.then(|| keeper.path().to_owned())?;
        observer.saved(&path);
        Some(path)
    }

    /// Renders what the layers and the denoiser need to know of first surfaces, and their coverage if the picture has an
    /// alpha channel and the film does not have it yet.
    fn features(
        &mut self,
        observer: &mut dyn Observer,
        film: &Film,
        progress: &Progress,
    ) -> Result<(Features, Option<Film>), DeviceError> {
        let wanted = self.request.features();
        let has_alpha = self.scene.settings.alpha && film.coverage().is_none();
        if has_alpha || !wanted.is_empty() {
            observer.begin(Phase::Layers);
        }
        // The mean number, where parts of the picture have more than others; an early end ends these films early too.
        let samples = (film.samples() / film.pixels().len() as u64).clamp(1, MOST_FEATURE_SAMPLES) as u32;
        let features = Features::render(&mut self.renderer, &wanted, samples, || observer.progress(progress))?;
        let coverage = has_alpha.then(|| self.renderer.coverage(film, || observer.progress(progress)));
        Ok((features, coverage.transpose()?))
    }

    fn picture(&self, film: Film, features: Option<Features>) -> Picture {
        let mut extras = Extras { channels: vec![], metadata: Some(self.metadata.clone()) };
        if let Some(metadata) = &mut extras.metadata {
            metadata.samples = film.most_samples();
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

impl Rendered {
    /// Removes the checkpoints of this render: its files are written, and it needs none any more.
    ///
    /// # Errors
    /// The system's error when one cannot be removed.
    pub fn remove_checkpoints(&self) -> io::Result<()> {
        self.keeper.as_ref().map_or(Ok(()), Keeper::remove)
    }

    /// Saves the film where its files could not be written, if no checkpoint holds it: as `NAME.film` in the current folder
    /// or in that of temporary files. A render goes on from it as from a checkpoint. Returns its path.
    ///
    /// # Errors
    /// The system's error when neither folder takes it.
    pub fn rescue(&self, name: &str) -> io::Result<PathBuf> {
        if let Some(path) = &self.checkpoint {
            return Ok(path.clone());
        }
        let (label, state) = self.unsaved.as_ref().ok_or(io::ErrorKind::NotFound)?;
        let notes = self.picture.extras.metadata.as_ref().map(Metadata::notes).unwrap_or_default();
        let (label, state) = (label.make().with_notes(notes), state.note());
        let mut outcome = Err(io::ErrorKind::NotFound.into());
        for folder in refuges() {
            let name = Path::new(name).with_extension("film");
            let state = std::slice::from_ref(&state);
            outcome = write_free(&folder, &name, &|to| self.picture.film.write_as(&label, to, state));
            if outcome.is_ok() {
                break;
            }
        }
        outcome
    }
}

/// Folders for what cannot be written to its place.
fn refuges() -> Vec<PathBuf> {
    [PathBuf::from("."), std::env::temp_dir()].into_iter().filter_map(|folder| folder.canonicalize().ok()).collect()
}
