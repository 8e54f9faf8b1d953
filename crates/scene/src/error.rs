//! The one error of this crate.

/// What is wrong with a scene, and where.
///
/// Displayed as `file:line:column: message`, or `file: message` when there is no place to name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {message}", place(.file, *.line, *.column))]
pub struct SceneError {
    /// The file, as the caller named it.
    pub file: String,
    /// Counted from 1; 0 when the error is about the file as a whole.
    pub line: usize,
    /// In characters, counted from 1; 0 when the error is about the file as a whole.
    pub column: usize,
    /// One sentence: what is wrong, what would be right.
    pub message: String,
}

impl SceneError {
    /// An error about the file as a whole.
    pub(crate) fn whole_file(file: impl Into<String>, message: impl Into<String>) -> Self {
        Self { file: file.into(), line: 0, column: 0, message: message.into() }
    }
}

/// `file:line:column`, without the numbers where the line is 0.
pub(crate) fn place(file: &str, line: usize, column: usize) -> String {
    if line == 0 { file.to_string() } else { format!("{file}:{line}:{column}") }
}
