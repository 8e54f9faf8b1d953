use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use raggio_render::{Aov, DeviceScene, Display, Extras, Features, Film, ImageFile, Metadata, Progress, Renderer};
use raggio_scene::{Assets, Scene};

use crate::args::{DemoArguments, Integrator, MachineArguments, Overrides, RenderArguments, StopArguments};
use crate::denoise::Denoising;
use crate::error::{Failure, cannot_write};
use crate::output::say;
use crate::progress::{Reporter, duration, millions};
use crate::stats::Stats;

/// Samples a pixel of a render that stops by its noise alone, in case it never does.
const MOST_ADAPTIVE_SAMPLES: u32 = 65536;
/// Samples a pixel of layers and guides: their noise is that of edges alone.
const MOST_FEATURE_SAMPLES: u64 = 1024;
/// Seconds; what is shorter costs more than it brings.
const SHORTEST_PORTION: f64 = 0.005;

const SHOWCASE: &str = include_str!("../../../scenes/showcase.toml");

/// `raggio render`.
pub fn render(arguments: &RenderArguments) -> Result<(), Failure> {
    let mut assets = Assets::new(arguments.assets.options(arguments.overrides.size));
    let scene = Scene::load_with(&arguments.scene, &mut assets)?;
    let outputs = if arguments.output.is_empty() {
        // Appended, for `a.b.toml` is not to become `a.png`.
        let mut name = arguments.scene.file_stem().unwrap_or_default().to_owned();
        name.push(".png");
        vec![PathBuf::from(name)]
    } else {
        arguments.output.clone()
    };
    let display =
        Display { exposure: arguments.exposure, tone_mapper: arguments.tone_mapper.into(), ..Display::default() };
    let aovs: Vec<Aov> = arguments.aov.iter().flat_map(|name| name.aovs()).copied().collect();
    let job = Job {
        name: arguments.scene.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        outputs: &outputs,
        aovs: Aov::ALL.into_iter().filter(|aov| aovs.contains(aov)).collect(),
        denoise: arguments.denoise,
        stop: arguments.stop,
        display,
        stats: arguments.stats.as_deref(),
        machine: &arguments.machine,
        overrides: &arguments.overrides,
        integrator: arguments.integrator,
    };
    job.run(scene)
}

/// `raggio demo`.
pub fn demo(arguments: &DemoArguments) -> Result<(), Failure> {
    let scene = Scene::parse(SHOWCASE, "showcase.toml")?;
    let job = Job {
        name: "showcase".into(),
        aovs: vec![],
        denoise: false,
        stop: StopArguments::default(),
        outputs: std::slice::from_ref(&arguments.output),
        display: Display::default(),
        stats: None,
        machine: &arguments.machine,
        overrides: &arguments.overrides,
        integrator: Integrator::Path,
    };
    job.run(scene)
}

/// A scene on its way to its files.
struct Job<'a> {
    name: String,
    aovs: Vec<Aov>,
    denoise: bool,
    stop: StopArguments,
    outputs: &'a [PathBuf],
    display: Display,
    stats: Option<&'a Path>,
    machine: &'a MachineArguments,
    overrides: &'a Overrides,
    integrator: Integrator,
}

impl Job<'_> {
    fn run(&self, mut scene: Scene) -> Result<(), Failure> {
        let start = Instant::now();
        // What can fail early fails before any time is spent.
        let files = self.files()?;
        let denoiser = if self.denoise { Some(Denoising::begin(&files)?) } else { None };
        if let Some(path) = self.stats {
            raggio_render::check_writable(path).map_err(|e| cannot_write(path, &e))?;
        }
        self.override_settings(&mut scene);
        raggio_render::check_memory(scene.render.width, scene.render.height)?;
        let warn = |warning: &str| {
            if !self.machine.quiet {
                say(format_args!("warning: {warning}"));
            }
        };
        scene.warnings.iter().for_each(|warning| warn(warning));

        let device_scene = DeviceScene::new(&scene)?;
        let device = raggio_render::open(self.machine.device, self.machine.options(), warn)?;
        let session = device.load(&device_scene)?;
        let settings = &scene.render;
        let mut renderer = Renderer::new(session, &device_scene, 0..settings.samples);
        if let Some(noise) = self.stop.noise {
            renderer.set_noise(noise.into());
        }
        // How long it takes until the noise is low, nobody knows.
        let known = self.stop.noise.is_none();
        let mut reporter = Reporter::new(self.machine.quiet, if known { settings.samples } else { i32::MAX as u32 });
        let device_name = device.name();
        let until = describe_end(settings.samples, self.stop);
        reporter.say(&format!("{}x{}, {until} on {device_name}", settings.width, settings.height));
        let setup_seconds = start.elapsed().as_secs_f64();

        let interrupted = on_interrupt();
        let (progress, film, fault) = sample(&mut renderer, &mut reporter, &interrupted, self.stop)?;
        let target = if renderer.finished() { progress.samples } else { settings.samples };
        report(&reporter, &film, &progress, target);
        // One that cannot be written is no reason to lose the others.
        let mut outcome = fault.map_or(Ok(()), Err);
        let mut extras = Extras { channels: vec![], metadata: Some(self.metadata(&scene, &film)) };
        let features = match (&outcome, self.features(&mut renderer, &interrupted, &film)) {
            (Ok(()), Ok(features)) => Some(features),
            (Err(_), _) => None,
            (Ok(()), Err(error)) => {
                outcome = Err(error);
                None
            }
        };
        if let Some(features) = &features {
            extras.channels = self.aovs.iter().flat_map(|aov| aov.channels(&film, features, &device_scene)).collect();
        }
        for file in &files {
            match file.write_with(&film, self.display, &extras) {
                Ok(()) => reporter.say(&format!("wrote {}", file.path().display())),
                Err(error) => outcome = outcome.and(Err(error.into())),
            }
        }
        if let (Some(denoiser), Some(features)) = (&denoiser, &features) {
            outcome = outcome.and(denoiser.write(&reporter, &film, features, self.display, extras));
        }
        if let Some(path) = self.stats {
            let (shapes, triangles) = (device_scene.shapes(), device_scene.triangles());
            let (device, film, max_depth) = (&*device_name, &film, settings.max_depth);
            let stats = Stats { device, film, progress, max_depth, setup_seconds, shapes, triangles };
            outcome = outcome.and(stats.write(path));
        }
        outcome
    }

    fn files(&self) -> Result<Vec<ImageFile>, Failure> {
        let files = self.outputs.iter().map(|path| ImageFile::new(path)).collect::<Result<Vec<_>, _>>()?;
        if !self.aovs.is_empty() && !files.iter().any(ImageFile::has_layers) {
            return Err(Failure::Input("--aov writes layers, which only .exr has: name one with -o".into()));
        }
        Ok(files)
    }

    /// What the layers and the denoiser need to know of first surfaces.
    fn features(&self, renderer: &mut Renderer, interrupted: &AtomicBool, film: &Film) -> Result<Features, Failure> {
        let guides: &[_] = if self.denoise { &Features::GUIDES } else { &[] };
        let wanted: Vec<_> = self.aovs.iter().flat_map(|aov| aov.features()).chain(guides).copied().collect();
        // The mean number, where parts of the picture have more than others; an early end ends these films early too.
        let samples = (film.samples() / film.pixels().len() as u64).clamp(1, MOST_FEATURE_SAMPLES) as u32;
        let proceed =
            || if interrupted.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        Ok(Features::render(renderer, &wanted, samples, proceed)?)
    }

    fn metadata(&self, scene: &Scene, film: &Film) -> Metadata {
        let samples = film.pixels().iter().map(|pixel| pixel.samples).max().unwrap_or(0);
        let mut metadata = Metadata::new(scene, &self.name, self.integrator.name());
        metadata.samples = samples;
        metadata
    }

    fn override_settings(&self, scene: &mut Scene) {
        let Overrides { samples, size, max_depth, seed, sampler, filter, clamp } = *self.overrides;
        let render = &mut scene.render;
        render.samples = samples.unwrap_or(match self.stop {
            StopArguments { noise: Some(_), .. } => MOST_ADAPTIVE_SAMPLES,
            StopArguments { time_limit: Some(_), .. } => i32::MAX as u32,
            _ => render.samples,
        });
        render.max_depth = max_depth.unwrap_or(render.max_depth);
        render.seed = seed.unwrap_or(render.seed);
        render.integrator = self.integrator.into();
        render.sampler = sampler.map_or(render.sampler, Into::into);
        render.filter = filter.map_or(render.filter, Into::into);
        render.clamp = clamp.or(render.clamp);
        if let Some(size) = size {
            (render.width, render.height) = (size.width, size.height);
        }
    }
}

/// What is asked for, in words.
fn describe_end(samples: u32, stop: StopArguments) -> String {
    let limits = [
        (samples < i32::MAX as u32).then(|| format!("{samples} samples")),
        stop.noise.map(|noise| format!("an error below {noise}")),
        stop.time_limit.map(|seconds| format!("{seconds} s")),
    ];
    limits.into_iter().flatten().collect::<Vec<_>>().join(" or ")
}

/// Samples until done, interrupted, or the device fails; in each case returns what there is.
fn sample(
    renderer: &mut Renderer,
    reporter: &mut Reporter,
    interrupted: &AtomicBool,
    stop: StopArguments,
) -> Result<(Progress, Film, Option<Failure>), Failure> {
    let start = Instant::now();
    let left = || stop.time_limit.map_or(f64::INFINITY, |limit| f64::from(limit) - start.elapsed().as_secs_f64());
    let mut fault = None;
    while !renderer.finished() && !interrupted.load(Ordering::Relaxed) && left() > 0.0 {
        match renderer.advance_for(left().max(SHORTEST_PORTION)) {
            Ok(progress) => reporter.update(&progress),
            Err(error) => {
                fault = Some(Failure::from(error));
                break;
            }
        }
    }
    reporter.finish();
    // A lost device has usually lost the film with it: then its first failure is what to report.
    match (renderer.film(), fault) {
        (Ok(film), fault) => Ok((renderer.progress(), film, fault)),
        (Err(_), Some(fault)) => Err(fault),
        (Err(error), None) => Err(error.into()),
    }
}

/// Set by the first Ctrl-C (or termination signal); the second ends the program at once.
fn on_interrupt() -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let seen = interrupted.clone();
    // Without a handler Ctrl-C still works, it only keeps nothing.
    let _ = ctrlc::set_handler(move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
    interrupted
}

fn report(reporter: &Reporter, film: &Film, progress: &Progress, target: u32) {
    if film.rejected() > 0 {
        reporter.say(&format!(
            "warning: {} samples had no finite value, or more than {} dielectrics overlapped there; they were left out",
            film.rejected(),
            raggio_render::MAX_NESTED_MEDIA
        ));
    }
    if film.clamped_share() > 0.0 {
        reporter.say(&format!("clamping took {:.2} % of the light off", 100.0 * film.clamped_share()));
    }
    let (fewest, most) = film.sample_range();
    if most > fewest + 1 {
        let mean = film.samples() as f64 / film.pixels().len() as f64;
        reporter.say(&format!("{fewest} to {most} samples per pixel, {mean:.1} on average"));
    } else if progress.samples < target {
        let of =
            if target < i32::MAX as u32 { format!("stopped early: {fewest} of {target}") } else { fewest.to_string() };
        reporter.say(&format!("{of} samples per pixel"));
    }
    let seconds = progress.seconds.max(1e-9);
    reporter.say(&format!(
        "{} samples, {} rays in {}: {} samples/s, {} rays/s",
        millions(progress.total_samples as f64),
        millions(film.rays() as f64),
        duration(progress.seconds),
        millions(progress.total_samples as f64 / seconds),
        millions(film.rays() as f64 / seconds),
    ));
}
