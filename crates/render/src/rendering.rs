//! A render from its scene to its picture: what all front ends without a window share.

mod failures;

use std::cell::Cell;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use raggio_kernels::MAX_NESTED_MEDIA;
use raggio_scene::Scene;

use crate::checkpoint::{CheckpointError, Checkpoints, Every, Gathered, Keeper, SamplingState};
use crate::devices::device::{Device, DeviceError};
use crate::devices::machine::TooLarge;
use crate::devices::tracer::Tracer;
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

use failures::Safety;

/// Most samples a pixel of layers and guides: their noise is that of edges alone.
const MOST_FEATURE_SAMPLES: u64 = 1024;
/// Seconds of the shortest portion before a time limit: what is shorter costs more than it brings.
const SHORTEST_PORTION: f64 = 0.005;
/// Time after which those who wait for kernels are told that they still do.
const PATIENCE: Duration = Duration::from_millis(250);

/// A render whose scene is on its device.
pub struct Rendering {
    renderer: Renderer,
    scene: DeviceScene,
    request: RenderRequest,
    metadata: Metadata,
    keeper: Option<Keeper>,
    safety: Safety,
    resumed: Option<PathBuf>,
    /// Seconds that were spent before a checkpoint was written, and until now.
    spent: f64,
    preparation: Preparation,
    /// Whether sampling has come to its own end.
    is_done: bool,
    /// Whether nobody asks the device for the film once more.
    is_last: bool,
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
    /// Time that went by before the first sample.
    pub preparation: Preparation,
    /// Time that went by after the last sample.
    pub development: Development,
    /// Who has found what rays met, [`Tracer::Software`] or [`Tracer::Hardware`]; `None` where devices that shared the picture
    /// differ.
    pub tracer: Option<Tracer>,
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

/// End of sampling.
struct End {
    gathered: Gathered,
    /// Path of its checkpoint.
    checkpoint: Option<PathBuf>,
    is_labelled: bool,
    /// Whether every pixel has all its samples.
    finished: bool,
}

/// Time that goes by before the first sample of a render, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Preparation {
    /// Time in which the scene was translated to what devices read; 0 where somebody has done so before.
    pub translate_seconds: f64,
    /// Time in which the scene went to the device.
    pub upload_seconds: f64,
    /// Time in which the driver compiled kernels since the device was opened: on several threads, and beside the rest.
    pub compile_seconds: f64,
    /// Time for which all else waited for kernels.
    pub compile_wait_seconds: f64,
}

/// Time that goes by between the last sample of a render and its picture, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Development {
    /// Time in which the film came from the device; 0 where it came from elsewhere.
    pub film_seconds: f64,
    /// Time in which layers, guides and coverage were sampled and made.
    pub layers_seconds: f64,
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
        request.check_memory(scene)?;
        let start = Instant::now();
        let device_scene = DeviceScene::new(scene)?;
        let translate_seconds = start.elapsed().as_secs_f64();
        let mut rendering = Self::load(scene, device_scene, device, request)?;
        rendering.preparation.translate_seconds = translate_seconds;
        Ok(rendering)
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
        request.check_memory(scene)?;
        Self::load(scene, device_scene, device, request)
    }

    /// Takes the seconds that translation took where it was done before, for [`Rendered::preparation`].
    pub fn note_translation(&mut self, seconds: f64) {
        self.preparation.translate_seconds = seconds;
    }

    fn load(
        scene: &Scene,
        device_scene: DeviceScene,
        device: &dyn Device,
        request: RenderRequest,
    ) -> Result<Self, RenderError> {
        device.compile_ahead(&device_scene, &request.films(scene.render.alpha));
        let start = Instant::now();
        let session = device.load(&device_scene)?;
        let upload_seconds = start.elapsed().as_secs_f64();
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
            safety: Safety::default(),
            resumed: None,
            spent: 0.0,
            preparation: Preparation { upload_seconds, ..Preparation::default() },
            is_done: false,
            is_last: false,
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
        let start = Instant::now();
        self.restart(scene)?;
        self.preparation = Preparation { upload_seconds: start.elapsed().as_secs_f64(), ..Preparation::default() };
        self.request.checkpoints = checkpoints;
        self.keep_checkpoints()
    }

    /// Keeps the checkpoints that are asked for, and goes on from one if there is one and that is asked for too.
    fn keep_checkpoints(&mut self) -> Result<(), RenderError> {
        (self.keeper, self.resumed) = (None, None);
        let Some(wanted) = &self.request.checkpoints else { return Ok(()) };
        let mut keeper = Keeper::new(wanted, &mut |warning| self.warnings.push(warning))?;
        if let Every::Samples(samples) = wanted.every {
            self.renderer.set_longest_pass(samples);
        }
        let found = if wanted.resume { keeper.find(&mut |warning| self.warnings.push(warning))? } else { None };
        if let Some((path, checkpoint)) = found {
            self.renderer.resume(&checkpoint, &path)?;
            (self.resumed, self.spent) = (Some(path), checkpoint.state.spent);
            // A device that is lost soon need not begin with the first sample.
            self.keep_safe(checkpoint);
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

    /// Makes ready what sampling needs, as [`Rendering::sample`] does first: drivers compile kernels, and `observer` hears of it
    /// where that is not over yet. The time counts for no limit.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn prepare(&mut self, observer: &mut dyn Observer) -> Result<(), DeviceError> {
        if self.renderer.finished() {
            return Ok(());
        }
        let session = self.renderer.session();
        if session.is_prepared() {
            return session.prepare();
        }
        let start = Instant::now();
        observer.begin(Phase::Compiling);
        let prepared = std::thread::scope(|scope| {
            let (done, wait) = channel::<()>();
            let thread = scope.spawn(move || {
                let _done = done;
                session.prepare()
            });
            while wait.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                observer.compiling(start.elapsed().as_secs_f64());
            }
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        });
        self.preparation.compile_wait_seconds += start.elapsed().as_secs_f64();
        prepared
    }

    /// Means of the samples that there are, three floats a pixel, for CUDA on the same device, without a way through the host;
    /// `None` where that cannot be, or the picture is more than that: without its background.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    #[cfg(target_os = "linux")]
    pub fn means_in_cuda(&mut self) -> Result<Option<raggio_vulkan::CudaMemory>, DeviceError> {
        if self.scene.settings.alpha { Ok(None) } else { self.renderer.session().means_in_cuda() }
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
        self.request.check_memory(scene)
    }

    fn restart(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.restart_device()?;
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
        // No other scene follows, nor this one once more where no device can be lost.
        if !self.renderer.session().may_be_lost() {
            self.renderer.settle();
            self.scene.settle();
        }
        let failure = self.sample(observer).err();
        self.is_last = true;
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
        let start = Instant::now();
        let End { gathered, checkpoint, is_labelled, finished } = loop {
            match self.end(failure.is_some(), observer) {
                // The first failure is what to report.
                Err(error) if failure.is_some() => return Err(failure.take().unwrap_or(error)),
                Err(error) => failure = self.overcome(error, observer).and_then(|()| self.sample(observer)).err(),
                Ok(end) => break end,
            }
        };
        let Gathered { film, label, notes: _, state, progress } = gathered;
        let film = if is_labelled { film.with_label(label.make()).with_notes(self.metadata.notes()) } else { film };
        if film.rejected() > 0 {
            observer.warn(&format!(
                "{} samples had no finite value, or more than {MAX_NESTED_MEDIA} dielectrics overlapped there; they were left out",
                film.rejected(),
            ));
        }
        let film_seconds = start.elapsed().as_secs_f64();
        let mut rendered = self.finish(film, progress, finished, failure, checkpoint, observer);
        rendered.development.film_seconds = film_seconds;
        Ok(Rendered { keeper: self.keeper.take(), unsaved: Some((label, state)), ..rendered })
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
        Ok(self.finish(film, progress, finished, None, Some(path.to_owned()), observer))
    }

    /// Adds to a film what belongs to its picture, unless the device has met a `failure` or meets one now.
    fn finish(
        &mut self,
        film: Film,
        progress: Progress,
        finished: bool,
        mut failure: Option<DeviceError>,
        checkpoint: Option<PathBuf>,
        observer: &mut dyn Observer,
    ) -> Rendered {
        let start = Instant::now();
        let mut features = None;
        let mut coverage = None;
        while failure.is_none() && features.is_none() {
            match self.features(observer, &film, &progress) {
                Ok(found) => (features, coverage) = (Some(found.0), found.1),
                Err(error) => failure = self.overcome(error, observer).err(),
            }
        }
        self.preparation.compile_seconds = self.renderer.session().compile_time().as_secs_f64();
        let film = if coverage.is_some() { film.with_coverage(coverage) } else { film };
        let picture = self.picture(film, features);
        Rendered {
            picture,
            progress,
            preparation: self.preparation,
            development: Development { film_seconds: 0.0, layers_seconds: start.elapsed().as_secs_f64() },
            tracer: self.renderer.session().tracer(),
            finished,
            failure,
            checkpoint,
            shapes: self.scene.shapes(),
            triangles: self.scene.triangles(),
            keeper: None,
            unsaved: None,
        }
    }

    /// Takes samples until there are enough, in number or by the clock, or `observer` breaks off. A device that is lost is
    /// opened again a few times.
    ///
    /// # Errors
    /// A [`DeviceError`] when the device fails.
    pub fn sample(&mut self, observer: &mut dyn Observer) -> Result<(), DeviceError> {
        std::mem::take(&mut self.warnings).iter().for_each(|warning| observer.warn(warning));
        self.is_done = false;
        self.begin_safely()?;
        if let Some(keeper) = &mut self.keeper {
            keeper.begin(self.renderer.progress().samples);
        }
        // Whoever goes on has spent some of the time already, and what the driver compiles takes none of it.
        let (start, before, compiling) = (Instant::now(), self.spent, Cell::new(Duration::ZERO));
        let clock = || before + (start.elapsed() - compiling.get()).as_secs_f64();
        loop {
            let begun = Instant::now();
            let prepared = match self.prepare(observer) {
                Err(error) if error.is_out_of_memory() => self.prepare(observer),
                prepared => prepared,
            };
            compiling.set(compiling.get() + begun.elapsed());
            let sampled = prepared.and_then(|()| {
                observer.begin(Phase::Sampling);
                self.sample_on(&clock, observer)
            });
            match sampled {
                Ok(()) => break,
                Err(error) => self.overcome(error, observer)?,
            }
        }
        // What follows is not to be stopped by who has stopped this.
        self.stop_flag().store(false, Ordering::Relaxed);
        Ok(())
    }

    /// Takes samples as [`Rendering::sample`] does, until the device fails; `clock` tells the seconds that have been spent.
    fn sample_on(&mut self, clock: &dyn Fn() -> f64, observer: &mut dyn Observer) -> Result<(), DeviceError> {
        let limit = self.request.stop.time_limit.map_or(f64::INFINITY, f64::from);
        let mut is_second_try = false;
        while !self.renderer.finished() {
            self.spent = clock();
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
            self.spent = clock();
            progress.fraction = progress.fraction.max(self.spent / limit).min(1.0);
            let proceeds = observer.progress(&progress).is_continue() && !self.stop_flag().load(Ordering::Relaxed);
            if !proceeds {
                self.is_done = self.renderer.finished();
                return Ok(());
            }
            self.keep(&progress, observer)?;
        }
        self.is_done = true;
        Ok(())
    }

    /// Reads the film at the end of sampling, and keeps it in a checkpoint where there is to be one, until its files are
    /// written. Where the film is lost, it is the one that was gathered last.
    fn end(&mut self, has_failed: bool, observer: &mut dyn Observer) -> Result<End, DeviceError> {
        let (gathered, is_lost) = match self.read() {
            Ok(gathered) => (Arc::new(gathered), false),
            Err(error) if has_failed => (self.safety.gathered().ok_or(error)?, true),
            Err(error) => return Err(error),
        };
        let (mut checkpoint, mut is_labelled) = (None, self.request.label);
        if let Some(keeper) = &mut self.keeper {
            keeper.finish_writing(observer);
            if has_failed || keeper.owns() || keeper.is_worth_it(&gathered.progress) {
                is_labelled = true;
                checkpoint = keeper.save(&gathered, observer).then(|| keeper.path().to_owned());
                // Who is done writes files next, and saves the film elsewhere only if these cannot be written.
                if checkpoint.is_none() && (!self.is_done || is_lost) {
                    checkpoint = keeper.save_elsewhere(&gathered, &refuges());
                }
            }
        }
        let finished = !is_lost && self.renderer.finished();
        let gathered = Arc::try_unwrap(gathered).unwrap_or_else(|shared| Gathered::clone(&shared));
        Ok(End { gathered, checkpoint, is_labelled, finished })
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
