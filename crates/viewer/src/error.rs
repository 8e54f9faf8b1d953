use std::path::PathBuf;

use raggio_denoise::DenoiseError;
use raggio_render::{DeviceError, InputError, OutputError, TooLarge, TranslationError};
use raggio_scene::SceneError;
use raggio_vulkan::VulkanError;

use crate::document::EditError;

/// Reason why the window cannot open, or had to close, or why a command failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The scene file is wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene is too much for any device.
    #[error(transparent)]
    Translation(#[from] TranslationError),
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// Vulkan failed.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// A picture cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A picture that is too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// A picture cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The scene cannot be changed like that.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// A picture cannot be denoised.
    #[error(transparent)]
    Denoise(#[from] DenoiseError),
    /// A script is wrong.
    #[error("{file}:{line}: {message}")]
    Script {
        /// Name of the script's file, as the user gave it.
        file: String,
        /// Number of the line, counted from 1.
        line: usize,
        /// Message of what is wrong, and what would be right.
        message: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Message of the failure.
        message: String,
    },
    /// The window had to close over unsaved changes.
    #[error("{error}; changes that were not saved are in {}", path.display())]
    Rescued {
        /// Error that closed the window.
        error: Box<ViewError>,
        /// File of the scene with the changes.
        path: PathBuf,
    },
    /// A window cannot open, for lack of a display or a library.
    #[error("cannot open a window: {0}; `raggio render` needs none")]
    NoDisplay(String),
}

impl ViewError {
    /// Whether the device has forgotten all that it held.
    pub fn is_device_lost(&self) -> bool {
        matches!(
            self,
            Self::Vulkan(VulkanError::DeviceLost) | Self::Device(DeviceError::Vulkan(VulkanError::DeviceLost))
        )
    }

    /// Whether the user can put the error right: exit status 2, not 3.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Rescued { error, .. } => error.is_input(),
            _ => !matches!(self, Self::Device(_) | Self::Vulkan(_) | Self::NoDisplay(_)),
        }
    }
}
