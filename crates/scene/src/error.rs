//! The one error of this crate.

/// A problem of a scene and its place, and the scene's other problems.
///
/// Each problem is displayed in a line, as `file:line:column: message`, as `file:line: message` (a model's), or as
/// `file: message` when there is no place to name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {message}{}", place(.file, *.line, *.column), lines(.others))]
pub struct SceneError {
    /// The file, as the caller named it.
    pub file: String,
    /// Line, counted from 1; 0 when the error is about the file as a whole.
    pub line: usize,
    /// Column in characters, counted from 1; 0 when the error is about the line or the file as a whole.
    pub column: usize,
    /// One sentence that says what is wrong and what would be right.
    pub message: String,
    /// Problems that stand further down in the file; the last may say how many more there are.
    pub others: Vec<SceneError>,
}

impl SceneError {
    /// An error about the file as a whole.
    pub(crate) fn whole_file(file: impl Into<String>, message: impl Into<String>) -> Self {
        Self { file: file.into(), line: 0, column: 0, message: message.into(), others: Vec::new() }
    }
}

/// Place of an error as `file:line:column`, without the numbers that are 0.
pub(crate) fn place(file: &str, line: usize, column: usize) -> String {
    match (line, column) {
        (0, _) => file.to_string(),
        (_, 0) => format!("{file}:{line}"),
        _ => format!("{file}:{line}:{column}"),
    }
}

/// Errors, each in a line of its own that follows another.
fn lines(errors: &[SceneError]) -> String {
    errors.iter().map(|error| format!("\n{error}")).collect()
}
