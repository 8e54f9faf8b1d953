//! Translation, portions of work, and pictures on disk.

mod images;
mod portions;
mod translation;
