use std::path::Path;

use raggio_render::{DenoiseError, DeviceError, FilmError, OutputError, RenderError, TooLarge};
use raggio_scene::{SceneError, display_name};
#[cfg(feature = "window")]
use raggio_viewer::ViewError;

/// Failure of the program. Whose fault it is decides the exit status; the text is one sentence for the user.
#[derive(Debug)]
pub enum Failure {
    /// Fault of the scene, the arguments or the place to write to: status 2.
    Input(String),
    /// Fault of the device: status 3.
    Device(String),
    /// File that could not be written in its place, while the film is saved: status 4.
    Unwritten(String),
    /// End by a signal, whose number this is; the user has what there was by then, and nothing is to be said: the status is
    /// 128 and the number, as shells have it.
    Interrupted(u8),
}

impl Failure {
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Input(_) => 2,
            Self::Device(_) => 3,
            Self::Unwritten(_) => 4,
            Self::Interrupted(signal) => 128 + signal,
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Input(message) | Self::Device(message) | Self::Unwritten(message) => f.write_str(message),
            Self::Interrupted(_) => f.write_str("interrupted"),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<FilmError> for Failure {
    fn from(error: FilmError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Device(error) => error.into(),
            error => Self::Input(error.to_string()),
        }
    }
}

impl From<TooLarge> for Failure {
    fn from(error: TooLarge) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<DenoiseError> for Failure {
    fn from(error: DenoiseError) -> Self {
        // It may name a folder of the user's.
        Self::Input(display_name(error.to_string().as_ref()))
    }
}

impl From<DeviceError> for Failure {
    fn from(error: DeviceError) -> Self {
        Self::Device(error.to_string())
    }
}

#[cfg(feature = "window")]
impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Self {
        if error.is_input() { Self::Input(error.to_string()) } else { Self::Device(error.to_string()) }
    }
}

/// Failure to write a file that was asked for.
pub fn cannot_write(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Input(format!("cannot write {}: {error}", display_name(path)))
}
