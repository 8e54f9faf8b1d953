//! Models and images that scenes name.

mod cache;
pub mod files;
mod gltf;
mod images;
mod meshes;
mod showing;
