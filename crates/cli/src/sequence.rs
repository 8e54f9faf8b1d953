//! Frames of an animation, one after the other on one device.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use raggio_render::{
    Aov, Denoiser, Device, DeviceScene, Fingerprint, Frames, ImageFile, Pattern, RenderRequest, Rendering,
    UNLIMITED_SAMPLES, gpu_of,
};
use raggio_scene::{Assets, Scene, counted, display_name, is_model, scene_text};

use crate::args::RenderArguments;
use crate::cluster;
use crate::error::Failure;
use crate::files::{Files, check_apart, denoiser};
use crate::order::{checkpoints, request, wanted};
use crate::progress::{End, FramePlace, Reporter, duration};
use crate::run::{Listener, Made, Target, open, override_settings, size_of, tell_where_it_goes_on, warn_of_left};
use crate::signals;
use crate::stats::Setup;
use crate::video::Video;

/// Runs `raggio render --frames`.
pub fn render(arguments: &RenderArguments, frames: &Frames, start: Instant) -> Result<(), Failure> {
    let patterns = Patterns::new(arguments, frames)?;
    let mut request = request(arguments, &patterns.outputs(frames.numbers()[0]));
    request.stop.samples = arguments.overrides.samples.map(|range| range.start..range.end);
    let denoiser = denoiser(request.denoise)?;
    let mut source = Source::new(arguments, frames.numbers()[0])?;
    let inputs = source.inputs();
    let mut all = vec![];
    for frame in frames.numbers() {
        all.push(patterns.files(arguments, *frame, &inputs)?);
    }
    let video = arguments.frames.video.as_deref();
    let video = video.map(|path| Video::new(path, arguments.frames.fps)).transpose()?;
    if let Some(video) = &video {
        let shown = all.iter().flat_map(|files| &files.pictures).map(|picture| picture.file().clone());
        check_apart(&[vec![video.file().clone()], shown.collect()].concat(), &inputs)?;
    }

    let mut job = Job {
        arguments,
        request,
        denoiser: denoiser.as_ref().map(|denoiser| (denoiser, denoiser.name())),
        setup: start,
        idle: Some(Reporter::new(arguments.machine.quiet, arguments.progress, UNKNOWN_END)),
        started: None,
        told: HashSet::new(),
        rendered: 0,
        rendering_seconds: 0.0,
        total: all.len(),
    };
    let mut translated: Option<DeviceScene> = None;
    let tells_motion = job.request.layers.contains(&Aov::Motion);
    let mut last: Option<(u32, Scene)> = None;
    let mut pending = vec![];
    for (place, (frame, files)) in frames.numbers().iter().zip(&all).enumerate() {
        let earlier = match last.take().filter(|(number, _)| number + 1 == *frame) {
            Some((_, scene)) => Some(scene),
            None if tells_motion => Some(source.scene_before(*frame).map_err(|failure| in_frame(*frame, failure))?),
            None => None,
        };
        let scene = source.scene(*frame).map_err(|failure| in_frame(*frame, failure))?;
        job.warn(&scene);
        raggio_render::check_memory(scene.render.width, scene.render.height)?;
        let translation = match &mut translated {
            Some(translated) => translated.update(&scene),
            None => DeviceScene::new(&scene).map(|new| translated = Some(new)),
        };
        translation.map_err(|error| in_frame(*frame, Failure::Input(error.to_string())))?;
        let Some(translated) = &mut translated else { continue };
        if let Some(earlier) = earlier.filter(|_| tells_motion) {
            translated.move_from(&scene, &earlier);
        }
        if arguments.cluster.is_none() {
            job.frame(place, *frame, files, &scene, translated, patterns.checkpoint(*frame).as_deref())?;
        } else if !job.was_done(*frame, files, &Fingerprint::new(translated, &job.request)) {
            pending.push(*frame);
        }
        last = tells_motion.then_some((*frame, scene));
    }
    if let Some(address) = &arguments.cluster {
        job.spread(address, &pending, &patterns, &mut source.assets)?;
    }
    job.finish(video.as_ref(), frames, &all)
}

fn in_frame(frame: u32, failure: Failure) -> Failure {
    match failure {
        Failure::Input(message) => Failure::Input(format!("frame {frame}: {message}")),
        other => other,
    }
}

/// Scenes of the frames, all of one text.
struct Source<'a> {
    arguments: &'a RenderArguments,
    assets: Assets,
    /// Text of a scene file; a model has another in each frame.
    text: Option<String>,
}

impl<'a> Source<'a> {
    /// Reads the scene of the frame that comes first, whose mistakes are those of the scene.
    fn new(arguments: &'a RenderArguments, first: u32) -> Result<Self, Failure> {
        let mut assets = Assets::new(arguments.assets.options(arguments.overrides.size));
        assets.set_elapsed(arguments.frames.fps.moment(first));
        let text = match is_model(&arguments.scene) {
            true => None,
            false => Some(scene_text(&arguments.scene, &mut assets)?),
        };
        let mut source = Self { arguments, assets, text };
        source.scene(first)?;
        Ok(source)
    }

    /// The scene of a frame.
    fn scene(&mut self, frame: u32) -> Result<Scene, Failure> {
        self.at(self.arguments.frames.fps.moment(frame))
    }

    /// The scene of the moment that is a frame before.
    fn scene_before(&mut self, frame: u32) -> Result<Scene, Failure> {
        self.at(self.arguments.frames.fps.moment_before(frame))
    }

    fn at(&mut self, seconds: f64) -> Result<Scene, Failure> {
        let path = &self.arguments.scene;
        self.assets.set_elapsed(seconds);
        let mut scene = match &self.text {
            Some(text) => Scene::parse_with(text, path, &mut self.assets)?,
            None => Scene::load_with(path, &mut self.assets)?,
        };
        scene.render.integrator = self.arguments.integrator;
        override_settings(&mut scene, &self.arguments.overrides);
        Ok(scene)
    }

    /// Files that no frame may replace.
    fn inputs(&self) -> Vec<PathBuf> {
        std::iter::once(self.arguments.scene.as_path()).chain(self.assets.all_files()).map(PathBuf::from).collect()
    }
}

/// Names of the files of each frame.
struct Patterns {
    outputs: Vec<Pattern>,
    stats: Option<Pattern>,
    checkpoint: Option<Pattern>,
}

impl Patterns {
    fn new(arguments: &RenderArguments, frames: &Frames) -> Result<Self, Failure> {
        let pattern = |path: &PathBuf| {
            let pattern = Pattern::new(path);
            pattern.check(frames).map(|()| pattern).map_err(Failure::Input)
        };
        let outputs = match &arguments.output[..] {
            [] => vec![Pattern::named(arguments.scene.file_stem().unwrap_or_default())],
            outputs => outputs.iter().map(pattern).collect::<Result<_, _>>()?,
        };
        let stats = arguments.stats.as_ref().map(pattern).transpose()?;
        let checkpoint = arguments.checkpoints.checkpoint.as_ref().map(pattern).transpose()?;
        Ok(Self { outputs, stats, checkpoint })
    }

    fn outputs(&self, frame: u32) -> Vec<PathBuf> {
        self.outputs.iter().map(|pattern| pattern.of(frame)).collect()
    }

    fn checkpoint(&self, frame: u32) -> Option<PathBuf> {
        self.checkpoint.as_ref().map(|pattern| pattern.of(frame))
    }

    fn files(&self, arguments: &RenderArguments, frame: u32, inputs: &[PathBuf]) -> Result<Files, Failure> {
        let (outputs, checkpoint) = (self.outputs(frame), self.checkpoint(frame));
        let stats = self.stats.as_ref().map(|pattern| pattern.of(frame));
        Files::new(&wanted(arguments, &outputs, stats.as_deref(), checkpoint.as_deref()), inputs)
    }
}

/// Way on from a sequence that was stopped.
const GOES_ON: &str = "the same command goes on with the frames that are not done";

/// End of a render of which nothing is known yet.
const UNKNOWN_END: End = End { samples: UNLIMITED_SAMPLES, time_limit: None };

/// Sequence under way.
struct Job<'a> {
    arguments: &'a RenderArguments,
    request: RenderRequest,
    denoiser: Option<(&'a Denoiser, String)>,
    /// Moment at which the program began.
    setup: Instant,
    /// Reporter until the device is at work, which then has it.
    idle: Option<Reporter>,
    /// Device at work, once a frame has been found that is not done.
    started: Option<Started>,
    /// Warnings that have been told.
    told: HashSet<String>,
    /// Frames that were rendered, and the time that they took.
    rendered: usize,
    rendering_seconds: f64,
    total: usize,
}

/// Device at work on the frames, and who hears of it.
struct Started {
    device: Box<dyn Device>,
    rendering: Rendering,
    listener: Listener,
    target: u32,
    setup: Setup,
}

impl Job<'_> {
    /// Tells the warnings of a frame's scene that no frame before had.
    fn warn(&mut self, scene: &Scene) {
        for warning in &scene.warnings {
            if self.told.insert(warning.clone()) {
                self.tell(&format!("warning: {warning}"));
            }
        }
    }

    fn tell(&self, line: &str) {
        if let Some(reporter) = self.started.as_ref().map(|started| &started.listener.reporter).or(self.idle.as_ref()) {
            reporter.say(line);
        }
    }

    fn reporter(&mut self) -> Option<&mut Reporter> {
        self.started.as_mut().map(|started| &mut started.listener.reporter).or(self.idle.as_mut())
    }

    /// Renders a frame, unless it is done. `place` is its place among all of them.
    fn frame(
        &mut self,
        place: usize,
        frame: u32,
        files: &Files,
        scene: &Scene,
        translated: &DeviceScene,
        checkpoint: Option<&Path>,
    ) -> Result<(), Failure> {
        let mean_seconds = (self.rendered > 0).then(|| self.rendering_seconds / self.rendered as f64);
        let frame_place = FramePlace { number: frame, done: place, total: self.total, mean_seconds };
        if let Some(reporter) = self.reporter() {
            reporter.begin_frame(frame_place);
        }
        let fingerprint = Fingerprint::new(translated, &self.request);
        if self.was_done(frame, files, &fingerprint) {
            return self.stopped();
        }
        let begun = Instant::now();
        let checkpoints = checkpoints(&self.arguments.checkpoints, checkpoint, files, &self.arguments.scene);
        warn_of_left(checkpoints.as_ref(), &|warning| self.tell(&format!("warning: {warning}")));
        let wanted = checkpoints.as_ref().map(|kept| kept.path.clone());
        self.request.checkpoints = checkpoints;
        match &mut self.started {
            Some(started) => {
                started.rendering.next_frame(scene, translated.clone(), self.request.checkpoints.clone())?;
                let seconds = begun.elapsed().as_secs_f64();
                started.setup = Setup { start: begun, seconds, read_seconds: None, open_seconds: 0.0 };
            }
            None => self.start(scene, translated)?,
        }
        self.stopped()?;
        let denoiser = self.denoiser.as_ref().map(|(denoiser, _)| *denoiser);
        let Some(Started { device, rendering, listener, target, setup }) = &mut self.started else {
            return Ok(());
        };
        tell_where_it_goes_on(rendering, &listener.reporter);
        let failure = rendering.sample(listener).err();
        let rendered = rendering.develop(listener, failure)?;
        let made = Made {
            rendered,
            files,
            denoiser,
            device: &device.name(),
            gpu: gpu_of(&**device),
            settings: &scene.render,
            setup: *setup,
            target: *target,
            checkpoint: wanted.as_deref(),
            fingerprint: Some(fingerprint),
        };
        let is_saved = made.rendered.checkpoint.is_some();
        let concluded = made.conclude(listener);
        if let (Err(Failure::Interrupted(_)), false) = (&concluded, is_saved) {
            listener.reporter.say(GOES_ON);
        }
        concluded?;
        self.rendered += 1;
        self.rendering_seconds += begun.elapsed().as_secs_f64();
        Ok(())
    }

    /// Whether a frame need not be rendered, which is told.
    fn was_done(&self, frame: u32, files: &Files, fingerprint: &Fingerprint) -> bool {
        let was_done = !self.arguments.frames.overwrite && self.is_done(files, fingerprint);
        if was_done {
            self.tell(&format!("frame {frame} is done: {}", listed(files)));
        }
        was_done
    }

    /// Has `frames` rendered on the cluster at `address`, each by one machine.
    fn spread(
        &mut self,
        address: &str,
        frames: &[u32],
        patterns: &Patterns,
        assets: &mut Assets,
    ) -> Result<(), Failure> {
        let Some(mut reporter) = self.idle.take().filter(|_| !frames.is_empty()) else { return Ok(()) };
        let begun = Instant::now();
        reporter.say(&format!("{} on the cluster at {address}", counted(frames.len(), "frame")));
        let outputs = patterns.outputs.iter().map(|pattern| ("-o", pattern.path()));
        let stats = patterns.stats.iter().map(|pattern| ("--stats", pattern.path()));
        let outputs: Vec<_> = outputs.chain(stats).collect();
        let stopped = signals::listen(Arc::new(AtomicBool::new(false)));
        let (total, before) = (self.total, self.total - frames.len());
        let rendered = &mut self.rendered;
        let outcome =
            cluster::frames(self.arguments, address, frames, &outputs, assets, &stopped, &mut |done| match done {
                cluster::Told::Words(words) => reporter.say(&words),
                cluster::Told::Frame(number) => {
                    *rendered += 1;
                    let mean_seconds = Some(begun.elapsed().as_secs_f64() / *rendered as f64);
                    reporter.begin_frame(FramePlace { number, done: before + *rendered, total, mean_seconds });
                }
            });
        self.rendering_seconds = begun.elapsed().as_secs_f64();
        if let Some(signal) = stopped.signal() {
            reporter.say(&format!("stopped by {}: {GOES_ON}", signals::name(signal)));
            return Err(Failure::Interrupted(signal));
        }
        self.idle = Some(reporter);
        outcome
    }

    /// Whether all of a frame's files are there and are what would be rendered.
    fn is_done(&self, files: &Files, fingerprint: &Fingerprint) -> bool {
        let is_done = |file: &ImageFile, denoiser| file.is_done(fingerprint, files.display, denoiser);
        let denoiser = self.denoiser.as_ref().map(|(_, name)| name.as_str());
        files.pictures.iter().all(|file| is_done(file, None))
            && files.denoised.iter().all(|file| is_done(file, denoiser))
    }

    /// Opens the device for the first frame that is to be rendered.
    fn start(&mut self, scene: &Scene, translated: &DeviceScene) -> Result<(), Failure> {
        let machine = &self.arguments.machine;
        let opened = Instant::now();
        let device = open(machine)?;
        let open_seconds = opened.elapsed().as_secs_f64();
        let mut rendering = Rendering::begin_translated(scene, translated.clone(), &*device, self.request.clone())?;
        let target = Target::of(&rendering, &self.request.stop);
        let Some(mut reporter) = self.idle.take() else { return Ok(()) };
        reporter.set_end(target.end);
        let frames = counted(self.total, "frame");
        reporter.say(&format!("{frames} of {}, {} on {}", size_of(scene), target.words, device.name()));
        rendering.prepare(&mut reporter)?;
        let listener = Listener { reporter, stopped: signals::listen(rendering.stop_flag()) };
        let (start, seconds) = (self.setup, self.setup.elapsed().as_secs_f64());
        let setup = Setup { start, seconds, read_seconds: None, open_seconds };
        self.started = Some(Started { device, rendering, listener, target: target.samples, setup });
        Ok(())
    }

    /// Ends the sequence where a signal has come between two frames: what is done stays.
    fn stopped(&self) -> Result<(), Failure> {
        let signal = self.started.as_ref().and_then(|started| started.listener.stopped.signal());
        let Some(signal) = signal else { return Ok(()) };
        let name = signals::name(signal);
        self.tell(&format!("stopped by {name}: {GOES_ON}"));
        Err(Failure::Interrupted(signal))
    }

    /// Says how it went, and makes the video of all frames.
    fn finish(mut self, video: Option<&Video>, frames: &Frames, all: &[Files]) -> Result<(), Failure> {
        if let Some(reporter) = self.reporter() {
            reporter.finish();
        }
        let [rendered, skipped] = [self.rendered, self.total - self.rendered];
        let before = if skipped > 0 { format!(", {skipped} done before") } else { String::new() };
        let seconds = duration(self.rendering_seconds);
        self.tell(&format!("{} in {seconds}{before}", counted(rendered, "frame") + " rendered"));
        if let Some(video) = video {
            let of_frame = |frame: &u32| frames.numbers().iter().position(|number| number == frame);
            let in_time: Vec<_> = frames.sorted().iter().filter_map(of_frame).map(|place| &all[place]).collect();
            self.tell(&format!("making the video of {}", counted(in_time.len(), "frame")));
            let stopped = self.started.as_ref().map(|started| started.listener.stopped.clone()).unwrap_or_default();
            video.make(&in_time, &stopped)?;
            self.tell(&format!("wrote {}", display_name(video.file().path())));
        }
        if let Some(reporter) = self.reporter() {
            reporter.done();
        }
        Ok(())
    }
}

/// Names of a frame's pictures.
fn listed(files: &Files) -> String {
    let pictures = files.pictures.iter().chain(&files.denoised);
    pictures.map(|file| display_name(file.path())).collect::<Vec<_>>().join(", ")
}
