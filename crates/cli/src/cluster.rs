//! Renders on the machines of a cluster. Python has Ray, so it gathers the film; the rest is as on one machine.

mod python;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use raggio_render::{Checkpoints, DeviceChoice, Every, Film, Progress, Rendering, UNLIMITED_SAMPLES, gpu_of};
use raggio_scene::{Assets, RenderSettings, counted, display_name, is_model, scene_text};
use serde_json::{Value, json};

use crate::args::{MachineArguments, RenderArguments};
use crate::error::Failure;
use crate::output::say;
use crate::progress::{End, Reporter};
use crate::run::{
    Job, Listener, Made, both, describe_end, open, override_settings, size_of, tell_how_to_go_on, warn_of_left,
};
use crate::signals::{self, Stopped};
use crate::stats::Setup;
use python::Python;

/// Seconds from one film to the next that is kept, where nobody says otherwise.
const EVERY: f64 = 60.0;

/// Renders a picture on the cluster at `address`, and writes all files.
pub fn run(job: Job, address: &str, arguments: &RenderArguments, assets: &mut Assets) -> Result<(), Failure> {
    let Job { start, mut scene, mut request, files, denoiser, machine, opening: _, overrides, progress } = job;
    if request.stop.noise.is_some() {
        let message = "--noise judges the whole picture, of which each machine of a cluster has a part: give --samples or \
                       --time-limit";
        return Err(Failure::Input(message.into()));
    }
    let python = Python::find()?;
    override_settings(&mut scene, overrides);
    request.stop.samples = overrides.samples.map(|range| range.start..range.end);
    let samples = request.stop.samples(&scene.render);
    let warn = |warning: &str| {
        if !machine.quiet {
            say(format_args!("warning: {warning}"));
        }
    };
    scene.warnings.iter().for_each(|warning| warn(warning));
    warn_of_left(request.checkpoints.as_ref(), &warn);
    raggio_render::check_memory(scene.render.width, scene.render.height)?;

    let kept = Kept::new(request.checkpoints.take())?;
    let target = if samples.end < UNLIMITED_SAMPLES { samples.len() as u32 } else { UNLIMITED_SAMPLES };
    let end = End { samples: target, time_limit: request.stop.time_limit };
    let reporter = Reporter::new(machine.quiet, progress, end);
    let words = describe_end(&samples, &request.stop);
    reporter.say(&format!("{}, {words} on the cluster at {address}", size_of(&scene)));
    let mut listener = Listener { reporter, stopped: signals::listen(Arc::new(AtomicBool::new(false))) };
    let order = json!({
        "address": address,
        "scene": sent_scene(&arguments.scene, arguments, assets)?,
        "render": settings(&scene.render),
        "samples": [samples.start, samples.end],
        "integrator": scene.render.integrator.to_string(),
        "device": device(machine),
        "tracer": machine.tracer.tracer.name(),
        "threads": machine.threads,
        "time_limit": request.stop.time_limit,
        "film": kept.path,
        "every": kept.every,
        "resume": kept.resume,
    });
    let pixels = u64::from(scene.render.width) * u64::from(scene.render.height);
    let (summary, failure) = gather(&python, &order, pixels, &mut listener);
    let film = match (Film::read(&kept.path), &failure) {
        // A film that is left of an earlier render is none of this one.
        (Ok(film), _) if kept.resume || summary.has_film || kept.is_new() => film,
        (found, _) => {
            let signal = listener.stopped.signal().map(Failure::Interrupted);
            let nothing =
                || found.err().map_or(Failure::Device("the cluster has rendered nothing".into()), Failure::from);
            return Err(failure.or(signal).unwrap_or_else(nothing));
        }
    };
    let opened = Instant::now();
    let device = open(machine)?;
    let open_seconds = opened.elapsed().as_secs_f64();
    let mut rendering = Rendering::begin(&scene, &*device, request)?;
    let mut rendered = rendering.develop_film(film, &kept.path, summary.seconds, &mut listener)?;
    listener.reporter.finish();
    if kept.is_scratch() {
        rendered.checkpoint = None;
    }
    let checkpoint = kept.wanted.clone();
    if failure.is_some() {
        tell_how_to_go_on(&rendered, None, checkpoint.as_deref(), &listener.reporter);
    }
    let made = Made {
        rendered,
        files,
        denoiser,
        device: &summary.devices(),
        gpu: gpu_of(&*device),
        settings: &scene.render,
        setup: Setup {
            start,
            seconds: (start.elapsed().as_secs_f64() - summary.seconds).max(0.0),
            read_seconds: None,
            open_seconds,
        },
        target,
        checkpoint: checkpoint.as_deref(),
        fingerprint: None,
    };
    both(made.conclude(&mut listener), failure.map_or(Ok(()), Err))?;
    kept.remove();
    listener.reporter.done();
    Ok(())
}

/// Place of the film while it grows.
struct Kept {
    path: PathBuf,
    /// Path of the checkpoint that is asked for; `None` where there is to be none.
    wanted: Option<PathBuf>,
    resume: bool,
    every: f64,
    /// Folder of a film that nobody has asked for.
    scratch: Option<tempfile::TempDir>,
    was_there: bool,
}

impl Kept {
    fn new(checkpoints: Option<Checkpoints>) -> Result<Self, Failure> {
        let Some(Checkpoints { path, every, resume, .. }) = checkpoints else {
            let no_room = |error| Failure::Input(format!("there is no room for a film: {error}"));
            let scratch = tempfile::tempdir().map_err(no_room)?;
            let path = scratch.path().join("raggio.film");
            return Ok(Self {
                path,
                wanted: None,
                resume: false,
                every: EVERY,
                scratch: Some(scratch),
                was_there: false,
            });
        };
        let every = match every {
            Every::Seconds(seconds) => seconds,
            Every::Samples(_) => {
                let message = "--checkpoint-every counts samples on one machine alone: give a time (60s, 5min, 2h)";
                return Err(Failure::Input(message.into()));
            }
        };
        let was_there = path.exists();
        Ok(Self { wanted: Some(path.clone()), path, resume, every, scratch: None, was_there })
    }

    fn is_scratch(&self) -> bool {
        self.scratch.is_some()
    }

    fn is_new(&self) -> bool {
        !self.was_there
    }

    /// Removes the film: its files are written.
    fn remove(self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Facts of a film that has been gathered.
#[derive(Default)]
struct Summary {
    seconds: f64,
    has_film: bool,
    devices: Vec<String>,
}

impl Summary {
    fn devices(&self) -> String {
        let mut names = self.devices.clone();
        names.sort();
        names.dedup();
        match self.devices.len() {
            0 | 1 => names.concat(),
            count => format!("{}: {}", counted(count, "machine"), names.join(", ")),
        }
    }
}

/// Has the film gathered that `order` says, until it is whole, a signal has come, or something has failed.
fn gather(python: &Python, order: &Value, pixels: u64, listener: &mut Listener) -> (Summary, Option<Failure>) {
    let mut summary = Summary::default();
    let stopped = listener.stopped.clone();
    let outcome = python.run(order, &|| stopped.signal().is_some(), &mut |line| {
        if let Some(words) = words(line) {
            listener.reporter.say(&words);
        }
        if let Some([fraction, samples, seconds]) = numbers(&line["progress"]) {
            let total_samples = samples as u64 * pixels;
            let progress = Progress { samples: samples as u32, total_samples, fraction, noise: None, seconds };
            listener.reporter.update(&progress);
        }
        if let Some(path) = line["resumed"].as_str() {
            let has = counted(line["samples"].as_u64().unwrap_or(0) as usize, "sample");
            let path = display_name(Path::new(path));
            listener.reporter.say(&format!("going on from {path}, which has {has} per pixel"));
        }
        if let Some(done) = line["done"].as_object() {
            summary.seconds = done["seconds"].as_f64().unwrap_or(0.0);
            summary.has_film = done["film"].as_bool().unwrap_or(false);
            let names = done["devices"].as_array().into_iter().flatten();
            summary.devices = names.filter_map(|name| name.as_str().map(str::to_owned)).collect();
        }
    });
    (summary, outcome.err())
}

/// News of frames under way.
pub enum Told {
    /// A line for the user.
    Words(String),
    /// Number of a frame that is done.
    Frame(u32),
}

/// Has `frames` rendered on the cluster at `address`, each into the files of `outputs`, which are options and patterns.
pub fn frames(
    arguments: &RenderArguments,
    address: &str,
    frames: &[u32],
    outputs: &[(&str, &Path)],
    assets: &mut Assets,
    stopped: &Stopped,
    told: &mut dyn FnMut(Told),
) -> Result<(), Failure> {
    let order = json!({
        "address": address,
        "scene": sent_scene(&arguments.scene, arguments, assets)?,
        "frames": frames,
        "options": options(arguments),
        "outputs": outputs,
        "device": device(&arguments.machine),
        "threads": arguments.machine.threads,
    });
    Python::find()?.run(&order, &|| stopped.signal().is_some(), &mut |line| {
        if let Some(words) = words(line) {
            told(Told::Words(words));
        }
        if let Some(frame) = line["frame"].as_u64().and_then(|frame| frame.try_into().ok()) {
            told(Told::Frame(frame));
        }
    })
}

/// Options of `raggio render` by which another machine renders the frames, but for what differs from machine to machine.
fn options(arguments: &RenderArguments) -> Vec<String> {
    let RenderArguments { assets, frames, overrides, stop, look, aov, .. } = arguments;
    let given = [
        ("--time", assets.time.map(|time| time.to_string())),
        ("--camera", assets.camera.clone()),
        ("--fps", Some(frames.fps.per_second().to_string())),
        ("--device", Some(device(&arguments.machine))),
        ("--tracer", Some(arguments.machine.tracer.tracer.to_string())),
        ("--samples", overrides.samples.map(|range| format!("{}..{}", range.start, range.end))),
        ("--size", overrides.size.map(|size| format!("{}x{}", size.width, size.height))),
        ("--max-depth", overrides.max_depth.map(|depth| depth.to_string())),
        ("--seed", overrides.seed.map(|seed| seed.to_string())),
        ("--sampler", overrides.sampler.map(|sampler| sampler.to_string())),
        ("--clamp", overrides.clamp.map(|clamp| clamp.to_string())),
        ("--filter", overrides.filter.map(|filter| filter.to_string())),
        ("--integrator", Some(arguments.integrator.to_string())),
        ("--time-limit", stop.time_limit.map(|seconds| seconds.to_string())),
        ("--noise", stop.noise.map(|noise| noise.to_string())),
        ("--exposure", Some(look.exposure.to_string())),
        ("--tone-mapper", Some(look.tone_mapper.to_string())),
        ("--png-bits", Some(look.png_bits.to_string())),
    ];
    let layers = aov.iter().flat_map(|layers| layers.iter()).map(|layer| ("--aov", Some(layer.to_string())));
    let flags =
        [("--allow-outside", assets.allow_outside), ("--alpha", overrides.alpha), ("--denoise", arguments.denoise)];
    let given = given.into_iter().chain(layers).filter_map(|(name, value)| Some(format!("{name}={}", value?)));
    given.chain(flags.into_iter().filter(|(_, given)| *given).map(|(name, _)| name.to_owned())).collect()
}

/// Words that Python says.
fn words(line: &Value) -> Option<String> {
    let warning = line["warning"].as_str().map(|words| format!("warning: {words}"));
    warning.or_else(|| line["say"].as_str().map(str::to_owned))
}

fn numbers<const N: usize>(list: &Value) -> Option<[f64; N]> {
    let numbers: Vec<f64> = list.as_array()?.iter().filter_map(Value::as_f64).collect();
    numbers.try_into().ok()
}

/// The scene for other machines: its text, and the files that it is made of.
fn sent_scene(path: &Path, arguments: &RenderArguments, assets: &mut Assets) -> Result<Value, Failure> {
    let canonical = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let text = scene_text(path, assets)?;
    let mut files: Vec<_> = assets.all_files().map(PathBuf::from).collect();
    files.sort();
    files.dedup();
    Ok(json!({
        "path": canonical,
        "name": path.file_name().unwrap_or_default().to_string_lossy(),
        "text": text,
        "is_text": !is_model(path),
        "files": files,
        "allow_outside": arguments.assets.allow_outside,
        "time_seconds": arguments.assets.time,
    }))
}

/// Keys of a scene's `[render]`, as texts of TOML.
fn settings(settings: &RenderSettings) -> Value {
    let RenderSettings { width, height, max_depth, seed, sampler, filter, clamp, alpha, .. } = settings;
    let mut keys = json!({
        "width": width.to_string(),
        "height": height.to_string(),
        "max_depth": max_depth.to_string(),
        "seed": seed.to_string(),
        "sampler": format!("\"{sampler}\""),
        "filter": format!("\"{filter}\""),
        "alpha": alpha.to_string(),
    });
    if let Some(clamp) = clamp {
        keys["clamp"] = format!("{clamp:?}").into();
    }
    keys
}

/// Device of each machine: all that it has, unless one is asked for.
fn device(machine: &MachineArguments) -> String {
    if machine.device == DeviceChoice::Auto.into() { "all".into() } else { machine.device.to_string() }
}
