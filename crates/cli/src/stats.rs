use std::time::Instant;

use raggio_render::{Development, OutputFile, Preparation, Rendered, Tracer};
use raggio_scene::RenderSettings;
use serde_json::json;

use crate::error::{Failure, cannot_write};

/// Figures of a render, for `--stats`.
pub struct Stats<'a> {
    pub device: &'a str,
    pub rendered: &'a Rendered,
    pub settings: &'a RenderSettings,
    pub setup: Setup,
    pub written: Written,
}

/// Time that goes by once the picture is there.
#[derive(Default)]
pub struct Written {
    /// Part of it in which the picture was encoded and written.
    pub write_seconds: f64,
    /// Part of it in which its noise was removed, and in which that picture was written; `None` where nobody wants that.
    pub denoise_seconds: Option<f64>,
    /// Name of the denoiser and of what it worked on.
    pub denoiser: Option<String>,
}

/// Time before the first sample, but for what the render itself knows of it.
#[derive(Clone, Copy)]
pub struct Setup {
    /// Moment at which the program began, or the frame.
    pub start: Instant,
    /// All of it, from the start of the program or of the frame.
    pub seconds: f64,
    /// Part of it in which the scene was read; `None` where it was read beside other work.
    pub read_seconds: Option<f64>,
    /// Part of it in which the device was opened.
    pub open_seconds: f64,
}

impl Stats<'_> {
    pub fn write(&self, file: &OutputFile) -> Result<(), Failure> {
        let (film, progress) = (&self.rendered.picture.film, &self.rendered.progress);
        let seconds = progress.seconds.max(1e-9);
        let rays = film.rays();
        let Preparation { translate_seconds, upload_seconds, compile_seconds, compile_wait_seconds } =
            self.rendered.preparation;
        let Development { film_seconds, layers_seconds } = self.rendered.development;
        let stats = json!({
            "device": self.device,
            "denoiser": self.written.denoiser,
            "tracer": self.rendered.tracer.map(Tracer::name),
            "width": film.width(),
            "height": film.height(),
            "samples_per_pixel": film.sample_range().0,
            "max_depth": self.settings.max_depth,
            "setup_seconds": self.setup.seconds,
            "read_seconds": self.setup.read_seconds,
            "open_seconds": self.setup.open_seconds,
            "translate_seconds": translate_seconds,
            "upload_seconds": upload_seconds,
            "compile_seconds": compile_seconds,
            "compile_wait_seconds": compile_wait_seconds,
            "render_seconds": progress.seconds,
            "film_seconds": film_seconds,
            "layers_seconds": layers_seconds,
            "write_seconds": self.written.write_seconds,
            "denoise_seconds": self.written.denoise_seconds,
            "total_seconds": self.setup.start.elapsed().as_secs_f64(),
            "samples_per_second": progress.total_samples as f64 / seconds,
            "rays": rays,
            "rays_per_second": rays as f64 / seconds,
            "peak_memory_bytes": raggio_render::peak_memory_bytes(),
            "triangles": self.rendered.triangles,
            "shapes": self.rendered.shapes,
            "most_samples_per_pixel": film.sample_range().1,
            "clamped_share": film.clamped_share(),
        });
        file.write(format!("{stats:#}\n").as_bytes()).map_err(|e| match cannot_write(file.path(), &e) {
            Failure::Input(message) => Failure::Unwritten(message),
            other => other,
        })
    }
}
