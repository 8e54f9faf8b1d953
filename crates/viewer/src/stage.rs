//! Viewer, screen and script: all that a frame needs, whether a window shows it or nobody; and what to do when the
//! device is lost.

use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{PlatformOutput, RawInput};
use raggio_render::{Device, DeviceChoice, OpenOptions, OutputError, OutputFile};
use raggio_scene::counted;
use raggio_vulkan::{Canvas, DeviceKind, Instance, Surface, VulkanError};

use crate::document::Document;
use crate::error::ViewError;
use crate::options::Options;
use crate::play::{Player, WindowStep};
use crate::screen::{SMALLEST, Screen};
use crate::tracer::{Tracer, Translated};
use crate::viewer::Viewer;
use crate::wake::Wake;

/// Time that a device has to last: lost again sooner, it is not worth another try.
const HEALTHY: Duration = Duration::from_secs(10);

/// A viewer on its screen.
pub struct Stage {
    pub viewer: Viewer,
    pub screen: Screen,
    player: Option<Player>,
    opener: Opener,
    recovered: Option<Instant>,
    last: Instant,
}

/// The files that have to be right before a window opens.
pub struct Files {
    document: Document,
    player: Option<Player>,
    /// Scene that was translated before there was a device for it.
    translated: Option<Translated>,
}

impl Files {
    /// Reads scene and script.
    pub fn read(options: &Options) -> Result<Self, ViewError> {
        let player = options.play.as_deref().map(Player::load).transpose()?;
        let document = Document::open_with(&options.scene, options.assets.clone())?;
        document.check_apart(&options.outputs)?;
        Ok(Self { document, player, translated: None })
    }

    /// Translates the scene for a picture of `size` pixels.
    pub fn translate(&mut self, size: [u32; 2]) -> Result<(), ViewError> {
        let size = size.map(|side| side.max(SMALLEST));
        self.translated = Some(Translated::new(self.document.scene(), size)?);
        Ok(())
    }
}

/// Opens the device that the user has chosen, as often as need be.
pub struct Opener {
    choice: DeviceChoice,
    options: OpenOptions,
    instance: Arc<Instance>,
    /// Device that was opened before somebody has asked for it.
    ahead: Option<Opened>,
}

/// Device that was opened, or the reason why not, and what is to be said of it.
struct Opened {
    device: Result<Box<dyn Device>, ViewError>,
    warnings: Vec<String>,
}

/// Requests of a frame to the window.
pub struct Outcome {
    pub platform: PlatformOutput,
    pub window: Vec<WindowStep>,
    /// Delay after which the next frame is due; `None`: at the next event.
    pub next: Option<Duration>,
    pub quit: bool,
    /// Whether egui is another one, since the device or the surface was lost.
    pub renewed: bool,
}

impl Opener {
    /// Creates an opener; `instance` can show what the window needs.
    pub fn new(options: &Options, instance: Arc<Instance>) -> Self {
        let choice = options.device;
        let options = OpenOptions { instance: Some(instance.clone()), ..options.open.clone() };
        Self { choice, options, instance, ahead: None }
    }

    /// Opens the device for who asks for it next.
    pub fn open_ahead(&mut self) {
        let warnings = RefCell::new(vec![]);
        let device = self.open(|warning| warnings.borrow_mut().push(warning.to_owned()));
        self.ahead = Some(Opened { device, warnings: warnings.into_inner() });
    }

    fn open(&mut self, warn: impl Fn(&str)) -> Result<Box<dyn Device>, ViewError> {
        if let Some(Opened { device, warnings }) = self.ahead.take() {
            warnings.iter().for_each(|warning| warn(warning));
            return device;
        }
        Ok(raggio_render::open(self.choice, self.options.clone(), warn)?)
    }

    /// Opens the CPU, which is always there.
    fn open_cpu(&self) -> Result<Box<dyn Device>, ViewError> {
        Ok(raggio_render::open(DeviceChoice::Cpu, self.options.clone(), |_| ())?)
    }

    /// The device that draws the frames: the one that traces, if it can.
    fn presenter(
        &self,
        tracing: &dyn Device,
        surface: Option<&Surface>,
    ) -> Result<Arc<raggio_vulkan::Device>, ViewError> {
        let shows = |physical: &raggio_vulkan::PhysicalDevice| {
            physical.draws && surface.is_none_or(|surface| surface.shows(physical))
        };
        if let Some(device) = tracing.vulkan().filter(|device| shows(device.physical())) {
            return Ok(device);
        }
        let mut able: Vec<_> =
            self.instance.devices()?.into_iter().filter(|p| p.missing.is_empty() && shows(p)).collect();
        able.sort_by_key(|physical| match physical.kind {
            DeviceKind::Discrete => 0,
            DeviceKind::Integrated => 1,
            DeviceKind::Virtual | DeviceKind::Other => 2,
            DeviceKind::Software => 3,
        });
        let physical = able.first().ok_or(VulkanError::NoWindows)?;
        Ok(raggio_vulkan::Device::new(physical)?)
    }
}

impl Stage {
    /// Shows `files`: opens the device, and a canvas of `size` pixels: in the window that `surface` is of, or hidden.
    pub fn new(
        options: &Options,
        files: Files,
        mut opener: Opener,
        surface: Option<Surface>,
        size: [u32; 2],
        wake: Wake,
    ) -> Result<Self, ViewError> {
        let Files { document, player, translated } = files;
        let warnings = RefCell::new(vec![]);
        let device = opener.open(|warning| warnings.borrow_mut().push(warning.to_owned()))?;
        let size = size.map(|side| side.max(SMALLEST));
        let canvas = canvas(&opener, &*device, surface, size)?;
        let mut viewer = match translated {
            Some(translated) => Viewer::with_tracer(document, Tracer::with_translated(device, translated)?, wake),
            None => Viewer::new(document, device, size, wake)?,
        };
        if player.is_some() {
            viewer.tracer.set_impatient();
        }
        viewer.outputs.clone_from(&options.outputs);
        if let Some(folder) = &options.watch_kernels {
            viewer.watch_kernels(folder)?;
        }
        warnings.into_inner().into_iter().for_each(|warning| viewer.notices.warn(warning));
        let screen = Screen::new(canvas);
        Ok(Self { viewer, screen, player, opener, recovered: None, last: Instant::now() })
    }

    /// The connection to Vulkan.
    pub fn instance(&self) -> Arc<Instance> {
        self.opener.instance.clone()
    }

    /// Draws one frame. `surface` makes the window's surface anew when it is needed.
    pub fn frame(
        &mut self,
        mut raw: RawInput,
        surface: &dyn Fn() -> Result<Option<Surface>, ViewError>,
    ) -> Result<Outcome, ViewError> {
        let now = Instant::now();
        let seconds = (now - std::mem::replace(&mut self.last, now)).as_secs_f64();
        let state = self.viewer.state();
        let played = self.player.as_mut().map(|player| player.frame(seconds, state)).unwrap_or_default();
        raw.events.extend(played.events);
        raw.focused |= self.player.is_some();

        let frame = match self.screen.frame(&mut self.viewer, raw, played.commands) {
            Ok(frame) => frame,
            Err(ViewError::Vulkan(VulkanError::SurfaceLost)) => return self.renew(surface, played.window),
            Err(error) if error.is_device_lost() => {
                let recovered = self.recover(&error).and_then(|()| self.renew(surface, played.window));
                return recovered.map_err(|_| self.rescue(error));
            }
            Err(error) => return Err(self.rescue(error)),
        };
        // A frame that was not drawn is no picture; the next one will be.
        if frame.visible
            && let Some(path) = self.viewer.outgoing.screenshot.take()
        {
            self.keep(&path, frame.capture);
        }
        let next = match frame.next {
            // Nothing to draw on: no reason to hurry.
            Some(next) if !frame.visible => Some(next.max(Duration::from_millis(50))),
            _ if self.player.is_some() => Some(Duration::ZERO),
            next => next,
        };
        let quit = std::mem::take(&mut self.viewer.outgoing.quit);
        Ok(Outcome { platform: frame.platform, window: played.window, next, quit, renewed: false })
    }

    /// Opens the tracing device again, or goes on with the CPU; the film is gone with the old one. If the CPU traces,
    /// the device that was lost only drew the frames.
    fn recover(&mut self, error: &ViewError) -> Result<(), ViewError> {
        if self.viewer.tracer.device().vulkan().is_none() {
            return Ok(());
        }
        let samples = self.viewer.tracer.progress().samples;
        let again = self.recovered.replace(Instant::now()).is_some_and(|at| at.elapsed() < HEALTHY);
        let reopened = if again { None } else { self.opener.open(|_| ()).ok() };
        let what = if reopened.is_some() { "it was opened again" } else { "the CPU traces from here on" };
        let device = match reopened {
            Some(device) => self.viewer.with_kernels(device)?,
            None => self.opener.open_cpu()?,
        };
        self.viewer.set_device(device)?;
        let were = if samples == 1 { "was" } else { "were" };
        let lost = counted(samples as usize, "sample");
        self.viewer.notices.warn(format!("{error}; {what}, {lost} per pixel {were} lost"));
        Ok(())
    }

    /// Keeps unsaved changes beside the scene, for the window has to close; the error returned names their file.
    fn rescue(&self, error: ViewError) -> ViewError {
        match self.viewer.rescue() {
            Some(path) => ViewError::Rescued { error: Box::new(error), path },
            None => error,
        }
    }

    /// Makes a new canvas in place of one that cannot be used any more.
    fn renew(
        &mut self,
        surface: &dyn Fn() -> Result<Option<Surface>, ViewError>,
        window: Vec<WindowStep>,
    ) -> Result<Outcome, ViewError> {
        let size = self.screen.canvas().size();
        // A window has one surface at a time.
        self.screen.canvas().release();
        let canvas = canvas(&self.opener, self.viewer.tracer.device(), surface()?, size)?;
        self.screen = self.screen.moved_to(canvas);
        self.viewer.tracer.show_again();
        let platform = PlatformOutput::default();
        Ok(Outcome { platform, window, next: Some(Duration::ZERO), quit: false, renewed: true })
    }

    fn keep(&mut self, path: &Path, capture: Option<([u32; 2], Vec<u8>)>) {
        let Some((size, pixels)) = capture else {
            self.viewer.notices.fail("this display does not let its pictures be read");
            return;
        };
        let apart = OutputFile::new(path).and_then(|file| file.check_apart(self.viewer.document.files()));
        let apart = apart.map_err(|source| OutputError::Unwritable { path: path.into(), source });
        match apart.and_then(|()| raggio_render::write_png(path, size, &pixels)) {
            Ok(()) => self.viewer.notices.done(format!("wrote {}", path.display())),
            Err(error) => self.viewer.notices.fail(error),
        }
    }
}

fn canvas(opener: &Opener, device: &dyn Device, surface: Option<Surface>, size: [u32; 2]) -> Result<Canvas, ViewError> {
    let presenter = opener.presenter(device, surface.as_ref())?;
    Ok(match surface {
        Some(surface) => Canvas::for_window(&presenter, surface, size)?,
        None => Canvas::hidden(&presenter, size)?,
    })
}
