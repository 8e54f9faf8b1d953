//! Input typed into the panels.

use std::path::Path;

use crate::document::Document;

/// Input that has been typed into the panels and is not yet asked for.
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Path to save the scene to.
    pub save_path: String,
    /// Path to export a picture to.
    pub export_path: String,
    /// Size of the exported picture in pixels, if it has its own.
    pub export_size: Option<[u32; 2]>,
    /// Samples per pixel of the exported picture, if it has its own.
    pub export_samples: Option<u32>,
    /// Path of the picture to compare with.
    pub reference_path: String,
    /// Path of the next scene.
    pub open_path: String,
    /// The shape that the list has been scrolled to.
    pub scrolled_to: Option<usize>,
}

impl Fields {
    /// Creates the fields for a document that has just been opened.
    pub fn new(document: &Document) -> Self {
        let stem = document.path().file_stem().unwrap_or_default().to_string_lossy();
        Self { save_path: document.path().display().to_string(), export_path: format!("{stem}.exr"), ..Self::default() }
    }

    /// Fills in the path of another picture to compare with, or of none.
    pub fn compared_with(&mut self, path: Option<&Path>) {
        self.reference_path = path.map(|path| path.display().to_string()).unwrap_or_default();
    }

    /// Fills in another path of the scene's file.
    pub fn saved_as(&mut self, path: &Path) {
        self.save_path = path.display().to_string();
    }
}
