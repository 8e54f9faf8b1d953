//! Models from paths: the format is told by the extension, bytes are under a limit, libraries lie next to an OBJ.

use std::path::Path;

use raggio_choice::{choice, endings, format_of};

use crate::error::{Fault, ModelError};
use crate::file::{LoadOptions, read};
use crate::gltf::{GltfOptions, load_gltf};
use crate::inside::Named;
use crate::mesh::MeshFile;
use crate::model::Model;
use crate::obj::lookup::{Found, Lookup};
use crate::obj::materials::translate;
use crate::obj::mtl::MtlMaterial;
use crate::obj::textures::Textures;
use crate::text::{counted, escaped, quoted};
use crate::warnings::Warnings;
use crate::{parse_mtl, parse_obj, parse_ply, parse_stl};

/// Most bytes of a material library; larger ones are refused before they are read.
const MOST_LIBRARY_BYTES: u64 = 16 << 20;
/// Most libraries that are opened.
const MOST_LIBRARIES: usize = 64;

choice! {
    /// Format of a model's file, told by its ending.
    pub enum Format: "model format" {
        /// glTF 2.0, text with its binary files beside it.
        Gltf = "gltf",
        /// glTF 2.0 in one binary file.
        Glb = "glb",
        /// Polygon File Format, ascii or binary.
        Ply = "ply",
        /// Wavefront OBJ, with its material libraries beside it.
        Obj = "obj",
        /// Stereolithography, ascii or binary.
        Stl = "stl",
    }
}

impl Format {
    /// Format that the ending tells, in upper or lower case; `None` where it tells none.
    pub fn of_path(path: &Path) -> Option<Self> {
        format_of(path)
    }

    /// Whether files of the format can have animations; others are equal at every time.
    pub fn is_animated(self) -> bool {
        matches!(self, Self::Gltf | Self::Glb)
    }
}

/// Reads a model, with the libraries and textures that it names. One of these that cannot be read is a warning; warnings
/// that are alike become one when there are many.
///
/// # Errors
/// When the file cannot be read, is too large, or is not a valid model.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Model, ModelError> {
    let model = load_whole(path, options)?;
    Ok(Model { warnings: in_groups(model.warnings), ..model })
}

/// Warnings in which those that are alike have become one where they are many.
pub(crate) fn in_groups(list: Vec<String>) -> Vec<String> {
    let mut warnings = Warnings::default();
    warnings.extend(list);
    warnings.into_sentences()
}

fn load_whole(path: &Path, options: &LoadOptions) -> Result<Model, ModelError> {
    let name = escaped(&path.display().to_string());
    let fault = |message: String| Fault::whole(message).of(&name);
    let format = Format::of_path(path);
    let parse: fn(&[u8], &str) -> Result<MeshFile, ModelError> = match format {
        Some(Format::Gltf | Format::Glb) => return load_gltf(path, &GltfOptions::from(*options)),
        Some(Format::Ply) => parse_ply,
        Some(Format::Obj) => parse_obj,
        Some(Format::Stl) => parse_stl,
        None => return Err(fault(format!("is not a model: give a {} file", endings::<Format>()))),
    };
    let bytes = read(path, options.most_bytes).map_err(fault)?;
    let mut file = parse(&bytes, &name)?;
    drop(bytes);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut named = Named::default();
    if format == Some(Format::Obj) {
        named = load_libraries(&mut file, folder, options);
    }
    let mut textures = Textures::new(folder, options);
    let materials = translate(&file.materials, &mut textures);
    let (warnings, images) = textures.finish();
    file.warnings.extend(warnings);
    named.extend(images);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    Ok(file.into_model(&stem, materials).naming(&named))
}

/// Fills in the materials of the libraries that the model names. Returns which were looked for.
fn load_libraries(model: &mut MeshFile, folder: &Path, options: &LoadOptions) -> Named {
    let mut lookup = Lookup::new(folder, options.allow_outside);
    let (mut library, mut warnings) = (Vec::new(), Vec::new());
    for name in model.libraries.iter().take(MOST_LIBRARIES) {
        match load_library(name, &mut lookup, &mut warnings) {
            Ok(materials) => library.extend(materials),
            Err(message) => warnings.push(format!("the material library {} {message}", quoted(name.as_bytes()))),
        }
    }
    let missing = model.materials.len() - model.apply_library(&library);
    if missing > 0 {
        let are = if missing == 1 { "is" } else { "are" };
        let materials = counted(missing, "material");
        warnings.push(format!("{materials} {are} named but in no material library"));
    }
    model.warnings.extend(warnings);
    lookup.into_named()
}

fn load_library(name: &str, lookup: &mut Lookup<'_>, warnings: &mut Vec<String>) -> Result<Vec<MtlMaterial>, String> {
    let Found { path, instead } = lookup.find(&[""], name).map_err(|refusal| refusal.to_string())?;
    let shown = quoted(name.as_bytes());
    if let Some(instead) = &instead {
        let instead = quoted(instead.as_bytes());
        warnings.push(format!("the material library {shown} is not there: {instead} is read instead"));
    }
    let name = instead.unwrap_or_else(|| name.replace('\\', "/"));
    let library = parse_mtl(&read(&path, MOST_LIBRARY_BYTES)?, &escaped(&name));
    warnings.extend(library.warnings);
    let folder = &name[..name.rfind('/').map_or(0, |slash| slash + 1)];
    let beside = |material| MtlMaterial { folder: folder.to_string(), ..material };
    Ok(library.materials.into_iter().map(beside).collect())
}
