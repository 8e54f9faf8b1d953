//! Models and images that scenes name.

mod cache;
mod files;
mod gltf;
mod images;
mod meshes;
mod showing;
