//! Models from paths: the format is told by the extension, bytes are under a limit, libraries lie next to an OBJ.

use std::path::Path;

use crate::error::{Fault, ModelError};
use crate::file::{LoadOptions, path_near, read};
use crate::gltf::{GltfOptions, load_gltf};
use crate::mesh::MeshFile;
use crate::model::Model;
use crate::obj::materials::translate;
use crate::obj::textures::Textures;
use crate::text::escaped;
use crate::{parse_mtl, parse_obj, parse_ply, parse_stl};

/// Most bytes of a material library; larger ones are refused before they are read.
const MOST_LIBRARY_BYTES: u64 = 16 << 20;
/// Most libraries that are opened.
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
    /// Format that the extension tells, in upper or lower case.
    pub fn of_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            _ => None,
        }
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

/// Whether the extension, in upper or lower case, is glTF's.
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
