//! Kernels and devices against closed forms, double precision, references and one another: one program, for linking takes
//! longer than many a test, and pipelines are compiled once in it.

mod adaptive;
mod alpha;
mod closed_forms;
mod cost;
mod determinism;
mod gltf;
mod guides;
mod lights;
mod reference;
mod samplers;
mod shapes;
mod textures;
mod views;
