//! Options of the viewer.

use std::path::PathBuf;
use std::time::Instant;

use raggio_render::{DeviceChoice, OpenOptions, OutputFile};
use raggio_scene::AssetOptions;

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
    /// Moment at which the program began, from which the time to the first picture counts.
    pub start: Instant,
    /// Files that are written when the viewer is over; no scene is shown that is made of one of them.
    pub outputs: Vec<OutputFile>,
}
