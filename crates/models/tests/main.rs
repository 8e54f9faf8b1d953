//! Model files, right and wrong.

mod bump;
mod formats;
mod gltf;
mod hostile;
mod lookup;
mod materials;
mod obj;
mod ply;
mod polygons;
mod round_trip;
mod stl;
