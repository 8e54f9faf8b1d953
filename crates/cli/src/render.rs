//! The commands `raggio render` and `raggio demo`: arguments in, a request to the library out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use raggio_render::{Aov, Checkpoints, Choice, Display, OutputFile, PictureFormat, PngBits, RenderRequest, Stop};
use raggio_scene::{Assets, Integrator, Scene};

use crate::args::{CheckpointArguments, DemoArguments, RenderArguments};
use crate::error::Failure;
use crate::files::{Files, Wanted, denoiser};
use crate::progress::ProgressStyle;
use crate::run::{Job, run};
use crate::sequence;

const SHOWCASE: &str = include_str!("../../../scenes/showcase.toml");

/// Runs `raggio render`.
pub fn render(arguments: &RenderArguments) -> Result<(), Failure> {
    let start = Instant::now();
    if !arguments.machine.quiet {
        arguments.progress.speak();
    }
    if let Some(frames) = &arguments.frames.frames {
        return sequence::render(arguments, frames, start);
    }
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
    let mut request = request(arguments, &outputs);
    let wanted = wanted(arguments, &outputs, arguments.stats.as_deref(), arguments.checkpoints.checkpoint.as_deref());
    let inputs: Vec<_> =
        std::iter::once(arguments.scene.as_path()).chain(assets.all_files()).map(PathBuf::from).collect();
    let files = Files::new(&wanted, &inputs)?;
    let denoiser = denoiser(request.denoise)?;
    request.checkpoints = checkpoints(&arguments.checkpoints, wanted.checkpoint, &files, &arguments.scene);
    let (machine, overrides) = (&arguments.machine, &arguments.overrides);
    let (denoiser, progress) = (denoiser.as_ref(), arguments.progress);
    run(Job { start, scene, request, files: &files, denoiser, machine, overrides, progress })
}

/// Request for pictures in `outputs`, but for their samples and checkpoints.
pub fn request(arguments: &RenderArguments, outputs: &[PathBuf]) -> RenderRequest {
    RenderRequest {
        name: arguments.scene.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        layers: Aov::ALL.iter().copied().filter(|aov| arguments.aov.iter().any(|named| named.contains(aov))).collect(),
        denoise: arguments.denoise,
        label: outputs.iter().any(|path| PictureFormat::of_path(path) == Some(PictureFormat::Film)),
        stop: Stop { noise: arguments.stop.noise, time_limit: arguments.stop.time_limit, ..Stop::default() },
        ..RenderRequest::default()
    }
}

/// Files that are asked for: pictures in `outputs`, figures and a checkpoint.
pub fn wanted<'a>(
    arguments: &RenderArguments,
    outputs: &'a [PathBuf],
    stats: Option<&'a Path>,
    checkpoint: Option<&'a Path>,
) -> Wanted<'a> {
    let look = &arguments.look;
    Wanted {
        pictures: outputs,
        png_bits: look.png_bits,
        display: Display { exposure: look.exposure, tone_mapper: look.tone_mapper, ..Display::default() },
        has_layers: !arguments.aov.is_empty(),
        denoise: arguments.denoise,
        stats,
        checkpoint,
    }
}

/// Runs `raggio demo`.
pub fn demo(arguments: &DemoArguments) -> Result<(), Failure> {
    let start = Instant::now();
    let mut scene = Scene::parse(SHOWCASE, "showcase.toml")?;
    scene.render.integrator = Integrator::Path;
    let request = RenderRequest {
        name: "showcase".into(),
        label: PictureFormat::of_path(&arguments.output) == Some(PictureFormat::Film),
        ..RenderRequest::default()
    };
    let wanted = Wanted {
        pictures: std::slice::from_ref(&arguments.output),
        png_bits: PngBits::Eight,
        display: Display::default(),
        has_layers: false,
        denoise: false,
        stats: None,
        checkpoint: None,
    };
    let files = Files::new(&wanted, &[])?;
    let (machine, overrides) = (&arguments.machine, &arguments.overrides);
    let progress = ProgressStyle::Auto;
    run(Job { start, scene, request, files: &files, denoiser: None, machine, overrides, progress })
}

/// Checkpoints that are asked for, or those beside the first output that has a place, else in the current folder.
pub fn checkpoints(
    arguments: &CheckpointArguments,
    wanted: Option<&Path>,
    files: &Files,
    scene: &Path,
) -> Option<Checkpoints> {
    let CheckpointArguments { checkpoint: _, checkpoint_every, no_checkpoint, resume } = arguments;
    if *no_checkpoint {
        return None;
    }
    let mut checkpoints = match wanted {
        Some(path) => Checkpoints { path: path.into(), only_long: false, ..Checkpoints::beside(path) },
        None => {
            let placed = files.pictures.iter().find(|file| file.file().place().is_some());
            let beside = placed.map_or(Path::new(scene.file_stem().unwrap_or_default()), |file| file.path());
            let checkpoints = Checkpoints::beside(beside);
            // Nobody has asked for them, so that they are no reason to refuse a render.
            OutputFile::new(&checkpoints.path).ok()?;
            checkpoints
        }
    };
    checkpoints.every = checkpoint_every.unwrap_or(checkpoints.every);
    checkpoints.only_long &= checkpoint_every.is_none();
    checkpoints.resume = *resume;
    Some(checkpoints)
}
