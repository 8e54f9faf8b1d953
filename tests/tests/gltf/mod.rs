//! Pictures of small glTF files, each of which shows what one feature alone does: closed forms where there are any, else
//! the same surface by the scene file's own words, and how much it differs from the surface without the feature.

mod asset;
mod geometry;
mod layers;
mod lights;
mod motion;
mod normals;
mod picture;
mod placement;
mod textures;
mod transparency;
