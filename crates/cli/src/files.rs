//! Files that the program writes, and what they must not replace.

use std::path::{Path, PathBuf};

use raggio_render::{Denoiser, Display, ImageFile, OutputFile, PngBits};
use raggio_scene::display_name;

use crate::error::{Failure, cannot_write};

/// Files to write. What can fail early fails before any time is spent.
pub struct Files {
    pub pictures: Vec<ImageFile>,
    /// A file beside each of `pictures` for what is left without its noise, if that is asked for.
    pub denoised: Vec<ImageFile>,
    pub display: Display,
    pub stats: Option<OutputFile>,
}

/// Files that are asked for.
pub struct Wanted<'a> {
    pub pictures: &'a [PathBuf],
    pub png_bits: PngBits,
    pub display: Display,
    pub has_layers: bool,
    pub denoise: bool,
    pub stats: Option<&'a Path>,
    pub checkpoint: Option<&'a Path>,
}

impl Files {
    /// Finds out whether all can be written without taking the place of one another or of one of `inputs`.
    pub fn new(wanted: &Wanted, inputs: &[PathBuf]) -> Result<Self, Failure> {
        let picture = |path: &PathBuf| Ok(ImageFile::new(path)?.with_png_bits(wanted.png_bits).with_refuge(here()));
        let pictures = wanted.pictures.iter().map(picture).collect::<Result<Vec<_>, Failure>>()?;
        if wanted.has_layers && !pictures.iter().any(ImageFile::has_layers) {
            return Err(Failure::Input("--aov writes layers, which only .exr has: name one with -o".into()));
        }
        let beside = if wanted.denoise {
            let beside = pictures.iter().filter(|file| !file.is_film());
            let beside =
                beside.map(|file| Ok(file.denoised()?.with_refuge(here()))).collect::<Result<Vec<_>, Failure>>()?;
            if beside.is_empty() {
                return Err(Failure::Input(
                    "--denoise makes pictures, and a film is none: name a .png or .exr with -o".into(),
                ));
            }
            beside
        } else {
            vec![]
        };
        let stats = wanted.stats.map(output_file).transpose()?;
        let checkpoint = wanted.checkpoint.map(output_file).transpose()?;
        let pictured = pictures.iter().chain(&beside).map(ImageFile::file);
        let files: Vec<_> = pictured.chain(&stats).chain(&checkpoint).cloned().collect();
        check_apart(&files, inputs)?;
        Ok(Self { pictures, denoised: beside, display: wanted.display, stats })
    }
}

/// The denoiser, if it is `wanted`.
pub fn denoiser(wanted: bool) -> Result<Option<Denoiser>, Failure> {
    Ok(if wanted { Some(Denoiser::open()?) } else { None })
}

/// A file other than a picture, which can be written to.
pub fn output_file(path: &Path) -> Result<OutputFile, Failure> {
    let file = OutputFile::new(path).map_err(|e| cannot_write(path, &e))?;
    Ok(file.with_refuge(here()))
}

/// The current folder, the refuge of all files.
fn here() -> &'static Path {
    Path::new(".")
}

/// Checks that no file takes the place of another or of an input, by whatever names and links they are called.
pub fn check_apart(files: &[OutputFile], inputs: &[PathBuf]) -> Result<(), Failure> {
    // Devices take any number of files.
    let placed: Vec<_> = files.iter().filter_map(|file| Some((file, file.place()?))).collect();
    for (i, (file, place)) in placed.iter().enumerate() {
        let path = file.path();
        file.check_apart(inputs.iter().map(PathBuf::as_path)).map_err(|e| cannot_write(path, &e))?;
        if let Some((other, _)) = placed[..i].iter().find(|(_, taken)| taken == place) {
            let [path, other] = [path, other.path()].map(display_name);
            return Err(Failure::Input(format!("cannot write {path}: it would replace what goes to {other}")));
        }
    }
    Ok(())
}
