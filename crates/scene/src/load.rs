//! From a file or a text to a [`Scene`].

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Deserialize;

use crate::convert;
use crate::error::SceneError;
use crate::fault::{Fault, Kind, Step};
use crate::file::SceneFile;
use crate::names;
use crate::number::Version;
use crate::reader::Node;
use crate::scene::Scene;
use crate::source::{Document, error_after};

/// Larger files are refused before they are read; text of this size is a few million shapes.
const MOST_BYTES: u64 = 64 << 20;

impl Scene {
    /// Reads and checks a `.toml` scene file.
    ///
    /// # Errors
    /// When the file cannot be read, is larger than 64 MiB, or is not a valid scene.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let text = read_text(path)?;
        Self::parse(&text, &display_name(path))
    }

    /// Reads and checks the text of a scene file; `name` stands for the file in messages.
    ///
    /// # Errors
    /// When the text is not a valid scene.
    pub fn parse(text: &str, name: &str) -> Result<Self, SceneError> {
        let document = Document::parse(text, name)?;
        let read = || convert::scene(scene_file(&document)?);
        let (mut scene, warnings) = read().map_err(|fault| document.error(&fault))?;
        scene.warnings = document.warnings(&warnings);
        Ok(scene)
    }
}

/// The text of a scene file, which [`Scene::parse`] has still to check.
///
/// # Errors
/// When the file cannot be read, is larger than 64 MiB, is a mesh, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, SceneError> {
    let name = display_name(path);
    refuse_meshes(path, &name)?;
    let bytes = read(path).map_err(|message| SceneError::whole_file(&name, message))?;
    utf8(&bytes, &name).map(str::to_string)
}

/// A file as messages name it: control characters are escaped, because messages go to terminals.
pub fn display_name(path: &Path) -> String {
    names::escaped(&path.display().to_string())
}

/// The version comes first: in a file of another version unknown keys are no mistakes.
fn scene_file(document: &Document<'_>) -> Result<SceneFile, Fault> {
    let root = document.root();
    let version = root.get("version");
    let version = version.ok_or_else(|| Fault::new(Kind::MissingKey("version")))?;
    Version::deserialize(Node(version.get_ref())).map_err(|fault| fault.inside(Step::from("version")))?;
    SceneFile::deserialize(Node(root))
}

fn refuse_meshes(path: &Path, name: &str) -> Result<(), SceneError> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if ["glb", "gltf", "ply", "obj"].iter().any(|mesh| extension == *mesh) {
        let message = "triangle meshes are not in this version of raggio: give a `.toml` scene";
        return Err(SceneError::whole_file(name, message));
    }
    Ok(())
}

/// The whole file, or why not.
fn read(path: &Path) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".to_string(),
        _ => format!("cannot be read: {error}"),
    };
    let file = File::open(path).map_err(cannot)?;
    let metadata = file.metadata().map_err(cannot)?;
    if metadata.is_dir() {
        return Err("is a folder: give a `.toml` scene file".to_string());
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
