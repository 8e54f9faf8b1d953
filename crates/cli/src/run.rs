//! A render of the program: a request in, words and files out.

use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::time::Instant;

use raggio_render::{
    Checkpoints, Denoiser, Device, DeviceError, DeviceScene, Display, Fingerprint, Gpu, ImageFile, Observer, Phase,
    Picture, Progress, RenderError, RenderRequest, Rendered, Rendering, Stop, UNLIMITED_SAMPLES, gpu_of,
};
use raggio_scene::{RenderSettings, Scene, counted, display_name};

use crate::args::{MachineArguments, Overrides};
use crate::error::Failure;
use crate::files::Files;
use crate::opening::Opening;
use crate::output::say;
use crate::progress::{End, ProgressStyle, Reporter};
use crate::signals::{self, Stopped};
use crate::stats::{Setup, Stats, Written};

/// A render and all that is wanted of it.
pub struct Job<'a> {
    pub start: Instant,
    pub scene: Scene,
    pub request: RenderRequest,
    pub files: &'a Files,
    pub denoiser: Option<&'a Denoiser>,
    pub machine: &'a MachineArguments,
    /// Device, which is opened meanwhile.
    pub opening: Opening<'a>,
    pub overrides: &'a Overrides,
    pub progress: ProgressStyle,
}

/// Renders, writes all files, and says how it went.
pub fn run(job: Job) -> Result<(), Failure> {
    let Job { start, mut scene, mut request, files, denoiser, machine, opening, overrides, progress } = job;
    let read_seconds = Some(start.elapsed().as_secs_f64());
    override_settings(&mut scene, overrides);
    request.stop.samples = overrides.samples.map(|range| range.start..range.end);
    let warn = warnings(machine.quiet);
    scene.warnings.iter().for_each(|warning| warn(warning));
    warn_of_left(request.checkpoints.as_ref(), &warn);
    request.check_memory(&scene)?;
    let begun = Instant::now();
    let translated = DeviceScene::new(&scene).map_err(RenderError::from)?;
    let translate_seconds = begun.elapsed().as_secs_f64();
    let (device, open_seconds) = opening.finish(&warn)?;
    let (stop, checkpoint) = (request.stop.clone(), request.checkpoints.as_ref().map(|kept| kept.path.clone()));
    let mut rendering = Rendering::begin_translated(&scene, translated, &*device, request)?;
    rendering.note_translation(translate_seconds);
    let target = Target::of(&rendering, &stop);
    let mut reporter = Reporter::new(machine.quiet, progress, target.end);
    reporter.say(&format!("{}, {} on {}", size_of(&scene), target.words, device.name()));
    tell_where_it_goes_on(&rendering, &reporter);
    // A signal ends the program at once as long as there are no samples that it could lose.
    rendering.prepare(&mut reporter)?;
    let setup = Setup { start, seconds: start.elapsed().as_secs_f64(), read_seconds, open_seconds };

    let mut listener = Listener { reporter, stopped: signals::listen(rendering.stop_flag()) };
    let rendered = rendering.run(&mut listener)?;
    listener.reporter.finish();
    let made = Made {
        rendered,
        files,
        denoiser,
        device: &device.name(),
        gpu: gpu_of(&*device),
        settings: &scene.render,
        setup,
        target: target.samples,
        checkpoint: checkpoint.as_deref(),
        fingerprint: None,
    };
    made.conclude(&mut listener)?;
    listener.reporter.done();
    Ok(())
}

/// Teller of warnings, unless all is to be quiet.
fn warnings(quiet: bool) -> impl Fn(&str) {
    move |warning| {
        if !quiet {
            say(format_args!("warning: {warning}"));
        }
    }
}

/// Opens the device that is asked for.
pub fn open(machine: &MachineArguments) -> Result<Box<dyn Device>, DeviceError> {
    raggio_render::open_all(&machine.device, &machine.options(), warnings(machine.quiet))
}

/// Warns of a checkpoint that is there though nobody wants to go on from it.
pub fn warn_of_left(checkpoints: Option<&Checkpoints>, warn: &dyn Fn(&str)) {
    if let Some(kept) = checkpoints.filter(|kept| !kept.resume && kept.path.exists()) {
        let path = display_name(&kept.path);
        warn(&format!(
            "{path} is left of an earlier render: --resume goes on from it, and otherwise it will be replaced"
        ));
    }
}

/// Size of a scene's picture, in words.
pub fn size_of(scene: &Scene) -> String {
    format!("{}x{}", scene.render.width, scene.render.height)
}

/// Says from which checkpoint a render goes on, if it does.
pub fn tell_where_it_goes_on(rendering: &Rendering, reporter: &Reporter) {
    if let Some(path) = rendering.resumed() {
        let has = counted(rendering.progress().samples as usize, "sample");
        reporter.say(&format!("going on from {}, which has {has} per pixel", display_name(path)));
    }
}

/// End of a render, as it is asked for.
pub struct Target {
    /// Samples of each pixel, or `UNLIMITED_SAMPLES`.
    pub samples: u32,
    pub end: End,
    /// The end in words.
    pub words: String,
}

impl Target {
    pub fn of(rendering: &Rendering, stop: &Stop) -> Self {
        let range = rendering.samples();
        let samples = if range.end < UNLIMITED_SAMPLES { range.len() as u32 } else { UNLIMITED_SAMPLES };
        // The number of samples is no end to be expected where noise is to end it.
        let expected = if stop.noise.is_none() { samples } else { UNLIMITED_SAMPLES };
        let end = End { samples: expected, time_limit: stop.time_limit };
        Self { samples, end, words: describe_end(&range, stop) }
    }
}

/// A picture that has been rendered, and what is to become of it.
pub struct Made<'a> {
    pub rendered: Rendered,
    pub files: &'a Files,
    pub denoiser: Option<&'a Denoiser>,
    pub device: &'a str,
    /// GPU of the device, where the denoiser works if it can.
    pub gpu: Option<Gpu>,
    pub settings: &'a RenderSettings,
    pub setup: Setup,
    /// Samples of each pixel that were asked for.
    pub target: u32,
    /// Path at which its checkpoint was to be.
    pub checkpoint: Option<&'a Path>,
    /// Fingerprint for its files, if they are to have one.
    pub fingerprint: Option<Fingerprint>,
}

impl Made<'_> {
    /// Writes all files, and says how it went.
    pub fn conclude(mut self, listener: &mut Listener) -> Result<(), Failure> {
        let Listener { reporter, stopped } = listener;
        let failure = self.rendered.failure.take();
        let signal = stopped.signal();
        let is_stopped = signal.is_some() || failure.is_some();
        if let Some(metadata) = &mut self.rendered.picture.extras.metadata {
            metadata.fingerprint = self.fingerprint.filter(|_| !is_stopped);
        }
        let Self { rendered, files, denoiser, device, gpu, settings, setup, target, checkpoint, .. } = &self;
        let (picture, progress) = (&rendered.picture, &rendered.progress);
        reporter.report(&picture.film, progress, if rendered.finished { progress.samples } else { *target });
        // One thing that fails is no reason to lose the others.
        reporter.begin(Phase::Writing);
        let begun = Instant::now();
        let mut outcome = write(picture, &files.pictures, files.display, &|line| reporter.say(line));
        let mut times = Written { write_seconds: begun.elapsed().as_secs_f64(), denoise_seconds: None, denoiser: None };
        if let (Some(denoiser), None) = (denoiser, &failure) {
            reporter.begin(Phase::Denoising);
            let begun = Instant::now();
            gpu.iter().for_each(|gpu| denoiser.prefer(gpu));
            let denoised = picture.denoised(denoiser).map_err(Failure::from);
            let tell = |line: &str| reporter.say(line);
            let written = denoised.and_then(|picture| write(&picture, &files.denoised, files.display, &tell));
            outcome = both(outcome, written);
            if let Some(sentence) = denoiser.complaint() {
                reporter.warn(&sentence);
            }
            times.denoise_seconds = Some(begun.elapsed().as_secs_f64());
            times.denoiser = Some(format!("{} on {}", denoiser.name(), denoiser.place()));
        }
        if let Some(file) = &files.stats {
            let stats = Stats { device, rendered, settings, setup: *setup, written: times };
            outcome = both(outcome, stats.write(file));
        }
        if let Err(Failure::Unwritten(message)) = outcome {
            outcome = Err(rescued(rendered, files, message));
        }
        if outcome.is_ok() && !is_stopped {
            if let Err(error) = rendered.remove_checkpoints() {
                reporter.say(&format!("warning: a checkpoint is left over: {error}"));
            }
        } else if is_stopped {
            tell_how_to_go_on(rendered, signal, *checkpoint, reporter);
        }
        both(outcome, failure.map_or(Ok(()), |error| Err(error.into())))?;
        signal.map_or(Ok(()), |signal| Err(Failure::Interrupted(signal)))
    }
}

/// Says where the film of a render that has ended early is, and how to go on from it; `wanted` is where it was to be.
pub fn tell_how_to_go_on(rendered: &Rendered, signal: Option<u8>, wanted: Option<&Path>, reporter: &Reporter) {
    let Some(path) = &rendered.checkpoint else { return };
    let reason = signal.map(|signal| format!("stopped by {}: ", signals::name(signal))).unwrap_or_default();
    let place = if Some(&**path) == wanted { String::new() } else { format!("--checkpoint {} ", display_name(path)) };
    let path = display_name(path);
    reporter.say(&format!(
        "{reason}what there is is saved in {path}: the same command with {place}--resume goes on from it"
    ));
}

/// Saves the film of a render whose files cannot be written, and says where it is. Returns the failure.
fn rescued(rendered: &Rendered, files: &Files, message: String) -> Failure {
    let name = files.pictures.first().map(|file| file.path().with_extension("")).unwrap_or_default();
    match rendered.rescue(&name.file_name().unwrap_or_default().to_string_lossy()) {
        Ok(path) => {
            let path = display_name(&path);
            say(format_args!(
                "the film is saved in {path}: `raggio merge {path} -o FILE` makes a picture of it, and the same command with \
                 --checkpoint {path} --resume writes all files"
            ));
            Failure::Unwritten(message)
        }
        Err(error) => Failure::Input(format!("{message}; and the film could not be saved either: {error}")),
    }
}

/// Writes a picture to all of `files`.
///
/// # Errors
/// The last failure; those before it are told, and the other files are written nevertheless.
pub fn write(picture: &Picture, files: &[ImageFile], display: Display, tell: &dyn Fn(&str)) -> Result<(), Failure> {
    let mut outcome = Ok(());
    for file in files {
        match picture.write(file, display) {
            Ok(()) => tell(&format!("wrote {}", display_name(file.path()))),
            Err(error) => outcome = both(outcome, Err(Failure::Unwritten(error.to_string()))),
        }
    }
    outcome
}

/// The last failure of two outcomes; one before another is told at once.
pub fn both(first: Result<(), Failure>, second: Result<(), Failure>) -> Result<(), Failure> {
    match (first, second) {
        (Err(first), Err(second)) => {
            say(format_args!("error: {first}"));
            Err(second)
        }
        (first, second) => first.and(second),
    }
}

/// Reports progress, and breaks off when a signal has come.
pub struct Listener {
    pub reporter: Reporter,
    pub stopped: Stopped,
}

impl Observer for Listener {
    fn warn(&mut self, warning: &str) {
        self.reporter.warn(warning);
    }

    fn begin(&mut self, phase: Phase) {
        self.reporter.begin(phase);
    }

    fn compiling(&mut self, seconds: f64) {
        self.reporter.compiling(seconds);
    }

    fn saved(&mut self, checkpoint: &Path) {
        self.reporter.saved(checkpoint);
    }

    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.reporter.update(progress);
        if self.stopped.signal().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Has the command line's settings take the place of the scene's.
pub fn override_settings(scene: &mut Scene, overrides: &Overrides) {
    let Overrides { samples, size, max_depth, seed, sampler, filter, clamp, alpha, foreign: _ } = *overrides;
    let render = &mut scene.render;
    render.samples = samples.map_or(render.samples, |range| range.end - range.start);
    render.max_depth = max_depth.unwrap_or(render.max_depth);
    render.seed = seed.unwrap_or(render.seed);
    render.sampler = sampler.unwrap_or(render.sampler);
    render.filter = filter.unwrap_or(render.filter);
    render.clamp = clamp.or(render.clamp);
    render.alpha |= alpha;
    if let Some(size) = size {
        (render.width, render.height) = (size.width, size.height);
    }
}

/// End of the render that is asked for, in words.
pub fn describe_end(samples: &Range<u32>, stop: &Stop) -> String {
    let limits = [
        (samples.end < UNLIMITED_SAMPLES).then(|| match samples.start {
            0 => counted(samples.len(), "sample"),
            first => format!("samples {first}..{}", samples.end),
        }),
        stop.noise.map(|noise| format!("an error below {noise}")),
        stop.time_limit.map(|seconds| format!("{seconds} s")),
    ];
    limits.into_iter().flatten().collect::<Vec<_>>().join(" or ")
}
