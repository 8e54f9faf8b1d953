//! The window's parts that need no window.

mod document;
mod navigation;
