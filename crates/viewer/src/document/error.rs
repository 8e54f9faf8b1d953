//! Reasons why edits are refused.

use std::io;

use raggio_scene::{SceneError, counted};

/// Reason why a document did not change, or was not written. Nothing has changed when one is returned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The edited text would not be a valid scene; line and column are those of that text.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The file system refused to write the file.
    #[error("{path}: cannot be written: {source}")]
    Unwritable {
        /// The file, as messages name it.
        path: String,
        /// Error of the file system.
        source: io::Error,
    },
    /// An index out of range; the message counts from 1, as those about the file do.
    #[error("there is no {what} {}: the scene has {}", index + 1, counted(*count, what))]
    Missing {
        /// Kind of the list, `"shape"` or `"material"`.
        what: &'static str,
        /// The index, counted from 0.
        index: usize,
        /// Number of entries in the list.
        count: usize,
    },
    /// A path that leads nowhere, or a value that is not TOML; one sentence.
    #[error("{0}")]
    Path(String),
}

/// Returns `items[index]`, or [`EditError::Missing`] where it does not exist.
pub(super) fn item<'a, T>(items: &'a [T], index: usize, what: &'static str) -> Result<&'a T, EditError> {
    items.get(index).ok_or(EditError::Missing { what, index, count: items.len() })
}
