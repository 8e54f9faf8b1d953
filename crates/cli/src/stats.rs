use std::path::Path;

use raggio_render::{Film, Progress};
use serde_json::json;

use crate::error::{Failure, cannot_write};

/// What a render did, for `--stats`.
pub struct Stats<'a> {
    pub device: &'a str,
    pub film: &'a Film,
    pub progress: Progress,
    pub max_depth: u32,
    pub setup_seconds: f64,
    pub shapes: usize,
    pub triangles: usize,
}

impl Stats<'_> {
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let seconds = self.progress.seconds.max(1e-9);
        let rays = self.film.rays();
        let stats = json!({
            "device": self.device,
            "width": self.film.width(),
            "height": self.film.height(),
            "samples_per_pixel": self.film.sample_range().0,
            "max_depth": self.max_depth,
            "setup_seconds": self.setup_seconds,
            "render_seconds": self.progress.seconds,
            "samples_per_second": self.progress.total_samples as f64 / seconds,
            "rays": rays,
            "rays_per_second": rays as f64 / seconds,
            "peak_memory_bytes": raggio_render::peak_memory_bytes(),
            "triangles": self.triangles,
            "shapes": self.shapes,
            "most_samples_per_pixel": self.film.sample_range().1,
            "clamped_share": self.film.clamped_share(),
        });
        raggio_render::write_whole(path, format!("{stats:#}\n").as_bytes()).map_err(|e| cannot_write(path, &e))
    }
}
