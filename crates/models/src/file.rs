//! From a path to a model: the format by its extension, the bytes under a limit, and the libraries next to an OBJ.

use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use crate::error::{Fault, ModelError};
use crate::gltf::{GltfOptions, load_gltf};
use crate::mesh::MeshFile;
use crate::model::Model;
use crate::obj::materials::translate;
use crate::obj::textures::Textures;
use crate::text::escaped;
use crate::{parse_mtl, parse_obj, parse_ply, parse_stl};

/// What [`LoadOptions::most_bytes`] is unless somebody says otherwise.
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

/// How a model is to be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadOptions {
    /// When to sample animations; without it nothing is animated.
    pub time_seconds: Option<f64>,
    /// Whether libraries, buffers and images may lie outside the folder of the file.
    pub allow_outside: bool,
    /// Larger files are refused before they are read, and textures that take more bytes in all are left out.
    pub most_bytes: u64,
}

impl Default for LoadOptions {
    /// At rest, inside its folder, at most [`MOST_BYTES`].
    fn default() -> Self {
        Self { time_seconds: None, allow_outside: false, most_bytes: MOST_BYTES }
    }
}

/// Reads a model, with the libraries and textures that it names. One of these that cannot be read is a warning.
///
/// # Errors
/// When the file cannot be read, is too large, or is not a valid model.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Model, ModelError> {
    if is_gltf(path) {
        return load_gltf(path, &GltfOptions::from(*options));
    }
    let name = escaped(&path.display().to_string());
    let fault = |message: String| Fault::whole(message).of(&name);
    let format = Format::of_path(path);
    let format = format.ok_or_else(|| fault("is not a model: give a .gltf, .glb, .ply, .stl or .obj".to_string()))?;
    let bytes = read(path, options.most_bytes).map_err(fault)?;
    let mut file = parse(format, &bytes, &name)?;
    drop(bytes);
    let folder = path.parent().unwrap_or(Path::new(""));
    if format == Format::Obj {
        load_libraries(&mut file, folder, options);
    }
    let mut textures = Textures::new(folder, options);
    let materials = translate(&file.materials, &mut textures);
    file.warnings.extend(textures.into_warnings());
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(file.into_model(&stem, materials))
}

/// By the extension, in any case.
fn is_gltf(path: &Path) -> bool {
    path.extension().is_some_and(|extension| ["gltf", "glb"].iter().any(|name| extension.eq_ignore_ascii_case(name)))
}

/// Reads the bytes of a mesh file; `name` stands for the file in messages.
///
/// # Errors
/// When the bytes are not a valid mesh.
pub fn parse(format: Format, bytes: &[u8], name: &str) -> Result<MeshFile, ModelError> {
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

/// As [`path_inside`], or anywhere if the options allow it.
pub(crate) fn path_near(folder: &Path, name: &str, options: &LoadOptions) -> Option<PathBuf> {
    let anywhere = || folder.join(name.replace('\\', "/"));
    if options.allow_outside { Some(anywhere()) } else { path_inside(folder, name) }
}

fn load_libraries(model: &mut MeshFile, folder: &Path, options: &LoadOptions) {
    let mut library = Vec::new();
    for name in model.libraries.iter().take(MOST_LIBRARIES) {
        let shown = escaped(name);
        let Some(path) = path_near(folder, name, options) else {
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
pub(crate) fn read(path: &Path, most_bytes: u64) -> Result<Vec<u8>, String> {
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
