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
use std::path::{Path, PathBuf};

use crate::error::{Fault, ModelError};
use crate::file::{LoadOptions, MOST_BYTES, read};
use crate::inside::Named;
use crate::load::in_groups;
use crate::model::{Animation, Material, Model};
use crate::text::{counted, escaped};
use asset::Asset;
use fault::{Budget, Warnings};
use images::Images;
use nodes::Pose;
use place::{Builder, StillMeshes};
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
    let file = File::of(path);
    let bytes = file.read(options)?;
    let folder = file.folder(options);
    let model = parse_gltf(&bytes, &file.name, &folder, options)?;
    Ok(model.naming(&folder.named.into_inner()))
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
    let convert = || Opened::new(bytes, resources, options)?.at(options.time_seconds, resources, options);
    convert().map_err(|fault| fault.of(name))
}

/// A .gltf or .glb that is kept to be posed at one moment after another: buffers, images and what does not change its form
/// are decoded once.
pub struct GltfSequence {
    path: PathBuf,
    options: GltfOptions,
    opened: Opened<'static>,
    named: Named,
}

impl GltfSequence {
    /// Reads a file with the buffers beside it, as [`load_gltf`] does; images follow with the first model.
    ///
    /// # Errors
    /// The errors are those of [`load_gltf`].
    pub fn open(path: &Path, options: &GltfOptions) -> Result<Self, ModelError> {
        let file = File::of(path);
        let bytes = file.read(options)?;
        let folder = file.folder(options);
        let opened = Opened::new(&bytes, &folder, options).map_err(|fault| fault.of(&file.name))?.into_owned();
        let named = folder.named.into_inner();
        Ok(Self { path: path.into(), options: options.clone(), opened, named })
    }

    /// The model at a moment, in seconds, in place of that of the options. Meshes and images that are there at more than one
    /// are shared by the models.
    ///
    /// # Errors
    /// The errors are those of [`load_gltf`].
    pub fn at(&mut self, time_seconds: Option<f64>) -> Result<Model, ModelError> {
        let file = File::of(&self.path);
        let folder = file.folder(&self.options);
        let model = self.opened.at(time_seconds, &folder, &self.options).map_err(|fault| fault.of(&file.name))?;
        self.named.extend(folder.named.into_inner());
        let model = model.naming(&self.named);
        Ok(Model { warnings: in_groups(model.warnings), ..model })
    }
}

impl std::fmt::Debug for GltfSequence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("GltfSequence").field(&self.path).finish()
    }
}

/// A file, and what messages call it.
struct File<'a> {
    path: &'a Path,
    name: String,
}

impl<'a> File<'a> {
    fn of(path: &'a Path) -> Self {
        Self { path, name: escaped(&path.display().to_string()) }
    }

    fn read(&self, options: &GltfOptions) -> Result<Vec<u8>, ModelError> {
        read(self.path, options.most_bytes).map_err(|message| Fault::whole(message).of(&self.name))
    }

    fn folder(&self, options: &GltfOptions) -> Folder<'a> {
        let path = self.path.parent().unwrap_or(Path::new(""));
        Folder { path, allow_outside: options.allow_outside, named: RefCell::default() }
    }
}

/// A file that was read and checked, and what has been decoded of it.
struct Opened<'a> {
    asset: Asset<'a>,
    /// All nodes, parents first.
    order: Vec<(usize, Option<usize>)>,
    roots: Vec<usize>,
    animations: Vec<Animation>,
    /// Memory that each model may ask for.
    budget: Budget,
    /// Materials with their images, and the warnings of these, once there has been a model.
    materials: Option<(Vec<Material>, Vec<String>)>,
    still: StillMeshes,
}

impl<'a> Opened<'a> {
    fn new(bytes: &'a [u8], resources: &dyn Resources, options: &GltfOptions) -> Result<Self, Fault> {
        let warnings = Warnings::default();
        let container = container::open(bytes, &warnings)?;
        extensions::check_required(&container.document)?;
        let asset = Asset::load(container, warnings, bytes.len(), resources, options)?;
        extensions::warn(&asset);
        let order = validate::roots_first(&asset.document.nodes)?;
        let roots = nodes::roots(&asset.document, options.scene, &order)?;
        let budget = asset.budget.clone();
        let animations = animation::listed(&asset);
        Ok(Self { asset, order, roots, animations, budget, materials: None, still: StillMeshes::default() })
    }

    fn into_owned(self) -> Opened<'static> {
        let Self { asset, order, roots, animations, budget, materials, still } = self;
        Opened { asset: asset.into_owned(), order, roots, animations, budget, materials, still }
    }

    /// The model at a moment.
    fn at(&mut self, time: Option<f64>, resources: &dyn Resources, options: &GltfOptions) -> Result<Model, Fault> {
        self.asset.budget = self.budget.clone();
        let of_file = self.asset.warnings.told();
        let model = self.model(time, resources, options);
        let warnings = std::mem::take(&mut self.asset.warnings);
        self.asset.warnings.repeat(&of_file);
        Ok(Model { warnings: warnings.finish(), ..model? })
    }

    fn model(&mut self, time: Option<f64>, resources: &dyn Resources, options: &GltfOptions) -> Result<Model, Fault> {
        let Self { asset, order, roots, animations, materials, still, .. } = self;
        let mut pose = Pose::at_rest(asset)?;
        match time {
            Some(seconds) => animation::apply(asset, seconds, &mut pose)?,
            None => warn_of_animations(asset),
        }
        let worlds = pose.worlds(order)?;
        warn_of_scenes(asset);

        let mut model = {
            let mut builder = Builder::new(asset, &pose, &worlds, still);
            nodes::visible(&asset.document, roots).into_iter().try_for_each(|node| builder.add_node(node))?;
            builder.finish()
        };
        let (known, warnings) = match materials {
            Some(known) => known,
            None => {
                let translate = || materials::translate(asset, &Images::load(asset, resources, options));
                let (translated, warnings) = asset.warnings.apart(translate);
                materials.insert((translated?, warnings))
            }
        };
        asset.warnings.repeat(warnings);
        model.materials = known.clone();
        model.animations = animations.clone();
        Ok(model)
    }
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
