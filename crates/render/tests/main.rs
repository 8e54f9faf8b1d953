//! Translation, portions of work, and pictures on disk.

mod checkpoints;
mod compiling;
mod faults;
mod film;
mod group;
mod images;
mod portions;
mod rendering;
mod scripted;
mod translation;
