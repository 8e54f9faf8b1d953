//! The scene's file.

use std::path::{Path, PathBuf};

use raggio_render::{Comparison, Device, Image, PictureFormat, VulkanDevice};
use raggio_scene::AssetOptions;

use super::Viewer;
use crate::document::Document;
use crate::error::ViewError;
use crate::fields::Fields;
use crate::kernels::KernelWatch;
use crate::look::Look;
use crate::pilot::Pilot;
use crate::play::Happening;
use crate::watch::Watch;

impl Viewer {
    /// Writes the scene, with the camera as it is now.
    pub(super) fn save(&mut self, path: Option<PathBuf>) -> Result<(), ViewError> {
        self.document.set_camera(self.pilot.camera())?;
        self.document.end_gesture();
        match path {
            Some(path) => {
                self.document.save_as(&path)?;
                self.watch_scene();
            }
            None => self.document.save()?,
        }
        self.fields.saved_as(self.document.path());
        self.happened[Happening::Save as usize] += 1;
        self.notices.forgive();
        self.notices.done(format!("saved {}", self.document.path().display()));
        Ok(())
    }

    /// Reads the scene's file again.
    pub(super) fn reload(&mut self) -> Result<(), ViewError> {
        let mut read = false;
        self.change(|document| {
            read = document.reload()?;
            Ok(read)
        })?;
        self.notices.mended();
        if read {
            self.happened[Happening::Reload as usize] += 1;
            self.notices.done(format!("read {} again", self.document.path().display()));
        }
        Ok(())
    }

    /// Reads the scene's file again when others have changed it; edits of one's own are not lost without a word.
    pub(crate) fn follow_file(&mut self) -> Result<(), ViewError> {
        if !self.watch.as_mut().is_some_and(Watch::changed) {
            return Ok(());
        }
        let changed = self.document.changed_on_disk();
        if !changed && !self.document.assets_changed() {
            self.notices.mended();
            return Ok(());
        }
        if changed && self.document.is_modified() {
            let name = self.document.path().display();
            self.notices.warn(format!(
                "{name} was changed by another program, and here too: F5 takes the file's version (Ctrl+Z brings yours \
                 back), saving keeps yours"
            ));
            return Ok(());
        }
        match self.reload() {
            Err(error) if !error.is_device_lost() => {
                self.notices.mended();
                self.notices.fault(error);
                Ok(())
            }
            other => other,
        }
    }

    /// Writes changes that are not saved to a file beside the scene's; returns its path if there were any and they
    /// could be written.
    pub(crate) fn rescue(&self) -> Option<PathBuf> {
        let path = self.document.path().with_extension("recovered.toml");
        let written =
            self.document.is_modified() && raggio_render::write_whole(&path, self.document.text().as_bytes()).is_ok();
        written.then_some(path)
    }

    /// Opens a scene to show, or a picture to compare with.
    pub(super) fn open(&mut self, path: &Path) -> Result<(), ViewError> {
        if PictureFormat::of_path(path).is_some() {
            return self.compare_with(Some(path.into()));
        }
        if self.document.is_modified() {
            self.notices.fail(format!(
                "{} has changes that are not saved: save it (Ctrl+S) or take them back (Ctrl+Z), then open another scene",
                self.document.path().display()
            ));
            return Ok(());
        }
        let document =
            Document::open_with(path, AssetOptions { camera: None, ..self.document.assets().options().clone() })?;
        document.check_apart(&self.outputs)?;
        self.tracer.set_scene(document.scene(), &document.scene().camera)?;
        let preset = self.pilot.preset();
        self.pilot = Pilot::new(document.scene());
        self.pilot.set_preset(preset);
        self.fields = Fields::new(&document);
        self.document = document;
        self.select(None);
        self.notices.forgive();
        self.watch_scene();
        self.notices.mended();
        self.notices.warn_of_scene(&self.document.scene().warnings);
        Ok(())
    }

    /// Compares with the picture in this file, or with none.
    pub(super) fn compare_with(&mut self, path: Option<PathBuf>) -> Result<(), ViewError> {
        let image = path.as_deref().map(Image::load).transpose()?;
        let comparison = match self.settings.look.comparison {
            Comparison::Off if image.is_some() => Comparison::Split,
            _ if image.is_none() => Comparison::Off,
            known => known,
        };
        self.fields.compared_with(path.as_deref());
        self.tracer.set_reference(image)?;
        self.reference = path;
        self.show(Look { comparison, ..self.settings.look })
    }

    /// Compiles the kernels in `folder` again whenever they change.
    pub(crate) fn watch_kernels(&mut self, folder: &Path) -> Result<(), ViewError> {
        let Some(context) = self.tracer.device().vulkan() else {
            self.notices
                .warn("kernels are compiled again for Vulkan devices alone: those of the CPU are part of the program");
            return Ok(());
        };
        let wake = self.wake.clone();
        self.kernels = Some(KernelWatch::new(folder, context.has_ray_queries(), move || wake())?);
        Ok(())
    }

    /// Traces with the kernels as they are now in their files; the old ones stay if these are wrong.
    pub(crate) fn follow_kernels(&mut self) -> Result<(), ViewError> {
        let Some(compiled) = self.kernels.as_mut().and_then(KernelWatch::poll) else { return Ok(()) };
        let Some(context) = self.tracer.device().vulkan() else { return Ok(()) };
        self.notices.mended();
        match compiled {
            Ok(spirv) => {
                self.set_device(Box::new(VulkanDevice::with_kernels(context, &spirv)?))?;
                self.spirv = Some(spirv);
                self.happened[Happening::Exchange as usize] += 1;
                self.notices.done("the kernels were compiled again");
            }
            Err(message) => self.notices.fault(message),
        }
        Ok(())
    }

    /// A device like `device`, with the kernels as they were last compiled.
    pub(crate) fn with_kernels(&self, device: Box<dyn Device>) -> Result<Box<dyn Device>, ViewError> {
        match (&self.spirv, device.vulkan()) {
            (Some(spirv), Some(context)) => Ok(Box::new(VulkanDevice::with_kernels(context, spirv)?)),
            _ => Ok(device),
        }
    }

    /// Watches the scene's file, those that it names, and those that models name, for changes.
    pub(super) fn watch_scene(&mut self) {
        // The target of a link is what changes; a scene made for a model has no file yet.
        let scene = self.document.path().canonicalize().ok();
        let mut files: Vec<PathBuf> = self.document.assets().watched_files().map(PathBuf::from).chain(scene).collect();
        files.sort();
        files.dedup();
        if self.watch.as_ref().is_some_and(|watch| watch.watched() == files) {
            return;
        }
        let wake = self.wake.clone();
        self.watch = Watch::files(files, move || wake())
            .inspect_err(|error| self.notices.warn(format!("changes of the scene's files are not noticed: {error}")))
            .ok();
    }
}
