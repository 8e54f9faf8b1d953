//! The way of a scene to what kernels read: flat buffers, hierarchies, lists of lights, tables.

pub mod bounds;
pub mod camera;
pub mod device_scene;
pub mod error;
pub mod filters;
pub mod hierarchy;
pub mod lights;
pub mod media;
pub mod meshes;
pub mod motion;
pub mod textures;
