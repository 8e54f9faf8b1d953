//! glTF files, each built in its test, give the values that they describe; damaged ones give errors.

mod accessors;
mod builder;
mod compression;
mod containers;
mod hostile;
mod materials;
mod meshes;
mod motion;
mod nodes;
mod refusals;
