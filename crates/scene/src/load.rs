//! Scenes from files or texts.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use raggio_choice::endings;
use raggio_models::Format;

use crate::assets::{Assets, is_model};
use crate::convert;
use crate::error::SceneError;
use crate::fault::{Fault, Step};
use crate::file::SceneFile;
use crate::names::display_name;
use crate::number::Version;
use crate::reader;
use crate::review::Review;
use crate::scene::Scene;
use crate::showing;
use crate::source::{Document, error_after, summed_up};

/// Most bytes of a scene file: larger ones are refused before they are read; text of this size is a few million shapes.
const MOST_BYTES: u64 = 64 << 20;

impl Scene {
    /// Reads and checks a `.toml` scene file, or shows a model.
    ///
    /// # Errors
    /// The errors are those of [`Scene::load_with`].
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::load_with(path, &mut Assets::default())
    }

    /// Reads and checks a `.toml` scene file, or shows a model; afterwards `assets` has the files that it needs.
    ///
    /// # Errors
    /// When the file, or one that it names, cannot be read, is too large, or is not valid.
    pub fn load_with(path: &Path, assets: &mut Assets) -> Result<Self, SceneError> {
        let text = scene_text(path, assets)?;
        let name = display_name(path);
        let (mut scene, mut warnings, document) = read_scene(&text, &name, path, assets)?;
        scene.warnings = if is_model(path) {
            // Nobody has seen the text of a model's scene, so neither its camera nor its lines are worth naming.
            warnings.retain(|warning| warning.path().first() != Some(&Step::from("camera")));
            summed_up(&warnings, &name, |warning| warning.sentence(""))
        } else {
            document.warnings(&warnings)
        };
        Ok(scene)
    }

    /// Reads and checks the text of a scene file that needs no other file, or few; `name` stands for the file in messages,
    /// and the paths in the text are relative to its folder.
    ///
    /// # Errors
    /// When the text is not a valid scene.
    pub fn parse(text: &str, name: &str) -> Result<Self, SceneError> {
        Self::parse_with(text, Path::new(name), &mut Assets::default())
    }

    /// Reads and checks the text of a scene file that is, or would be, at `path`; afterwards `assets` has the files
    /// that the scene is made of.
    ///
    /// # Errors
    /// When the text is not a valid scene, or a file that it names cannot be read or is not valid.
    pub fn parse_with(text: &str, path: &Path, assets: &mut Assets) -> Result<Self, SceneError> {
        let name = display_name(path);
        let (mut scene, warnings, document) = read_scene(text, &name, path, assets)?;
        scene.warnings = document.warnings(&warnings);
        Ok(scene)
    }
}

fn read_scene<'a>(
    text: &'a str,
    name: &'a str,
    path: &Path,
    assets: &mut Assets,
) -> Result<(Scene, Vec<Fault>, Document<'a>), SceneError> {
    let document = Document::parse(text, name)?;
    check_version(&document)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let review = Review::default();
    let file: Option<SceneFile> = reader::read(document.root(), &review);
    let scene = file.as_ref().map(|file| convert::scene(file, folder, assets, &review));
    match scene {
        Some((scene, warnings)) if review.count() == 0 => {
            assets.sweep();
            Ok((scene, warnings, document))
        }
        _ => {
            let is_whole = scene.is_some() && !review.is_full();
            let count = review.count();
            let faults = review.into_faults();
            Err(document.errors(&faults, is_whole.then(|| count - faults.len())))
        }
    }
}

/// The text of a scene file, which [`Scene::parse_with`] has still to check; for a model, that of a scene that shows it
/// with a camera, a ground and a sky. Paths in it are relative to the folder of `path`.
///
/// # Errors
/// When the file cannot be read, is not UTF-8 (a scene), is not valid or without triangles (a model), or is too large.
pub fn scene_text(path: &Path, assets: &mut Assets) -> Result<String, SceneError> {
    if is_model(path) {
        return showing::text(path, assets);
    }
    let name = display_name(path);
    if assets.options().camera.is_some() {
        let message = "has the one camera of its table [camera]: cameras are chosen by name among those of a model";
        return Err(SceneError::whole_file(&name, message));
    }
    let bytes = read(path);
    if has_foreign_ending(path) && path.is_file() && !bytes.as_ref().is_ok_and(|bytes| names_version(bytes)) {
        let models = endings::<Format>();
        let message =
            format!("is neither a scene nor a model that can be read: give a .toml scene or a {models} model");
        return Err(SceneError::whole_file(&name, message));
    }
    let bytes = bytes.map_err(|message| SceneError::whole_file(&name, message))?;
    utf8(&bytes, &name).map(str::to_string)
}

/// Whether the file is not called as scenes are.
fn has_foreign_ending(path: &Path) -> bool {
    path.extension().is_some_and(|extension| !extension.eq_ignore_ascii_case("toml"))
}

/// Whether a line sets `version`, as one of every scene does.
fn names_version(bytes: &[u8]) -> bool {
    bytes.split(|byte| *byte == b'\n').any(|line| {
        let rest = line.trim_ascii_start().strip_prefix(b"version");
        rest.is_some_and(|rest| rest.trim_ascii_start().starts_with(b"="))
    })
}

/// Checks the version before all else: in a file of another version unknown keys are no mistakes.
fn check_version(document: &Document<'_>) -> Result<(), SceneError> {
    let Some(version) = document.root().get("version") else { return Ok(()) };
    reader::read_alone::<Version>(version.get_ref()).map(drop).map_err(|fault| {
        let fault = fault.inside(Step::from("version"));
        document.errors(&[fault], Some(0))
    })
}

/// Bytes of the whole file, or the reason why it cannot be read.
fn read(path: &Path) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_string(),
        _ => format!("cannot be read: {error}"),
    };
    let file = File::open(path).map_err(cannot)?;
    let metadata = file.metadata().map_err(cannot)?;
    if metadata.is_dir() {
        return Err("is a folder: give a `.toml` scene file or a model".to_string());
    }
    let too_large = || Err("is larger than 64 MiB, the most a scene file may have".to_string());
    if metadata.len() > MOST_BYTES {
        return too_large();
    }
    // Devices and pipes have no length, so the limit is checked again while reading.
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > MOST_BYTES { too_large() } else { Ok(bytes) }
}

fn utf8<'a>(bytes: &'a [u8], name: &str) -> Result<&'a str, SceneError> {
    std::str::from_utf8(bytes).map_err(|error| {
        let (valid, rest) = bytes.split_at(error.valid_up_to());
        let byte = rest.first().copied().unwrap_or_default();
        let message = format!("the byte 0x{byte:02x} is not valid UTF-8: save the file as UTF-8");
        error_after(&String::from_utf8_lossy(valid), name, message)
    })
}
