//! Pictures on their way to files.

use std::path::Path;

use raggio_render::{DeviceScene, Display, Extras, Film, ImageFile, Metadata, OutputError, Renderer};

use crate::error::ViewError;
use crate::tracer::Tracer;

/// A picture that is rendered for a file alone, at a size and number of samples of its own.
pub struct Export {
    file: ImageFile,
    renderer: Renderer,
    alpha: bool,
    display: Display,
    metadata: Metadata,
    /// Film of radiance, which waits for that of its coverage.
    finished: Option<Film>,
}

/// Writes `film` as `raggio render` does, with all that an EXR says of how it was made.
pub fn write(file: &ImageFile, film: &Film, display: Display, mut metadata: Metadata) -> Result<(), OutputError> {
    metadata.samples = film.most_samples();
    file.write_with(film, display, &Extras { channels: vec![], metadata: Some(metadata) })
}

impl Export {
    /// Begins a picture of what `tracer` shows, of `size` pixels with so many samples each, with an alpha channel if there is
    /// to be one; `name` is the scene's.
    pub fn begin(
        file: ImageFile,
        tracer: &Tracer,
        name: &str,
        size: [u32; 2],
        samples: u32,
        alpha: bool,
        display: Display,
    ) -> Result<Self, ViewError> {
        raggio_render::check_memory(size[0], size[1])?;
        let mut scene = tracer.scene().clone();
        [scene.render.width, scene.render.height] = size;
        scene.render.alpha = alpha;
        let device_scene = DeviceScene::new(&scene)?;
        let session = tracer.device().load(&device_scene)?;
        let metadata = Metadata::new(&scene, name);
        let renderer = Renderer::new(session, &device_scene, 0..samples);
        Ok(Self { file, renderer, alpha, display, metadata, finished: None })
    }

    /// Spends about `seconds` on the picture; true when the file is written.
    pub fn advance(&mut self, seconds: f64) -> Result<bool, ViewError> {
        let film = match self.finished.take() {
            Some(film) => film,
            None if !self.renderer.run_for(seconds)? => return Ok(false),
            None if self.file.is_film() => self.renderer.labelled_film()?,
            None => self.renderer.film()?,
        };
        let coverage = if self.alpha { self.renderer.advance_coverage(&film, seconds)? } else { None };
        if self.alpha && coverage.is_none() {
            self.finished = Some(film);
            return Ok(false);
        }
        write(&self.file, &film.with_coverage(coverage), self.display, self.metadata.clone())?;
        Ok(true)
    }

    /// Part of the picture that is done, 0 to 1.
    pub fn fraction(&self) -> f32 {
        self.renderer.progress().fraction as f32
    }

    /// Path of the file to write.
    pub fn path(&self) -> &Path {
        self.file.path()
    }
}
