//! glTF 2.0: .gltf and .glb (khronos2021gltf).
//!
//! The document is deserialized into small structures of our own and checked in one place, extensions included. The
//! crate `gltf` was not chosen because it panics on some damaged files, accepts others that are invalid (loops of
//! nodes, buffer views that are too long), and lacks most of the extensions.
//!
//! Data goes from bytes to `Container`, mended and checked `Document` and `Asset` with buffers, then to images, materials and the
//! nodes' poses, and last to the model.
//!
//! Some things of a file have no meaning here and are passed over in silence: `doubleSided` (both sides of a surface
//! are always there), occlusion textures (light transport finds occlusion itself), minification filters, near and far
//! planes, bounds of accessors, `extras`, and attributes whose names begin with an underscore. All else is used or
//! named in a warning.

mod animation;
mod asset;
mod container;
mod document;
mod draco;
mod extensions;
mod fault;
mod images;
mod json_path;
mod materials;
mod mend;
mod mesh;
mod meshopt;
mod nodes;
mod nulls;
mod place;
mod pose;
mod resources;
mod stream;
mod validate;

use std::cell::RefCell;
use std::path::Path;

use crate::error::{Fault, ModelError};
use crate::file::{LoadOptions, MOST_BYTES, read};
use crate::model::Model;
use crate::text::{counted, escaped};
use asset::Asset;
use fault::Warnings;
use images::Images;
use nodes::Pose;
use place::Builder;
use resources::Folder;

pub use resources::Resources;

/// Options for reading a glTF file.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfOptions {
    /// Time at which animations are sampled, in seconds; without it nothing is animated.
    pub time_seconds: Option<f64>,
    /// Number of the scene, counted from 0; without it the file's own choice.
    pub scene: Option<usize>,
    /// Whether buffers and images may lie outside the folder of the file.
    pub allow_outside: bool,
    /// Most bytes of the file: larger ones are refused before they are read, and the same holds for the sum of the
    /// buffers and for what is made of them, which is also bounded by a multiple of the file's size. Images whose
    /// texels take more in all are left out.
    pub most_bytes: u64,
}

impl Default for GltfOptions {
    /// Options for the file's own scene at rest, inside its folder, of at most [`MOST_BYTES`].
    fn default() -> Self {
        Self { time_seconds: None, scene: None, allow_outside: false, most_bytes: MOST_BYTES }
    }
}

impl From<LoadOptions> for GltfOptions {
    fn from(options: LoadOptions) -> Self {
        let LoadOptions { time_seconds, allow_outside, most_bytes } = options;
        Self { time_seconds, scene: None, allow_outside, most_bytes }
    }
}

/// Reads a .gltf or .glb with the files beside it. An image that cannot be read is a warning.
///
/// # Errors
/// When the file or a buffer cannot be read or is too large, when the file is not valid, or when it needs an extension
/// that is not supported.
pub fn load_gltf(path: &Path, options: &GltfOptions) -> Result<Model, ModelError> {
    let name = escaped(&path.display().to_string());
    let bytes = read(path, options.most_bytes).map_err(|message| Fault::whole(message).of(&name))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let folder = Folder { path: folder, allow_outside: options.allow_outside, named: RefCell::default() };
    let model = parse_gltf(&bytes, &name, &folder, options)?;
    Ok(model.naming(folder.named.into_inner()))
}

/// Reads the bytes of a .gltf or .glb; `name` stands for the file in messages.
///
/// # Errors
/// The errors are those of [`load_gltf`].
pub fn parse_gltf(
    bytes: &[u8],
    name: &str,
    resources: &dyn Resources,
    options: &GltfOptions,
) -> Result<Model, ModelError> {
    convert(bytes, resources, options).map_err(|fault| fault.of(name))
}

fn convert(bytes: &[u8], resources: &dyn Resources, options: &GltfOptions) -> Result<Model, Fault> {
    let warnings = Warnings::default();
    let container = container::open(bytes, &warnings)?;
    extensions::check_required(&container.document)?;
    let asset = Asset::load(container, warnings, bytes.len(), resources, options)?;
    extensions::warn(&asset);
    let order = validate::roots_first(&asset.document.nodes)?;
    let roots = nodes::roots(&asset.document, options.scene, &order)?;

    let mut pose = Pose::at_rest(&asset)?;
    match options.time_seconds {
        Some(seconds) => animation::apply(&asset, seconds, &mut pose)?,
        None => warn_of_animations(&asset),
    }
    let worlds = pose.worlds(&order)?;
    warn_of_scenes(&asset);

    let images = Images::load(&asset, resources, options);
    let mut model = {
        let mut builder = Builder::new(&asset, &pose, &worlds);
        nodes::visible(&asset.document, &roots).into_iter().try_for_each(|node| builder.add_node(node))?;
        builder.finish()
    };
    model.materials = materials::translate(&asset, &images)?;
    model.is_animated = !asset.document.animations.is_empty();
    model.warnings = asset.warnings.finish();
    Ok(model)
}

fn warn_of_animations(asset: &Asset<'_>) {
    let count = asset.document.animations.len();
    if count > 0 {
        let (animations, need) = (counted(count, "animation"), if count == 1 { "needs" } else { "need" });
        asset.warnings.push(format!("the file has {animations}, which {need} a time: everything is at rest"));
    }
}

fn warn_of_scenes(asset: &Asset<'_>) {
    let count = asset.document.scenes.len();
    if count > 1 {
        asset.warnings.push(format!("the file has {count} scenes: one is shown, the others are left out"));
    }
}
