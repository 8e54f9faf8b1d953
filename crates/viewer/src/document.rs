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

use raggio_scene::{AssetOptions, Assets, Scene, SceneError, display_name, is_model, scene_text};
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
    /// The text that was made for a model, which nobody would miss.
    made: Option<String>,
    history: History,
    assets: Assets,
}

impl Document {
    /// Reads a scene file, or makes a scene that shows a model.
    ///
    /// # Errors
    /// Those of [`Scene::load`].
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        Self::open_with(path, AssetOptions::default())
    }

    /// The same, with models read as `options` say. A scene made for a model is not on disk yet; [`Self::save`] would
    /// write it beside the model.
    ///
    /// # Errors
    /// Those of [`Scene::load_with`].
    pub fn open_with(path: &Path, options: AssetOptions) -> Result<Self, SceneError> {
        let mut assets = Assets::new(options);
        let text = scene_text(path, &mut assets)?;
        if is_model(path) {
            let mut document = Self::read(text, &free_path(path), assets)?;
            document.made = Some(document.text.clone());
            return Ok(document);
        }
        let mut document = Self::read(text, path, assets)?;
        document.on_disk = Some(document.text.clone());
        Ok(document)
    }

    /// A scene that is not on disk yet; [`Self::save`] would write it to `path`.
    ///
    /// # Errors
    /// When the text is not a valid scene.
    pub fn from_text(text: impl Into<String>, path: &Path) -> Result<Self, SceneError> {
        Self::read(text.into(), path, Assets::default())
    }

    fn read(text: String, path: &Path, mut assets: Assets) -> Result<Self, SceneError> {
        let scene = Scene::parse_with(&text, path, &mut assets)?;
        let path = path.to_path_buf();
        Ok(Self { path, text, scene, on_disk: None, made: None, history: History::default(), assets })
    }

    /// Models and images that the scene is made of.
    pub fn assets(&self) -> &Assets {
        &self.assets
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
        ![&self.on_disk, &self.made].map(Option::as_ref).contains(&Some(&self.text))
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
    /// When it cannot be written, or in the other folder does not find what it names; nothing changes then.
    pub fn save_as(&mut self, path: &Path) -> Result<(), EditError> {
        // Warnings name the file, and paths in it are relative to its folder.
        let moved = self.path != path;
        let scene = moved.then(|| Scene::parse_with(&self.text, path, &mut self.assets)).transpose()?;
        raggio_render::write_whole(path, self.text.as_bytes())
            .map_err(|source| EditError::Unwritable { path: display_name(path), source })?;
        self.on_disk = Some(self.text.clone());
        if let Some(scene) = scene {
            self.scene = scene;
            self.path = path.to_path_buf();
        }
        Ok(())
    }

    /// Reads the file again, and what it names. If it changed since it was last read or saved, its text becomes one step
    /// that can be undone. Whether the scene may have changed.
    ///
    /// # Errors
    /// Those of [`Self::open`]; nothing changes then.
    pub fn reload(&mut self) -> Result<bool, SceneError> {
        let is_stale = self.assets.refresh();
        let text = match self.on_disk {
            Some(_) => scene_text(&self.path, &mut self.assets)?,
            None => self.text.clone(),
        };
        if self.on_disk.as_ref().is_none_or(|known| *known == text) {
            if is_stale {
                self.scene = Scene::parse_with(&self.text, &self.path, &mut self.assets)?;
            }
            return Ok(is_stale);
        }
        self.history.end_gesture();
        let is_new = text != self.text;
        if is_new {
            self.accept("reload", text.clone())?;
        } else if is_stale {
            self.scene = Scene::parse_with(&self.text, &self.path, &mut self.assets)?;
        }
        self.on_disk = Some(text);
        Ok(is_new || is_stale)
    }

    /// Whether another program has written the file since it was last read or saved. A file that cannot be read, or was
    /// neither read nor saved, has not changed: there is nothing to reload.
    pub fn changed_on_disk(&self) -> bool {
        let read = |known: &String| std::fs::read(&self.path).is_ok_and(|bytes| bytes != known.as_bytes());
        self.on_disk.as_ref().is_some_and(read)
    }

    /// Whether a model or an image was written since it was last read.
    pub fn assets_changed(&mut self) -> bool {
        self.assets.refresh()
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
        if !self.restore(&text) {
            self.history.redo(&text);
            return None;
        }
        Some(name)
    }

    /// Takes back one [`Self::undo`] and returns the step's name.
    pub fn redo(&mut self) -> Option<String> {
        let (name, text) = self.history.redo(&self.text)?;
        if !self.restore(&text) {
            self.history.undo(&text);
            return None;
        }
        Some(name)
    }

    /// Every text of the history was accepted once, so that it is a scene still, unless a file that it names is gone.
    fn restore(&mut self, text: &str) -> bool {
        let scene = Scene::parse_with(text, &self.path, &mut self.assets);
        let is_scene = scene.is_ok();
        if let Ok(scene) = scene {
            self.scene = scene;
            self.text = text.to_string();
        }
        is_scene
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
        self.scene = Scene::parse_with(&text, &self.path, &mut self.assets)?;
        let before = std::mem::replace(&mut self.text, text);
        self.history.record(name, before, &self.text);
        Ok(())
    }
}

/// Beside a model, for the scene that shows it: a file that is not there yet.
fn free_path(model: &Path) -> PathBuf {
    let stem = model.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let numbered = (2..).map(|number| format!("{stem}_{number}.toml"));
    let mut names = std::iter::once(format!("{stem}.toml")).chain(numbered).map(|name| model.with_file_name(name));
    names.find(|path| !path.exists()).unwrap_or_else(|| model.with_extension("toml"))
}
