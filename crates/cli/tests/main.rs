//! The program `raggio`, run as a user would.

mod bench;
mod common;
mod film;
mod frames;
mod merge;
mod outputs;
mod refusals;
mod render;
mod survival;
mod view;
