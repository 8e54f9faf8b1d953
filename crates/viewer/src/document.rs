//! The scene file being edited.
//!
//! The TOML text is the source of truth: every change edits the text, keeps the comments, the order and the formatting
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

use raggio_render::{OutputError, OutputFile};
use raggio_scene::{AssetOptions, Assets, Scene, SceneError, display_name, is_model, scene_text};
use toml_edit::DocumentMut;

pub use clipboard::{camera_from_text, camera_text};
pub use error::EditError;

use history::History;
use layout::Layout;

/// A scene file: its text, the scene that the text describes, and the history of edits.
#[derive(Debug)]
pub struct Document {
    path: PathBuf,
    /// The scene file, or the model that the scene was made for as long as it was not saved.
    source: PathBuf,
    text: String,
    scene: Scene,
    /// The file's text as last read or saved; `None` when it never was.
    on_disk: Option<String>,
    /// Text of the scene that was made for a model; unchanged, it counts as saved, since nobody would miss it.
    made: Option<String>,
    history: History,
    assets: Assets,
}

impl Document {
    /// Reads a scene file, or makes a scene that shows a model.
    ///
    /// # Errors
    /// The errors of [`Scene::load`].
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        Self::open_with(path, AssetOptions::default())
    }

    /// Reads a scene file, or makes a scene that shows a model, with models read as `options` say. A scene made for a
    /// model is not on disk yet; [`Self::save`] would write it beside the model.
    ///
    /// # Errors
    /// The errors of [`Scene::load_with`].
    pub fn open_with(path: &Path, options: AssetOptions) -> Result<Self, SceneError> {
        let mut assets = Assets::new(options);
        let text = scene_text(path, &mut assets)?;
        if is_model(path) {
            let mut document = Self::read(text, &free_path(path), assets)?;
            document.made = Some(document.text.clone());
            document.source = path.to_path_buf();
            return Ok(document);
        }
        let mut document = Self::read(text, path, assets)?;
        document.on_disk = Some(document.text.clone());
        Ok(document)
    }

    /// Parses a scene that is not on disk yet; [`Self::save`] would write it to `path`.
    ///
    /// # Errors
    /// A [`SceneError`] when the text is not a valid scene.
    pub fn from_text(text: impl Into<String>, path: &Path) -> Result<Self, SceneError> {
        Self::read(text.into(), path, Assets::default())
    }

    fn read(text: String, path: &Path, mut assets: Assets) -> Result<Self, SceneError> {
        let scene = Scene::parse_with(&text, path, &mut assets)?;
        let path = path.to_path_buf();
        Ok(Self {
            source: path.clone(),
            path,
            text,
            scene,
            on_disk: None,
            made: None,
            history: History::default(),
            assets,
        })
    }

    /// Models and images that the scene is made of.
    pub fn assets(&self) -> &Assets {
        &self.assets
    }

    /// Paths of all files that the scene is made of, with those that its models name.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        [self.path(), self.source()].into_iter().chain(self.assets.all_files())
    }

    /// Checks that none of `outputs` takes the place of a file that the scene is made of.
    ///
    /// # Errors
    /// An [`OutputError`] that names both.
    pub fn check_apart(&self, outputs: &[OutputFile]) -> Result<(), OutputError> {
        outputs.iter().try_for_each(|file| {
            let path = file.path().to_path_buf();
            file.check_apart(self.files()).map_err(|source| OutputError::Unwritable { path, source })
        })
    }

    /// Path that the scene is read from and saved to.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// File that shows the scene: the one that it is read from and saved to, or the model that it was made for as long
    /// as it was not saved.
    pub fn source(&self) -> &Path {
        &self.source
    }

    /// Scene that the text describes.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Text of the file as it would be saved.
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
    /// [`EditError::Unwritable`] when the file cannot be written; the document is then still modified.
    pub fn save(&mut self) -> Result<(), EditError> {
        let path = self.path.clone();
        self.save_as(&path)
    }

    /// Writes the text to another file, whole or not at all; that file is the document's own from then on.
    ///
    /// # Errors
    /// [`EditError::Unwritable`] when the file cannot be written or is one that the scene names, [`EditError::Scene`] when from the other folder the
    /// scene does not find the files that it names; nothing changes then.
    pub fn save_as(&mut self, path: &Path) -> Result<(), EditError> {
        // Warnings name the file, and paths in it are relative to its folder.
        let moved = self.path != path;
        let scene = moved.then(|| Scene::parse_with(&self.text, path, &mut self.assets)).transpose()?;
        let write = |file: OutputFile| {
            file.check_apart(self.assets.all_files())?;
            file.write(self.text.as_bytes())
        };
        let written = OutputFile::new(path).and_then(write);
        written.map_err(|source| EditError::Unwritable { path: display_name(path), source })?;
        self.on_disk = Some(self.text.clone());
        self.source = path.to_path_buf();
        if let Some(scene) = scene {
            self.scene = scene;
            self.path = path.to_path_buf();
        }
        Ok(())
    }

    /// Reads the file again, and the files that it names. If it changed since it was last read or saved, its text
    /// becomes one step that can be undone. Returns whether the scene may have changed.
    ///
    /// # Errors
    /// The errors of [`Self::open`]; nothing changes then.
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

    /// Whether a model, an image, or a file that a model names was written since it was last read.
    pub fn assets_changed(&mut self) -> bool {
        self.assets.refresh()
    }

    /// Begins a gesture: edits from here on, until [`Self::end_gesture`] or a gesture of another key, are one step to
    /// undo, such as a slider being dragged or a camera being flown. To begin the same gesture again changes nothing,
    /// so it may be called before every edit.
    pub fn begin_gesture(&mut self, key: &str) {
        self.history.begin_gesture(key);
    }

    /// Ends the gesture: edits are steps of their own again.
    pub fn end_gesture(&mut self) {
        self.history.end_gesture();
    }

    /// Name of the step that [`Self::undo`] would undo; `None` when there is none.
    pub fn can_undo(&self) -> Option<&str> {
        self.history.can_undo()
    }

    /// Name of the step that [`Self::redo`] would do again; `None` when there is none.
    pub fn can_redo(&self) -> Option<&str> {
        self.history.can_redo()
    }

    /// Goes back one step and returns its name; `None` when there is none, or a file that the older text names is gone.
    pub fn undo(&mut self) -> Option<String> {
        let (name, text) = self.history.undo(&self.text)?;
        if !self.restore(&text) {
            self.history.redo(&text);
            return None;
        }
        Some(name)
    }

    /// Takes back one [`Self::undo`] and returns the step's name; `None` as for `undo`.
    pub fn redo(&mut self) -> Option<String> {
        let (name, text) = self.history.redo(&self.text)?;
        if !self.restore(&text) {
            self.history.undo(&text);
            return None;
        }
        Some(name)
    }

    /// Makes a text of the history the document's and returns whether it still is a scene: each was accepted once, but
    /// a file that it names may be gone.
    fn restore(&mut self, text: &str) -> bool {
        let scene = Scene::parse_with(text, &self.path, &mut self.assets);
        let is_scene = scene.is_ok();
        if let Ok(scene) = scene {
            self.scene = scene;
            self.text = text.to_string();
        }
        is_scene
    }

    /// Lets `change` edit the text and returns whether that changed anything.
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

/// Path beside a model for the scene that shows it: a file that is not there yet.
fn free_path(model: &Path) -> PathBuf {
    let stem = model.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let numbered = (2..).map(|number| format!("{stem}_{number}.toml"));
    let mut names = std::iter::once(format!("{stem}.toml")).chain(numbered).map(|name| model.with_file_name(name));
    names.find(|path| !path.exists()).unwrap_or_else(|| model.with_extension("toml"))
}
