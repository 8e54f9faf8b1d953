//! Models from the files that people have, as plain data: PLY, STL, and OBJ with its materials and textures.
//!
//! Files come from anywhere, so a reader trusts none of their numbers: counts are checked against the bytes that
//! are there before memory is reserved, indices before they are kept, and what comes out has finite vertices and no
//! degenerate triangle. Whatever the bytes, the answer is a [`Model`] or a [`ModelError`], in memory and time
//! proportional to the size of the file.
//!
//! The readers are our own, because the usual crates do not make that promise: `ply-rs`, `tobj`, `stl_io` and `gltf` were
//! found weak on hostile input.
//!
//! Conventions: positions in the file's own units and axes; counter-clockwise triangles face the viewer; colours are
//! linear; texture coordinates as stored, and what brings them to the image's is in [`Texture::transform`]. A mesh without
//! normals is flat.

mod color;
mod error;
mod file;
mod gltf;
mod inside;
mod load;
mod material;
mod mesh;
mod model;
mod obj;
mod ply;
mod polygon;
mod stl;
mod text;
mod translate;
mod warnings;

pub use error::{ModelError, Place};
pub use file::{LoadOptions, MOST_BYTES, path_inside};
pub use gltf::{GltfOptions, GltfSequence, Resources, load_gltf, parse_gltf};
pub use load::{Format, load};
pub use material::{AlphaMode, Principled, Texture, TextureFilter, Wrap};
pub use mesh::{Dropped, Mesh, MeshFile, Part};
pub use model::{Animation, Camera, Instance, Light, LightKind, Material, Model, Projection};
pub use obj::mtl::{MtlLibrary, MtlMap, MtlMaterial, parse_mtl};
pub use obj::parse_obj;
pub use ply::parse_ply;
pub use stl::parse_stl;
