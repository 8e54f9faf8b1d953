//! The window of raggio: fly through a scene while its picture converges, and edit it.
//!
//! `events -> commands -> viewer -> samples -> canvas`: panels, keys and scripts say [`command::Command`]s, the viewer
//! alone changes anything, its tracer adds samples for as long as a frame has time, and a canvas shows the film with
//! the panels over it. A window and the hidden canvas of benchmarks and tests take the same way.

mod clock;
mod command;
mod denoising;
pub mod document;
mod error;
mod export;
mod extent;
mod fields;
mod hidden;
mod input;
mod kernels;
mod look;
mod names;
pub mod navigation;
mod notices;
mod overlay;
mod panel;
mod pilot;
mod play;
mod screen;
mod stage;
mod tracer;
mod viewer;
mod wake;
mod watch;
mod window;

use std::path::PathBuf;

use raggio_render::{DeviceChoice, OpenOptions};
use raggio_scene::AssetOptions;

pub use clock::Pacing;
pub use error::ViewError;

/// Options of the viewer: the scene, and how to show it.
#[derive(Clone)]
pub struct Options {
    /// The scene's file, or a model.
    pub scene: PathBuf,
    /// Options for reading models.
    pub assets: AssetOptions,
    /// Device that traces.
    pub device: DeviceChoice,
    /// Options for opening devices.
    pub open: OpenOptions,
    /// Size of the window, width and height: in points on a desktop, in pixels when hidden.
    pub size: [u32; 2],
    /// Scale factor, pixels in a point; `None`: that of the desktop, or 1 when hidden.
    pub scale: Option<f32>,
    /// A script to play.
    pub play: Option<PathBuf>,
    /// A folder of kernels to compile again whenever they change.
    pub watch_kernels: Option<PathBuf>,
    /// Whether there is no window: the script is played on a canvas that nobody sees.
    pub hidden: bool,
}

/// Report of the viewer after its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Name of the device that traced.
    pub device: String,
    /// Statistics of the frames of each section of the script.
    pub pacing: Vec<Pacing>,
    /// Messages of what failed in the end, in the words the user saw.
    pub failures: Vec<String>,
    /// Messages of Vulkan's validation layers, if they were on.
    pub validation_messages: Vec<String>,
}

impl Report {
    fn of(viewer: &mut viewer::Viewer, validation_messages: Vec<String>) -> Self {
        viewer.clock.enter(None);
        Self {
            device: viewer.tracer.device().name(),
            pacing: viewer.clock.pacing(),
            failures: viewer.notices.failures(),
            validation_messages,
        }
    }
}

/// Shows a scene until the window is closed, or the script is over.
///
/// # Errors
/// A [`ViewError`] when the window cannot open, scene or script are wrong, or the window has to close.
pub fn view(options: &Options) -> Result<Report, ViewError> {
    let files = stage::Files::read(options)?;
    if options.hidden { hidden::run(options, files) } else { window::run(options, files) }
}
