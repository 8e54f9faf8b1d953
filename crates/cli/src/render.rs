//! The commands `raggio render` and `raggio demo`.

use std::path::PathBuf;
use std::time::Instant;

use raggio_render::{Display, PictureFormat, PngBits, RenderRequest};
use raggio_scene::{Assets, Integrator, Scene};

use crate::args::{DemoArguments, RenderArguments};
use crate::cluster;
use crate::error::Failure;
use crate::files::{Files, Wanted, denoiser};
use crate::opening::Opening;
use crate::order::{checkpoints, request, wanted};
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
    let opens = if arguments.cluster.is_none() { Opening::begin } else { Opening::later };
    let opening = opens(&arguments.machine);
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
    let job = Job { start, scene, request, files: &files, denoiser, machine, opening, overrides, progress };
    match &arguments.cluster {
        Some(address) => cluster::run(job, address, arguments, &mut assets),
        None => run(job),
    }
}

/// Runs `raggio demo`.
pub fn demo(arguments: &DemoArguments) -> Result<(), Failure> {
    let start = Instant::now();
    let opening = Opening::begin(&arguments.machine);
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
    run(Job { start, scene, request, files: &files, denoiser: None, machine, opening, overrides, progress })
}
