//! The viewer without a window: frames are drawn on a canvas that nobody sees, as fast as they come.

use std::sync::Arc;
use std::time::Instant;

use egui::{Pos2, RawInput, Rect, Vec2, ViewportId, ViewportInfo};
use raggio_vulkan::Instance;

use crate::error::ViewError;
use crate::options::Options;
use crate::play::WindowStep;
use crate::report::Report;
use crate::stage::{Files, Opener, Stage};

/// Plays the script of `options` to its end.
pub fn run(options: &Options, files: Files) -> Result<Report, ViewError> {
    let instance = Instance::new(options.open.validate)?;
    let opener = Opener::new(options, instance.clone());
    let mut size = options.size;
    let mut scale = options.scale.unwrap_or(1.0);
    let mut stage = Stage::new(options, files, opener, None, size, Arc::new(|| ()))?;
    let start = Instant::now();
    loop {
        let raw = raw_input(size, scale, start.elapsed().as_secs_f64());
        let outcome = stage.frame(raw, &|| Ok(None))?;
        for step in outcome.window {
            match step {
                WindowStep::Size(new) => size = new.map(|side| side.max(1)),
                WindowStep::Scale(new) => scale = new,
                WindowStep::Minimise | WindowStep::Restore => {}
            }
        }
        stage.screen.canvas().resize_to(size)?;
        if outcome.quit {
            return Ok(Report::of(&mut stage.viewer, instance.validation_messages()));
        }
    }
}

fn raw_input(size: [u32; 2], scale: f32, time: f64) -> RawInput {
    let points = Vec2::new(size[0] as f32, size[1] as f32) / scale;
    let root = ViewportInfo { native_pixels_per_point: Some(scale), ..ViewportInfo::default() };
    let mut raw = RawInput {
        screen_rect: Some(Rect::from_min_size(Pos2::ZERO, points)),
        time: Some(time),
        focused: true,
        ..RawInput::default()
    };
    raw.viewports.insert(ViewportId::ROOT, root);
    raw
}
