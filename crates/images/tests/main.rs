//! Image files, right and wrong.

mod common;
mod exr;
mod hostile;
mod ktx;
mod raster;
