//! The one error of this crate.

use std::fmt;

/// A problem of a mesh file, and its place.
///
/// The error is displayed as `file:line: message`, `file: byte 84: message`, or `file: message`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{place}: {message}")]
pub struct ModelError {
    /// The file, as the caller named it.
    pub file: String,
    /// Place in the file.
    pub place: Place,
    /// One sentence that says what is wrong and what would be right.
    pub message: String,
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line of a text, counted from 1.
    Line(usize),
    /// An offset in bytes, counted from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Byte(byte) => write!(f, ": byte {byte}"),
        }
    }
}

/// A problem whose file is not known yet.
#[derive(Debug)]
pub(crate) struct Fault {
    place: Place,
    message: String,
}

impl Fault {
    pub(crate) fn new(place: Place, message: impl Into<String>) -> Self {
        Self { place, message: message.into() }
    }

    pub(crate) fn whole(message: impl Into<String>) -> Self {
        Self::new(Place::Whole, message)
    }

    pub(crate) fn line(line: usize, message: impl Into<String>) -> Self {
        Self::new(Place::Line(line), message)
    }

    /// The error of this fault in the file called `file`.
    pub(crate) fn of(self, file: &str) -> ModelError {
        ModelError { file: file.to_string(), place: self.place, message: self.message }
    }
}
