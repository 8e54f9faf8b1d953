//! One frame: events in, panels and picture out, for a window just as for a canvas that nobody sees.

use std::time::{Duration, Instant};

use egui::{Context, OutputCommand, PlatformOutput, Pos2, RawInput, Rect, ViewportId};
use raggio_render::Pixels;
use raggio_vulkan::{Area, Canvas, Overlay, Picture};

use crate::command::{Command, Navigate};
use crate::error::ViewError;
use crate::input::{self, Input};
use crate::overlay;
use crate::panel;
use crate::viewer::Viewer;

/// The smallest canvas at first, in pixels each way: a window may begin minimised.
pub const SMALLEST: u32 = 16;

/// A canvas that frames are drawn on, and the state of the panels.
pub struct Screen {
    ctx: Context,
    canvas: Canvas,
}

/// Requests of a frame to whoever shows it.
pub struct Frame {
    /// Cursor, clipboard and the like.
    pub platform: PlatformOutput,
    /// Delay after which the next frame is due; `None`: at the next event.
    pub next: Option<Duration>,
    /// Whether there was something to draw on.
    pub visible: bool,
    /// Capture of the frame, if it was asked for: size in pixels, and bytes red, green, blue, opacity.
    pub capture: Option<([u32; 2], Vec<u8>)>,
}

impl Screen {
    /// Creates the panels on a canvas.
    pub fn new(canvas: Canvas) -> Self {
        let ctx = Context::default();
        panel::apply_theme(&ctx);
        // Panels only say what they ask for; drawing them twice would ask twice.
        ctx.options_mut(|options| options.max_passes = std::num::NonZeroUsize::MIN);
        Self { ctx, canvas }
    }

    /// egui's state.
    pub fn ctx(&self) -> &Context {
        &self.ctx
    }

    /// The canvas that is drawn on.
    pub fn canvas(&mut self) -> &mut Canvas {
        &mut self.canvas
    }

    /// Moves the panels to another canvas, after the device of this one was lost.
    pub fn moved_to(&self, canvas: Canvas) -> Self {
        // A new egui, for it has to send all its textures again; what is open and closed stays.
        let screen = Self::new(canvas);
        let memory = self.ctx.memory(Clone::clone);
        screen.ctx.memory_mut(|new| *new = memory);
        screen.ctx.set_zoom_factor(self.ctx.zoom_factor());
        screen
    }

    /// Draws one frame of `viewer`, after it has done what `raw` and `commands` ask for.
    pub fn frame(&mut self, viewer: &mut Viewer, raw: RawInput, commands: Vec<Command>) -> Result<Frame, ViewError> {
        let seconds = viewer.clock.begin();
        let mut commands = commands;
        if !raw.events.is_empty() || !commands.is_empty() {
            viewer.untouched = Instant::now();
        }
        // A picture that a script takes is of the window, not of what the script has just been told.
        let pictured = |command: &Command| matches!(command, Command::Screenshot(Some(_)));
        let bare = viewer.outgoing.screenshot.is_some() || commands.iter().any(pictured);
        let mut fields = std::mem::take(&mut viewer.fields);
        let mut picture = (Rect::ZERO, Input::default());
        let output = self.ctx.run_ui(raw, |ui| {
            viewer.roomy = panel::fit(ui.available_width());
            panel::show(ui, viewer, &mut fields, &mut commands);
            let room = ui.available_rect_before_wrap();
            let area = in_whole_pixels(overlay::place(room, viewer), ui.pixels_per_point());
            picture = (area, input::read(ui, room, area));
            overlay::show(ui, room, area, viewer);
            if !bare {
                overlay::notices(ui, room, viewer);
            }
        });
        viewer.fields = fields;
        let (area, input) = picture;
        // egui's own selected text is what was meant to be copied.
        let copied = |command: &OutputCommand| matches!(command, OutputCommand::CopyText(_));
        let own_text = output.platform_output.commands.iter().any(copied);
        commands.extend(input.commands.iter().filter(|command| !own_text || **command != Command::CopyCamera).cloned());
        let scale = output.pixels_per_point;
        self.act(viewer, area, scale, &input, commands, seconds)?;

        viewer.attempt(Viewer::sample)?;
        let mut pixels = None;
        viewer.attempt(|viewer| viewer.picture().map(|picture| pixels = picture))?;
        let pixels = pixels.as_ref().map(|(pixels, size)| Picture { pixels: borrowed(pixels), size: *size });
        let primitives = self.ctx.tessellate(output.shapes, scale);
        let screenshot = viewer.outgoing.screenshot.is_some();
        let overlay = Overlay {
            primitives: &primitives,
            textures: output.textures_delta,
            pixels_per_point: scale,
            capture: screenshot,
        };
        let news = pixels.is_some();
        let shown = self.canvas.show(pixels, in_pixels(area, scale), overlay)?;
        if news && shown.visible {
            viewer.clock.show(viewer.tracer.samples_of_full_size());
        }
        viewer.clock.end(shown.waited);

        let mut platform = output.platform_output;
        platform.commands.extend(viewer.outgoing.text.take().map(OutputCommand::CopyText));
        let delay = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |view| view.repaint_delay);
        let next = if viewer.is_busy() { Duration::ZERO } else { delay.min(viewer.patience()) };
        let size = self.canvas.size();
        Ok(Frame {
            platform,
            next: (next < Duration::MAX).then_some(next),
            visible: shown.visible,
            capture: shown.capture.map(|pixels| (size, pixels)),
        })
    }

    fn act(
        &mut self,
        viewer: &mut Viewer,
        area: Rect,
        scale: f32,
        input: &Input,
        mut commands: Vec<Command>,
        seconds: f64,
    ) -> Result<(), ViewError> {
        if let Some(at) = input.double_clicked
            && let Some(pick) = viewer.tracer.pick(at[0], at[1])?
        {
            commands.push(Command::Navigate(Navigate::FocusOn(pick.shape)));
        }
        if let Some(at) = input.clicked {
            commands.push(Command::Select(viewer.tracer.pick(at[0], at[1])?.map(|pick| pick.shape)));
        }
        // Whatever a hand was doing with a control is one step to undo; it ends when the hand lets go.
        if !self.ctx.input(|i| i.pointer.any_down()) && !self.ctx.text_edit_focused() {
            commands.push(Command::EndGesture);
        }
        viewer.apply(commands)?;
        viewer.attempt(Viewer::follow_file)?;
        viewer.attempt(Viewer::follow_kernels)?;
        viewer.attempt(|viewer| viewer.resize(picture_size(area, scale)))?;
        viewer.attempt(|viewer| viewer.steer(&input.hands, seconds))?;
        viewer.attempt(|viewer| viewer.read(input.hands.cursor))
    }
}

fn borrowed(pixels: &Pixels) -> raggio_vulkan::Pixels<'_> {
    match pixels {
        Pixels::Host(pixels) => raggio_vulkan::Pixels::Host(bytemuck::cast_slice(pixels)),
        Pixels::Device(buffer) => raggio_vulkan::Pixels::Device(buffer),
    }
}

/// Moves the edges of `area` to those of pixels: the picture's are there too.
fn in_whole_pixels(area: Rect, scale: f32) -> Rect {
    let round = |point: Pos2| Pos2::new((point.x * scale).round(), (point.y * scale).round()) / scale;
    Rect::from_min_max(round(area.min), round(area.max))
}

fn in_pixels(area: Rect, scale: f32) -> Area {
    let round = |points: f32| (points * scale).round().max(0.0) as u32;
    let (left, top) = (round(area.left()), round(area.top()));
    let (right, bottom) = (round(area.right()), round(area.bottom()));
    Area { left, top, width: right.saturating_sub(left), height: bottom.saturating_sub(top) }
}

fn picture_size(area: Rect, scale: f32) -> [u32; 2] {
    let area = in_pixels(area, scale);
    [area.width.max(1), area.height.max(1)]
}
