//! State of the viewer: one scene, one camera, one picture; and the only place where they change.

mod edit;
mod files;
mod pictures;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use raggio_render::{Device, FilmPixel, OutputFile, Spirv};
use raggio_scene::{Camera, Scene, Vec3};

use crate::clock::Clock;
use crate::command::{Command, Navigate};
use crate::denoising::{Denoising, InMotion};
use crate::document::Document;
use crate::error::ViewError;
use crate::export::Export;
use crate::extent::extent;
use crate::fields::Fields;
use crate::kernels::KernelWatch;
use crate::look::Look;
use crate::notices::Notices;
use crate::pilot::{Hands, Pilot};
use crate::play::{Happened, State};
use crate::tracer::{Pick, Tracer};
use crate::wake::Wake;
use crate::watch::Watch;

/// The state behind the window.
pub struct Viewer {
    pub(crate) document: Document,
    pub(crate) tracer: Tracer,
    pub(crate) pilot: Pilot,
    pub(crate) clock: Clock,
    pub(crate) notices: Notices,
    pub(crate) settings: Settings,
    /// Place of the selected shape's `[[shapes]]` in the file.
    pub(crate) selection: Option<usize>,
    /// Lower and upper corner of the box around the selection, if it has one.
    pub(crate) outline: Option<(Vec3, Vec3)>,
    pub(crate) reading: Option<Reading>,
    pub(crate) export: Option<Export>,
    /// Denoiser, if the picture is shown without its noise.
    pub(crate) denoising: Option<Denoising>,
    pub(crate) fields: Fields,
    pub(crate) outgoing: Outgoing,
    pub(crate) reference: Option<PathBuf>,
    /// Files that are written when the viewer is over.
    pub(crate) outputs: Vec<OutputFile>,
    /// Time when a hand last did something.
    pub(crate) untouched: Instant,
    /// Whether the window has room for panels beside the picture.
    pub(crate) roomy: bool,
    happened: Happened,
    watch: Option<Watch>,
    kernels: Option<KernelWatch>,
    /// SPIR-V that the kernels were last compiled to.
    spirv: Option<Spirv>,
    wake: Wake,
}

/// Settings that the user has chosen and that are not the scene's.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Display of the film.
    pub look: Look,
    /// Whether pictures lose their noise while the camera moves, if they do at rest.
    pub denoise_in_motion: InMotion,
    /// Whether no samples are added.
    pub paused: bool,
    /// Samples per pixel at which to stop.
    pub limit: Option<u32>,
    /// Samples per pixel and frame; `None`: as many as there is time for.
    pub samples_per_frame: Option<u32>,
    /// Whether the picture is as large as the scene says, whatever the window's size.
    pub scene_size: bool,
    /// Whether the picture fills the room that there is for it, whatever the proportions of the scene's.
    pub fill: bool,
    /// Whether the panels are shown where there is room for them.
    pub panels: bool,
    /// Whether the table of keys is shown.
    pub help: bool,
}

/// Requests to the window for when the frame is done.
#[derive(Default)]
pub struct Outgoing {
    /// Text for the clipboard.
    pub text: Option<String>,
    /// File for a screenshot of the window.
    pub screenshot: Option<PathBuf>,
    /// Whether the window is to close.
    pub quit: bool,
}

/// Values of the pixel under the cursor.
#[derive(Clone, Copy)]
pub struct Reading {
    /// Column and row in the film, from the top left.
    pub pixel: [u32; 2],
    /// Sums of the pixel.
    pub film: FilmPixel,
    /// Surface that the camera sees there, if any.
    pub pick: Option<Pick>,
}

impl Viewer {
    /// Shows `document` in a picture of `size` pixels.
    pub fn new(document: Document, device: Box<dyn Device>, size: [u32; 2], wake: Wake) -> Result<Self, ViewError> {
        let tracer = Tracer::new(device, document.scene(), size)?;
        Ok(Self::with_tracer(document, tracer, wake))
    }

    /// Shows `document`, whose scene `tracer` has.
    pub fn with_tracer(document: Document, tracer: Tracer, wake: Wake) -> Self {
        let scene = document.scene();
        let mut viewer = Self {
            pilot: Pilot::new(scene),
            tracer,
            clock: Clock::new(1.0 / 60.0),
            notices: Notices::default(),
            settings: Settings {
                look: Look::default(),
                denoise_in_motion: InMotion::Auto,
                paused: false,
                limit: None,
                samples_per_frame: None,
                scene_size: false,
                fill: false,
                panels: true,
                help: false,
            },
            selection: None,
            outline: None,
            reading: None,
            export: None,
            denoising: None,
            fields: Fields::new(&document),
            outgoing: Outgoing::default(),
            reference: None,
            outputs: vec![],
            untouched: Instant::now(),
            roomy: true,
            happened: Happened::default(),
            watch: None,
            kernels: None,
            spirv: None,
            wake,
            document,
        };
        viewer.watch_scene();
        viewer.notices.done("F1 shows what mouse and keys do");
        viewer.notices.warn_of_scene(&viewer.document.scene().warnings);
        viewer
    }

    /// The scene, as it is in the document.
    pub fn scene(&self) -> &Scene {
        self.document.scene()
    }

    /// Camera that the scene is seen from.
    pub fn camera(&self) -> &Camera {
        self.pilot.camera()
    }

    /// State for scripts that wait.
    pub fn state(&self) -> State {
        let settled = self.tracer.settled();
        let samples = if settled { self.tracer.progress().samples } else { 0 };
        let stopped = settled && (self.tracer.finished() || self.settings.paused && self.tracer.is_whole());
        let denoising = self.denoising.as_ref().is_some_and(|denoising| denoising.is_awaited(&self.tracer));
        State { samples, stopped, exporting: self.export.is_some(), happened: self.happened, denoising }
    }

    /// Title of the window.
    pub fn title(&self) -> String {
        let name = self.document.path().file_name().unwrap_or_default().to_string_lossy();
        format!("{name}{} - raggio", if self.document.is_modified() { " *" } else { "" })
    }

    /// Traces on another device; the film begins anew.
    pub fn set_device(&mut self, device: Box<dyn Device>) -> Result<(), ViewError> {
        if let Some(export) = self.export.take() {
            self.notices.fail(format!("{} was not written: its device is gone", export.path().display()));
        }
        self.reading = None;
        self.tracer.set_device(device)?;
        // An edit may have reached the document alone before the old one was lost.
        self.tracer.set_scene(self.document.scene(), self.pilot.camera())
    }

    /// Whether something is going on that needs another frame.
    pub fn is_busy(&self) -> bool {
        let tracing = !self.tracer.is_whole() || !self.settings.paused && !self.tracer.finished();
        let watching = self.watch.as_ref().is_some_and(Watch::is_waiting)
            || self.kernels.as_ref().is_some_and(KernelWatch::is_waiting);
        let denoising = self.denoising.as_ref().is_some_and(|denoising| denoising.is_busy(&self.tracer));
        tracing || watching || denoising || self.export.is_some() || self.pilot.is_moving()
    }

    /// Executes the commands of panels, keys and scripts. A failure becomes a notice; a device that was lost is an
    /// error, after all has been tried.
    pub fn apply(&mut self, commands: Vec<Command>) -> Result<(), ViewError> {
        let mut outcome = Ok(());
        for command in commands {
            let done = self.attempt(|viewer| viewer.execute(command));
            outcome = outcome.and(done);
        }
        outcome
    }

    /// Tries something and says what failed; only the loss of a device is passed on.
    pub(crate) fn attempt(&mut self, what: impl FnOnce(&mut Self) -> Result<(), ViewError>) -> Result<(), ViewError> {
        match what(self) {
            Err(error) if !error.is_device_lost() => {
                self.notices.fail(error);
                Ok(())
            }
            outcome => outcome,
        }
    }

    /// Selects a shape, or none; a shape that the scene does not have cannot be selected.
    fn select(&mut self, shape: Option<usize>) {
        let scene = self.document.scene();
        self.selection = shape.filter(|shape| *shape < scene.entries.len());
        self.outline = self.selection.and_then(|shape| extent(scene.shapes_of(shape)));
    }

    fn execute(&mut self, command: Command) -> Result<(), ViewError> {
        match command {
            Command::Edit(edit) => return self.edit(edit),
            Command::EndGesture => self.document.end_gesture(),
            Command::Undo => return self.undo(),
            Command::Redo => return self.redo(),
            Command::RemoveSelected => return self.remove_selected(),
            Command::DuplicateSelected => return self.duplicate_selected(),
            Command::Select(shape) => self.select(shape),
            Command::Save(path) => return self.save(path),
            Command::Reload => return self.reload(),
            Command::Open(path) => return self.open(&path),
            Command::Navigate(navigate) => return self.navigate(navigate),
            Command::Preset(preset) => self.pilot.set_preset(preset),
            Command::Speed(speed) => self.pilot.set_speed(speed),
            Command::Look(look) => return self.show(look),
            Command::View(view) => return self.show(Look { view, ..self.settings.look }),
            Command::Exposure(exposure) => return self.show(Look { exposure, ..self.settings.look }),
            Command::Tones(tone_mapper) => return self.show(Look { tone_mapper, ..self.settings.look }),
            Command::Compare(comparison) => return self.show(Look { comparison, ..self.settings.look }),
            Command::Denoise(on) => return self.set_denoising(on),
            Command::DenoiseInMotion(way) => self.settings.denoise_in_motion = way,
            Command::Reference(path) => return self.compare_with(path),
            Command::Pause => self.settings.paused = !self.settings.paused,
            Command::Restart => return self.tracer.restart(),
            Command::StopAt(limit) => {
                self.settings.limit = limit.map(|samples| samples.max(1));
                self.tracer.set_limit(self.settings.limit);
            }
            Command::SamplesPerFrame(samples) => {
                self.settings.samples_per_frame = samples.map(|samples| samples.max(1));
                self.tracer.set_samples_per_frame(self.settings.samples_per_frame);
            }
            Command::SceneSize(scene_size) => self.settings.scene_size = scene_size,
            Command::Fill(fill) => self.settings.fill = fill,
            Command::Export(request) => return self.begin_export(&request),
            Command::CancelExport => self.export = None,
            Command::Screenshot(path) => {
                self.outgoing.screenshot = Some(path.unwrap_or_else(|| self.screenshot_name()))
            }
            Command::Panels => {
                self.settings.panels = !self.settings.panels;
                if self.settings.panels && !self.roomy {
                    self.notices.done("the panels are shown when the window is wider");
                }
            }
            Command::Help => self.settings.help = !self.settings.help,
            Command::CopyCamera => {
                self.outgoing.text = Some(crate::document::camera_text(self.camera()));
                self.notices.done("the camera is on the clipboard");
            }
            Command::PasteCamera(text) => match crate::document::camera_from_text(&text) {
                Ok(camera) => return self.navigate(Navigate::Go(camera)),
                Err(message) => self.notices.fail(format!("what is on the clipboard is no camera: {message}")),
            },
            Command::Section(section) => self.clock.enter(section),
            Command::LoseDevice => {
                if let Some(vulkan) = self.tracer.device().vulkan() {
                    vulkan.pretend_lost();
                }
            }
            Command::Complain(text) => self.notices.fail(text),
            Command::Quit => self.outgoing.quit = true,
        }
        Ok(())
    }

    fn navigate(&mut self, navigate: Navigate) -> Result<(), ViewError> {
        match navigate {
            Navigate::Jump(camera) => {
                self.pilot.jump(camera);
                self.follow_camera(false)?;
            }
            Navigate::Go(camera) => self.pilot.go(camera),
            Navigate::Orbit(degrees) => {
                self.pilot.orbit(degrees.to_radians());
                self.follow_camera(true)?;
            }
            Navigate::Home => self.pilot.go(self.document.scene().camera.clone()),
            Navigate::FocusOn(shape) => self.pilot.focus_on(self.document.scene(), shape, self.tracer.aspect()),
            Navigate::FocusAt([x, y]) => {
                if let Some(pick) = self.tracer.pick(x, y)? {
                    self.pilot.set_focus(pick.position);
                    self.follow_camera(false)?;
                }
            }
            Navigate::From(direction) => self.pilot.look_from(direction.into()),
            Navigate::Store(number) => {
                self.pilot.store(number);
                self.notices.done(format!("this view is number {number}"));
            }
            Navigate::Recall(number) => {
                if !self.pilot.recall(number) {
                    self.notices.done(format!("there is no view {number} yet: Ctrl+{number} stores one"));
                }
            }
        }
        Ok(())
    }

    /// Moves the camera as hands say, `seconds` after the last frame.
    pub(crate) fn steer(&mut self, hands: &Hands, seconds: f64) -> Result<(), ViewError> {
        let before = self.pilot.camera().clone();
        let tracer = &mut self.tracer;
        if !self.pilot.steer(hands, seconds, |[x, y]| tracer.pick(x, y))? {
            return Ok(());
        }
        // The move may fail, such as into more bodies than a path can remember.
        self.follow_camera(true).inspect_err(|_| self.pilot.jump(before))
    }

    /// Whether the panels are shown.
    pub(crate) fn shows_panels(&self) -> bool {
        self.settings.panels && self.roomy
    }

    /// Takes over the size of the picture's place, in pixels; the scene's own size stays if that was chosen.
    pub(crate) fn resize(&mut self, size: [u32; 2]) -> Result<(), ViewError> {
        if !self.settings.scene_size {
            return self.tracer.set_size(size);
        }
        let render = &self.document.scene().render;
        let outcome = self.tracer.set_size([render.width, render.height]);
        self.settings.scene_size = outcome.is_ok();
        outcome
    }

    /// Width and height of the picture in a room, in the room's own unit: the scene's frame, as large as it fits, unless
    /// all of the room is to be filled.
    pub(crate) fn proportions(&self, width: f32, height: f32) -> [f32; 2] {
        if self.settings.fill && !self.settings.scene_size {
            return [width, height];
        }
        let render = &self.document.scene().render;
        let (across, down) = (render.width as f32, render.height as f32);
        let scale = (width / across).min(height / down);
        [across * scale, down * scale]
    }

    /// Time for which nothing changes by itself.
    pub(crate) fn patience(&self) -> Duration {
        self.notices.patience()
    }

    /// Hands the pilot's camera to the tracer.
    pub(crate) fn follow_camera(&mut self, moving: bool) -> Result<(), ViewError> {
        self.tracer.set_camera(self.pilot.camera(), moving)
    }
}
