//! From a path to a model: the format by its extension, the bytes under a limit, and the libraries next to an OBJ.

use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use crate::error::{Fault, MeshError};
use crate::mesh::Model;
use crate::text::escaped;
use crate::{parse_mtl, parse_obj, parse_ply, parse_stl};

/// Larger mesh files are refused before they are read.
pub const MOST_BYTES: u64 = 4 << 30;

/// Larger material libraries are refused before they are read.
const MOST_LIBRARY_BYTES: u64 = 16 << 20;
/// More libraries than this are not opened.
const MOST_LIBRARIES: usize = 64;

/// A format of mesh files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Polygon File Format, ascii or binary.
    Ply,
    /// Stereolithography, ascii or binary.
    Stl,
    /// Wavefront OBJ.
    Obj,
}

impl Format {
    /// By the extension, in any case.
    pub fn of_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            _ => None,
        }
    }
}

/// Reads a mesh file of at most [`MOST_BYTES`].
///
/// # Errors
/// When the file cannot be read, is too large, or is not a valid mesh.
pub fn load(path: &Path) -> Result<Model, MeshError> {
    load_within(path, MOST_BYTES)
}

/// Reads a mesh file of at most `most_bytes`, and the material libraries next to an OBJ; a library that cannot be
/// read is a warning.
///
/// # Errors
/// When the file cannot be read, is too large, or is not a valid mesh.
pub fn load_within(path: &Path, most_bytes: u64) -> Result<Model, MeshError> {
    let name = escaped(&path.display().to_string());
    let fault = |message: String| Fault::whole(message).of(&name);
    let format = Format::of_path(path);
    let format = format.ok_or_else(|| fault("is not a mesh file: give a .ply, .stl or .obj".to_string()))?;
    let bytes = read(path, most_bytes).map_err(fault)?;
    let mut model = parse(format, &bytes, &name)?;
    drop(bytes);
    load_libraries(&mut model, path.parent().unwrap_or(Path::new("")));
    Ok(model)
}

/// Reads the bytes of a mesh file; `name` stands for the file in messages.
///
/// # Errors
/// When the bytes are not a valid mesh.
pub fn parse(format: Format, bytes: &[u8], name: &str) -> Result<Model, MeshError> {
    match format {
        Format::Ply => parse_ply(bytes, name),
        Format::Stl => parse_stl(bytes, name),
        Format::Obj => parse_obj(bytes, name),
    }
}

/// The path that a file in `folder` means by `name`, unless it leads out of the folder. Links are followed later by
/// whoever opens it. Backslashes count as slashes.
pub fn path_inside(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.replace('\\', "/");
    let drive = name.as_bytes().get(1) == Some(&b':');
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    let inside = !name.is_empty() && !drive && !name.contains('\0') && Path::new(&name).components().all(plain);
    inside.then(|| folder.join(name))
}

fn load_libraries(model: &mut Model, folder: &Path) {
    let mut library = Vec::new();
    for name in model.libraries.iter().take(MOST_LIBRARIES) {
        let shown = escaped(name);
        let Some(path) = path_inside(folder, name) else {
            model.warnings.push(format!("the material library `{shown}` is not read: it is not inside the folder"));
            continue;
        };
        let materials = read(&path, MOST_LIBRARY_BYTES)
            .map_err(|message| format!("the material library `{shown}` {message}"))
            .and_then(|bytes| parse_mtl(&bytes, &shown).map_err(|error| error.to_string()));
        match materials {
            Ok(materials) => library.extend(materials),
            Err(message) => model.warnings.push(message),
        }
    }
    let missing = model.materials.len() - model.apply_library(&library);
    if missing > 0 {
        model.warnings.push(format!("{missing} materials are named but in no material library"));
    }
}

/// The whole file, or why not.
fn read(path: &Path, most_bytes: u64) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => "does not exist".to_string(),
        _ => format!("cannot be read: {error}"),
    };
    let file = File::open(path).map_err(cannot)?;
    let metadata = file.metadata().map_err(cannot)?;
    if metadata.is_dir() {
        return Err("is a folder: give a file".to_string());
    }
    let too_large = || Err(format!("is larger than {most_bytes} bytes, the most that is read"));
    if metadata.len() > most_bytes {
        return too_large();
    }
    // Devices and pipes have no length, so the limit is checked again while reading.
    let mut bytes = Vec::new();
    file.take(most_bytes.saturating_add(1)).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > most_bytes { too_large() } else { Ok(bytes) }
}
