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
pub fn run(options: &Options) -> Result<Report, ViewError> {
    // Drivers take about as long for a device as files do for a scene.
    let (files, opened) = std::thread::scope(|scope| {
        let open = || -> Result<_, ViewError> {
            let instance = Instance::new(options.open.validate)?;
            let mut opener = Opener::new(options, instance.clone());
            opener.open_ahead();
            Ok((instance, opener))
        };
        let opening = scope.spawn(open);
        let read = || {
            let mut files = Files::read(options)?;
            files.translate(options.size).map(|()| files)
        };
        (read(), opening.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    let (files, (instance, opener)) = (files?, opened?);
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
            return Ok(Report::of(&mut stage.viewer, options.start, instance.validation_messages()));
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
