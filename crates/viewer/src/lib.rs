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
pub mod navigation;
mod notices;
mod options;
mod overlay;
mod panel;
mod pilot;
mod play;
mod report;
mod screen;
mod stage;
mod tracer;
mod viewer;
mod wake;
mod watch;
mod window;

pub use clock::Pacing;
pub use error::ViewError;
pub use options::Options;
pub use report::Report;

/// Shows a scene until the window is closed, or the script is over.
///
/// # Errors
/// A [`ViewError`] when the window cannot open, scene or script are wrong, or the window has to close.
pub fn view(options: &Options) -> Result<Report, ViewError> {
    if options.hidden { hidden::run(options) } else { window::run(options, stage::Files::read(options)?) }
}
