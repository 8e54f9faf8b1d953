//! Orders of `raggio render`: its arguments as a request to the library, files and checkpoints.

use std::path::{Path, PathBuf};

use raggio_render::{Aov, Checkpoints, Choice, Display, OutputFile, PictureFormat, RenderRequest, Stop};

use crate::args::{CheckpointArguments, RenderArguments};
use crate::files::{Files, Wanted};

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
