//! Scene files, right and wrong.

mod accepted;
mod assets;
mod common;
mod errors;
mod hostile;
mod keyframes;
mod load;
mod reference;
mod rock;
mod schema;
mod sky;
