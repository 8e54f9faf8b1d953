//! Triangle meshes from PLY, STL and OBJ files, as plain data.
//!
//! Files come from anywhere, so a reader trusts none of their numbers: counts are checked against the bytes that
//! are there before memory is reserved, indices before they are kept, and what comes out has finite vertices and no
//! degenerate triangle. Whatever the bytes, the answer is a [`Model`] or a [`MeshError`], in memory and time
//! proportional to the size of the file.
//!
//! The readers are our own, because the usual crates do not make that promise: `ply-rs`, `tobj` and `stl_io` were
//! found weak on hostile input.
//!
//! Conventions: positions in the file's own units and axes; counter-clockwise triangles face the viewer; texture
//! coordinates and colours as stored, neither flipped nor decoded.

mod error;
mod file;
mod mesh;
mod obj;
mod ply;
mod polygon;
mod stl;
mod text;

pub use error::{MeshError, Place};
pub use file::{Format, MOST_BYTES, load, load_within, parse, path_inside};
pub use mesh::{Dropped, Mesh, Model, Part};
pub use obj::mtl::{MtlMaterial, parse_mtl};
pub use obj::parse_obj;
pub use ply::parse_ply;
pub use stl::parse_stl;
