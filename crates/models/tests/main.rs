//! Model files, right and wrong.

mod formats;
mod gltf;
mod hostile;
mod materials;
mod polygons;
mod round_trip;
