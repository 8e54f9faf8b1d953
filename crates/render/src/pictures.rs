//! Films, the layers and pictures that are made of them, and their files.

pub mod aov;
pub mod display;
pub mod exr_file;
pub mod file_faults;
pub mod film;
pub mod fingerprint;
pub mod format;
pub mod image_file;
pub mod image_input;
pub mod linear_image;
pub mod metadata;
pub mod output_file;
pub mod picture;
pub mod png_file;
pub mod runs;
