//! The commands `raggio render` and `raggio demo`: arguments in, a render of the library, words out.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use raggio_render::{
    Aov, Choice, DeviceError, Display, ImageFile, Observer, Picture, PngBits, Progress, RenderRequest, Rendering, Stop,
    UNLIMITED_SAMPLES,
};
use raggio_scene::{Assets, Integrator, Scene, counted, display_name};

use crate::args::{DemoArguments, MachineArguments, Overrides, RenderArguments};
use crate::error::Failure;
use crate::files::{Files, Wanted};
use crate::output::say;
use crate::progress::{End, Reporter};
use crate::stats::Stats;

const SHOWCASE: &str = include_str!("../../../scenes/showcase.toml");

/// Runs `raggio render`.
pub fn render(arguments: &RenderArguments) -> Result<(), Failure> {
    let start = Instant::now();
    let mut assets = Assets::new(arguments.assets.options(arguments.overrides.size));
    let mut scene = Scene::load_with(&arguments.scene, &mut assets)?;
    scene.render.integrator = arguments.integrator;
    let outputs = if arguments.output.is_empty() {
        // The ending is appended, for `a.b.toml` is not to become `a.png`.
        let mut name = arguments.scene.file_stem().unwrap_or_default().to_owned();
        name.push(".png");
        vec![PathBuf::from(name)]
    } else {
        arguments.output.clone()
    };
    let request = RenderRequest {
        name: arguments.scene.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        layers: Aov::ALL.iter().copied().filter(|aov| arguments.aov.iter().any(|named| named.contains(aov))).collect(),
        denoise: arguments.denoise,
        stop: Stop { noise: arguments.stop.noise, time_limit: arguments.stop.time_limit, ..Stop::default() },
        ..RenderRequest::default()
    };
    let display = Display { exposure: arguments.exposure, tone_mapper: arguments.tone_mapper, ..Display::default() };
    let wanted = Wanted {
        pictures: &outputs,
        png_bits: arguments.png_bits,
        display,
        has_layers: !request.layers.is_empty(),
        denoise: request.denoise,
        stats: arguments.stats.as_deref(),
    };
    let inputs: Vec<_> =
        std::iter::once(arguments.scene.as_path()).chain(assets.all_files()).map(PathBuf::from).collect();
    let files = Files::new(&wanted, &inputs)?;
    run(start, scene, request, &files, &arguments.machine, &arguments.overrides)
}

/// Runs `raggio demo`.
pub fn demo(arguments: &DemoArguments) -> Result<(), Failure> {
    let start = Instant::now();
    let mut scene = Scene::parse(SHOWCASE, "showcase.toml")?;
    scene.render.integrator = Integrator::Path;
    let request = RenderRequest { name: "showcase".into(), ..RenderRequest::default() };
    let wanted = Wanted {
        pictures: std::slice::from_ref(&arguments.output),
        png_bits: PngBits::Eight,
        display: Display::default(),
        has_layers: false,
        denoise: false,
        stats: None,
    };
    let files = Files::new(&wanted, &[])?;
    run(start, scene, request, &files, &arguments.machine, &arguments.overrides)
}

fn run(
    start: Instant,
    mut scene: Scene,
    mut request: RenderRequest,
    files: &Files,
    machine: &MachineArguments,
    overrides: &Overrides,
) -> Result<(), Failure> {
    override_settings(&mut scene, overrides);
    request.stop.samples = overrides.samples.map(|samples| 0..samples);
    let warn = |warning: &str| {
        if !machine.quiet {
            say(format_args!("warning: {warning}"));
        }
    };
    scene.warnings.iter().for_each(|warning| warn(warning));
    raggio_render::check_memory(scene.render.width, scene.render.height)?;
    let device = ready(machine.quiet, || raggio_render::open(machine.device, machine.options(), warn))?;
    let stop = request.stop.clone();
    let mut rendering = Rendering::begin(&scene, &*device, request)?;
    ready(machine.quiet, || rendering.prepare())?;
    let setup_seconds = start.elapsed().as_secs_f64();
    let samples = rendering.samples().end;
    // The number of samples is no end to be expected where noise is to end it.
    let expected = if stop.noise.is_none() { samples } else { UNLIMITED_SAMPLES };
    let reporter = Reporter::new(machine.quiet, End { samples: expected, time_limit: stop.time_limit });
    let (width, height) = (scene.render.width, scene.render.height);
    reporter.say(&format!("{width}x{height}, {} on {}", describe_end(samples, &stop), device.name()));

    let mut listener = Listener { reporter, interrupted: on_interrupt(rendering.stop_flag()) };
    let mut rendered = rendering.run(&mut listener)?;
    let Listener { reporter, interrupted } = listener;
    reporter.finish();
    let failure = rendered.failure.take();
    let (picture, progress) = (&rendered.picture, &rendered.progress);
    reporter.report(&picture.film, progress, if rendered.finished { progress.samples } else { samples });
    // One thing that fails is no reason to lose the others.
    let mut outcome = write(picture, &files.pictures, files.display, &reporter);
    if let (Some((denoiser, beside)), None) = (&files.denoised, &failure) {
        reporter.say("denoising");
        let denoised = picture.denoised(denoiser).map_err(Failure::from);
        outcome = both(outcome, denoised.and_then(|picture| write(&picture, beside, files.display, &reporter)));
    }
    if let Some(file) = &files.stats {
        let stats = Stats { device: &device.name(), rendered: &rendered, settings: &scene.render, setup_seconds };
        outcome = both(outcome, stats.write(file));
    }
    both(outcome, failure.map_or(Ok(()), |error| Err(error.into())))?;
    if interrupted.load(Ordering::Relaxed) { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Makes the device ready by `prepare`, and says so where it takes a while: drivers compile kernels then.
fn ready<T>(quiet: bool, prepare: impl FnOnce() -> Result<T, DeviceError>) -> Result<T, DeviceError> {
    const A_WHILE: Duration = Duration::from_secs(1);
    std::thread::scope(|scope| {
        let (done, wait) = channel::<()>();
        scope.spawn(move || {
            if !quiet && wait.recv_timeout(A_WHILE) == Err(RecvTimeoutError::Timeout) {
                say("compiling kernels (first time on this device)");
            }
        });
        let prepared = prepare();
        drop(done);
        prepared
    })
}

/// Writes a picture to all of `files`.
///
/// # Errors
/// The last failure; those before it are told, and the other files are written nevertheless.
fn write(picture: &Picture, files: &[ImageFile], display: Display, reporter: &Reporter) -> Result<(), Failure> {
    let mut outcome = Ok(());
    for file in files {
        match picture.write(file, display) {
            Ok(()) => reporter.say(&format!("wrote {}", display_name(file.path()))),
            Err(error) => outcome = both(outcome, Err(error.into())),
        }
    }
    outcome
}

/// The last failure of two outcomes; one before another is told at once.
fn both(first: Result<(), Failure>, second: Result<(), Failure>) -> Result<(), Failure> {
    match (first, second) {
        (Err(first), Err(second)) => {
            say(format_args!("error: {first}"));
            Err(second)
        }
        (first, second) => first.and(second),
    }
}

/// Reports progress, and breaks off when the user has interrupted.
struct Listener {
    reporter: Reporter,
    interrupted: Arc<AtomicBool>,
}

impl Observer for Listener {
    fn warn(&mut self, warning: &str) {
        self.reporter.say(&format!("warning: {warning}"));
    }

    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        self.reporter.update(progress);
        if self.interrupted.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

fn override_settings(scene: &mut Scene, overrides: &Overrides) {
    let Overrides { samples, size, max_depth, seed, sampler, filter, clamp, foreign: _ } = *overrides;
    let render = &mut scene.render;
    render.samples = samples.unwrap_or(render.samples);
    render.max_depth = max_depth.unwrap_or(render.max_depth);
    render.seed = seed.unwrap_or(render.seed);
    render.sampler = sampler.unwrap_or(render.sampler);
    render.filter = filter.unwrap_or(render.filter);
    render.clamp = clamp.or(render.clamp);
    if let Some(size) = size {
        (render.width, render.height) = (size.width, size.height);
    }
}

/// End of the render that is asked for, in words.
fn describe_end(samples: u32, stop: &Stop) -> String {
    let limits = [
        (samples < UNLIMITED_SAMPLES).then(|| counted(samples as usize, "sample")),
        stop.noise.map(|noise| format!("an error below {noise}")),
        stop.time_limit.map(|seconds| format!("{seconds} s")),
    ];
    limits.into_iter().flatten().collect::<Vec<_>>().join(" or ")
}

/// Flag that the first Ctrl-C (or termination signal) sets, and `stop` with it; the second ends the program at once.
fn on_interrupt(stop: Arc<AtomicBool>) -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let seen = interrupted.clone();
    // Without a handler Ctrl-C still works, it only keeps nothing.
    let _ = ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            raggio_render::abandon_files();
            std::process::exit(130);
        }
        stop.store(true, Ordering::Relaxed);
    });
    interrupted
}
