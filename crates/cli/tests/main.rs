//! The program `raggio`, run as a user would.

mod bench;
mod common;
mod film;
mod outputs;
mod refusals;
mod render;
mod view;
