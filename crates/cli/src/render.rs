use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use raggio_render::{DeviceScene, Display, Film, ImageFile, Progress, Renderer};
use raggio_scene::{Assets, Scene};

use crate::args::{DemoArguments, MachineArguments, Overrides, RenderArguments};
use crate::error::{Failure, cannot_write};
use crate::output::say;
use crate::progress::{Reporter, duration, millions};
use crate::stats::Stats;

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
    let job = Job {
        outputs: &outputs,
        display,
        stats: arguments.stats.as_deref(),
        machine: &arguments.machine,
        overrides: &arguments.overrides,
    };
    job.run(scene)
}

/// `raggio demo`.
pub fn demo(arguments: &DemoArguments) -> Result<(), Failure> {
    let scene = Scene::parse(SHOWCASE, "showcase.toml")?;
    let job = Job {
        outputs: std::slice::from_ref(&arguments.output),
        display: Display::default(),
        stats: None,
        machine: &arguments.machine,
        overrides: &arguments.overrides,
    };
    job.run(scene)
}

/// A scene on its way to its files.
struct Job<'a> {
    outputs: &'a [PathBuf],
    display: Display,
    stats: Option<&'a Path>,
    machine: &'a MachineArguments,
    overrides: &'a Overrides,
}

impl Job<'_> {
    fn run(&self, mut scene: Scene) -> Result<(), Failure> {
        let start = Instant::now();
        // What can fail early fails before any time is spent.
        let files = self.outputs.iter().map(|path| ImageFile::new(path)).collect::<Result<Vec<_>, _>>()?;
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
        let mut renderer = Renderer::new(session, settings.width, settings.height, settings.samples);
        let mut reporter = Reporter::new(self.machine.quiet, settings.samples);
        let device_name = device.name();
        reporter.say(&format!("{}x{}, {} samples on {device_name}", settings.width, settings.height, settings.samples));
        let setup_seconds = start.elapsed().as_secs_f64();

        let (progress, film, fault) = sample(&mut renderer, &mut reporter)?;
        report(&reporter, &film, &progress, settings.samples);
        // One that cannot be written is no reason to lose the others.
        let mut outcome = fault.map_or(Ok(()), Err);
        for file in &files {
            match file.write(&film, self.display) {
                Ok(()) => reporter.say(&format!("wrote {}", file.path().display())),
                Err(error) => outcome = outcome.and(Err(error.into())),
            }
        }
        if let Some(path) = self.stats {
            let (shapes, triangles) = (device_scene.shapes(), device_scene.triangles());
            let (device, film, max_depth) = (&*device_name, &film, settings.max_depth);
            let stats = Stats { device, film, progress, max_depth, setup_seconds, shapes, triangles };
            outcome = outcome.and(stats.write(path));
        }
        outcome
    }

    fn override_settings(&self, scene: &mut Scene) {
        let Overrides { samples, size, max_depth, seed, sampler, filter, clamp } = *self.overrides;
        let render = &mut scene.render;
        render.samples = samples.unwrap_or(render.samples);
        render.max_depth = max_depth.unwrap_or(render.max_depth);
        render.seed = seed.unwrap_or(render.seed);
        render.sampler = sampler.map_or(render.sampler, Into::into);
        render.filter = filter.map_or(render.filter, Into::into);
        render.clamp = clamp.or(render.clamp);
        if let Some(size) = size {
            (render.width, render.height) = (size.width, size.height);
        }
    }
}

/// Samples until done, interrupted, or the device fails; in each case returns what there is.
fn sample(renderer: &mut Renderer, reporter: &mut Reporter) -> Result<(Progress, Film, Option<Failure>), Failure> {
    let interrupted = on_interrupt();
    let mut fault = None;
    while !renderer.finished() && !interrupted.load(Ordering::Relaxed) {
        match renderer.advance() {
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
        say(format_args!(
            "warning: {} samples had no finite value, or more than {} dielectrics overlapped there; they were left out",
            film.rejected(),
            raggio_render::MAX_NESTED_MEDIA
        ));
    }
    if progress.samples < target {
        reporter.say(&format!("stopped early: {} of {target} samples per pixel", progress.samples));
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
