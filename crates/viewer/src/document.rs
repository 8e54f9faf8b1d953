//! The scene file being edited.
//!
//! Its TOML text is the source of truth: every change edits the text, keeps the comments, the order and the formatting
//! of all that it does not touch, and is accepted only if the result is a valid scene.

mod clipboard;
mod edits;
mod error;
mod fields;
mod history;
mod layout;
mod lists;
mod path;
mod tree;

use std::path::{Path, PathBuf};

use raggio_scene::{Scene, SceneError, display_name, read_text};
use toml_edit::DocumentMut;

pub use clipboard::{camera_from_text, camera_text};
pub use error::EditError;

use history::History;
use layout::Layout;

/// A scene file, what it says, and how it came to say so.
#[derive(Debug)]
pub struct Document {
    path: PathBuf,
    text: String,
    scene: Scene,
    /// The file's text as last read or saved; `None` when it never was.
    on_disk: Option<String>,
    history: History,
}

impl Document {
    /// Reads a scene file.
    ///
    /// # Errors
    /// Those of [`Scene::load`].
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        let mut document = Self::from_text(read_text(path)?, path)?;
        document.on_disk = Some(document.text.clone());
        Ok(document)
    }

    /// A scene that is not on disk yet; [`Self::save`] would write it to `path`.
    ///
    /// # Errors
    /// When the text is not a valid scene.
    pub fn from_text(text: impl Into<String>, path: &Path) -> Result<Self, SceneError> {
        let text = text.into();
        let scene = Scene::parse(&text, &display_name(path))?;
        Ok(Self { path: path.to_path_buf(), text, scene, on_disk: None, history: History::default() })
    }

    /// Where the scene is read from and saved to.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the text says.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The file as it would be saved.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether the text differs from what was last read or saved.
    pub fn is_modified(&self) -> bool {
        self.on_disk.as_ref() != Some(&self.text)
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written; the document is then still modified.
    pub fn save(&mut self) -> Result<(), EditError> {
        let path = self.path.clone();
        self.save_as(&path)
    }

    /// Writes to another file, whole or not at all, which is the document's own from then on.
    ///
    /// # Errors
    /// When it cannot be written; nothing changes then.
    pub fn save_as(&mut self, path: &Path) -> Result<(), EditError> {
        raggio_render::write_whole(path, self.text.as_bytes())
            .map_err(|source| EditError::Unwritable { path: display_name(path), source })?;
        self.on_disk = Some(self.text.clone());
        if self.path != path {
            self.path = path.to_path_buf();
            // Warnings name the file.
            self.scene = Scene::parse(&self.text, &display_name(path))?;
        }
        Ok(())
    }

    /// Reads the file again. If it changed since it was last read or saved, its text becomes one step that can be
    /// undone. Whether the text of the document changed.
    ///
    /// # Errors
    /// Those of [`Self::open`]; nothing changes then.
    pub fn reload(&mut self) -> Result<bool, SceneError> {
        let text = read_text(&self.path)?;
        if self.on_disk.as_ref() == Some(&text) {
            return Ok(false);
        }
        self.history.end_gesture();
        let is_new = text != self.text;
        if is_new {
            self.accept("reload", text.clone())?;
        }
        self.on_disk = Some(text);
        Ok(is_new)
    }

    /// Whether another program has written the file since it was last read or saved. A file that cannot be read, or was
    /// neither read nor saved, has not changed: there is nothing to reload.
    pub fn changed_on_disk(&self) -> bool {
        let read = |known: &String| std::fs::read(&self.path).is_ok_and(|bytes| bytes != known.as_bytes());
        self.on_disk.as_ref().is_some_and(read)
    }

    /// Edits from here on, until [`Self::end_gesture`] or a gesture of another key, are one step to undo: a slider
    /// being dragged, a camera being flown. To begin the same gesture again changes nothing, so it may be called before
    /// every edit.
    pub fn begin_gesture(&mut self, key: &str) {
        self.history.begin_gesture(key);
    }

    /// Edits are steps of their own again.
    pub fn end_gesture(&mut self) {
        self.history.end_gesture();
    }

    /// The name of what [`Self::undo`] would undo.
    pub fn can_undo(&self) -> Option<&str> {
        self.history.can_undo()
    }

    /// The name of what [`Self::redo`] would do again.
    pub fn can_redo(&self) -> Option<&str> {
        self.history.can_redo()
    }

    /// Goes back one step and returns its name.
    pub fn undo(&mut self) -> Option<String> {
        let (name, text) = self.history.undo(&self.text)?;
        self.restore(text);
        Some(name)
    }

    /// Takes back one [`Self::undo`] and returns the step's name.
    pub fn redo(&mut self) -> Option<String> {
        let (name, text) = self.history.redo(&self.text)?;
        self.restore(text);
        Some(name)
    }

    /// Every text of the history was accepted once, so that it is a scene still.
    fn restore(&mut self, text: String) {
        if let Ok(scene) = Scene::parse(&text, &display_name(&self.path)) {
            self.scene = scene;
            self.text = text;
        }
    }

    /// Lets `change` edit the text. Whether that changed anything.
    fn edit(
        &mut self,
        name: &str,
        change: impl FnOnce(&mut DocumentMut, &Scene) -> Result<(), EditError>,
    ) -> Result<bool, EditError> {
        let layout = Layout::of(&self.text);
        let mut toml = layout.read(&self.text)?;
        let before = toml.to_string();
        change(&mut toml, &self.scene)?;
        let after = toml.to_string();
        if after == before {
            return Ok(false);
        }
        self.accept(name, layout.write(after))?;
        Ok(true)
    }

    /// Makes `text` the document's, as a step that can be undone.
    fn accept(&mut self, name: &str, text: String) -> Result<(), SceneError> {
        self.scene = Scene::parse(&text, &display_name(&self.path))?;
        let before = std::mem::replace(&mut self.text, text);
        self.history.record(name, before, &self.text);
        Ok(())
    }
}
