//! Checkpoints: films with the state of their sampling, from which a render goes on as if nothing had happened.

mod gathered;
mod keeper;
mod lock;
mod state;

use std::path::{Path, PathBuf};

use raggio_scene::display_name;

use crate::devices::device::DeviceError;
use crate::pictures::film::{FilmError, MergeError};
use crate::pictures::output_file::appended;

pub(crate) use gathered::Gathered;
pub(crate) use keeper::Keeper;
pub(crate) use state::{AdaptiveState, Checkpoint, SamplingState};

/// Keeping of checkpoints while a render goes on.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoints {
    /// Path of the newest checkpoint. The one before it is kept as `PATH.previous`, and one that is being written is
    /// `PATH.part`.
    pub path: PathBuf,
    /// Work between two of them.
    pub every: Every,
    /// Whether to go on from the checkpoint, if there is one.
    pub resume: bool,
    /// Whether a render that takes a minute at most, as far as its rate tells, goes without.
    pub only_long: bool,
}

/// Work between two checkpoints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Every {
    /// Seconds.
    Seconds(f64),
    /// Samples of each pixel.
    Samples(u32),
}

impl Default for Every {
    fn default() -> Self {
        Self::Seconds(60.0)
    }
}

impl Checkpoints {
    /// Checkpoints beside `output`, as `OUTPUT.checkpoint`, of a render that takes long.
    pub fn beside(output: &Path) -> Self {
        Self { path: appended(output, ".checkpoint"), every: Every::default(), resume: false, only_long: true }
    }
}

/// Reasons why a render cannot go on from a checkpoint, or cannot have any.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// A place where no checkpoint can be written.
    #[error("cannot write checkpoints to {}: {source}", display_name(path))]
    Unwritable {
        /// Path of the checkpoint.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A checkpoint that another render keeps at this moment.
    #[error(
        "{} belongs to a render under way, {by}: wait for it, or name another with --checkpoint",
        display_name(path)
    )]
    InUse {
        /// Path of the checkpoint.
        path: PathBuf,
        /// Who it is, in words.
        by: String,
    },
    /// A file that cannot be read, or is no film.
    #[error("cannot go on from a checkpoint: {0}")]
    Unreadable(#[from] FilmError),
    /// A film that does not say how its sampling goes on.
    #[error("cannot go on from {}: it is a film, and no checkpoint", display_name(path))]
    NoCheckpoint {
        /// Path of the file.
        path: PathBuf,
    },
    /// A checkpoint of another picture.
    #[error(
        "cannot go on from {}: {}: render as it was rendered, or remove it to begin anew",
        display_name(path),
        reason(difference)
    )]
    Other {
        /// Path of the checkpoint.
        path: PathBuf,
        /// Difference of the picture, first, and the checkpoint, second.
        difference: Box<MergeError>,
    },
    /// A checkpoint of other samples than those that were asked for.
    #[error(
        "cannot go on from {}: it has samples {}..{}, and {}..{} are to be rendered",
        display_name(path), found[0], found[1], wanted[0], wanted[1]
    )]
    Samples {
        /// Path of the checkpoint.
        path: PathBuf,
        /// First sample of the checkpoint and the one after its last.
        found: [u32; 2],
        /// First sample that was asked for and the one after the last.
        wanted: [u32; 2],
    },
    /// A device that failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

/// Difference of a render and its checkpoint, in words.
fn reason(difference: &MergeError) -> String {
    match difference {
        MergeError::Size(now, then) => {
            format!("it has {}x{} pixels, and the picture is to have {}x{}", then[0], then[1], now[0], now[1])
        }
        MergeError::Version(now, then) => format!("it was made by raggio {then}, and this is raggio {now}"),
        MergeError::Scene => "it is of another scene, or of this one before it was changed".into(),
        MergeError::Setting { key, first, second } => {
            let value = |value: &str| if value.is_empty() { "none".into() } else { format!("`{value}`") };
            format!("it was made with {key} {}, and {key} is {} now", value(second), value(first))
        }
        other => other.to_string(),
    }
}
