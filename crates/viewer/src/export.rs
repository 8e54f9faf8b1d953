//! Pictures on their way to files.

use std::path::Path;

use raggio_render::{DeviceScene, Display, Extras, Film, ImageFile, Metadata, OutputError, Renderer};

use crate::error::ViewError;
use crate::tracer::Tracer;

/// A picture that is rendered for a file alone, at a size and number of samples of its own.
pub struct Export {
    file: ImageFile,
    renderer: Renderer,
    display: Display,
    metadata: Metadata,
}

/// Writes `film` as `raggio render` does, with all that an EXR says of how it was made.
pub fn write(file: &ImageFile, film: &Film, display: Display, mut metadata: Metadata) -> Result<(), OutputError> {
    metadata.samples = film.most_samples();
    file.write_with(film, display, &Extras { channels: vec![], metadata: Some(metadata) })
}

impl Export {
    /// Begins a picture of what `tracer` shows, of `size` pixels with so many samples each; `name` is the scene's.
    pub fn begin(
        file: ImageFile,
        tracer: &Tracer,
        name: &str,
        size: [u32; 2],
        samples: u32,
        display: Display,
    ) -> Result<Self, ViewError> {
        raggio_render::check_memory(size[0], size[1])?;
        let mut scene = tracer.scene().clone();
        [scene.render.width, scene.render.height] = size;
        let device_scene = DeviceScene::new(&scene)?;
        let session = tracer.device().load(&device_scene)?;
        let metadata = Metadata::new(&scene, name);
        Ok(Self { file, renderer: Renderer::new(session, &device_scene, 0..samples), display, metadata })
    }

    /// Spends about `seconds` on the picture; true when the file is written.
    pub fn advance(&mut self, seconds: f64) -> Result<bool, ViewError> {
        let finished = self.renderer.run_for(seconds)?;
        if finished {
            let film = if self.file.is_film() { self.renderer.labelled_film()? } else { self.renderer.film()? };
            write(&self.file, &film, self.display, self.metadata.clone())?;
        }
        Ok(finished)
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
