//! What has been typed into the panels.

use std::path::Path;

use crate::document::Document;

/// What has been typed and is not yet asked for.
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Where the scene goes.
    pub save_path: String,
    /// Where a picture goes.
    pub export_path: String,
    /// Its own size in pixels, if it has one.
    pub export_size: Option<[u32; 2]>,
    /// Its own samples per pixel, if it has them.
    pub export_samples: Option<u32>,
    /// The picture to compare with.
    pub reference_path: String,
    /// The next scene.
    pub open_path: String,
    /// The shape that the list has been scrolled to.
    pub scrolled_to: Option<usize>,
}

impl Fields {
    /// For a document that has just been opened.
    pub fn new(document: &Document) -> Self {
        let stem = document.path().file_stem().unwrap_or_default().to_string_lossy();
        Self { save_path: document.path().display().to_string(), export_path: format!("{stem}.exr"), ..Self::default() }
    }

    /// Another picture is compared with.
    pub fn compared_with(&mut self, path: Option<&Path>) {
        self.reference_path = path.map(|path| path.display().to_string()).unwrap_or_default();
    }

    /// The scene has another file now.
    pub fn saved_as(&mut self, path: &Path) {
        self.save_path = path.display().to_string();
    }
}
