//! The one error of this crate.

use std::fmt;

use crate::format::Format;

/// Reason why there is no image. Displayed as `file: problem`, or as the problem alone where no file is known.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{problem}", Prefix(.file.as_deref()))]
pub struct ImageError {
    /// Name of the file, if there is one.
    pub file: Option<String>,
    /// Problem of the file or the bytes.
    pub problem: Problem,
}

/// Fault of an image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// The bytes are of none of the known formats.
    #[error("is not an image that can be read: PNG, JPEG, WebP, BMP, TGA, TIFF, Radiance HDR, OpenEXR and KTX2 can")]
    UnknownFormat,
    /// The file is larger than [`Limits::most_bytes`](crate::Limits::most_bytes).
    #[error("has more than {most} bytes, the most that an image may have")]
    FileTooLarge {
        /// Largest number of bytes allowed.
        most: u64,
    },
    /// The image has more pixels than [`Limits::most_pixels`](crate::Limits::most_pixels), or takes more memory than
    /// [`Limits::most_bytes`](crate::Limits::most_bytes).
    #[error("has {width} x {height} pixels: at most {most_pixels} pixels and {most_bytes} bytes of texels are allowed")]
    TooManyPixels {
        /// Width in pixels, as declared.
        width: u64,
        /// Height in pixels, as declared.
        height: u64,
        /// Largest number of pixels allowed.
        most_pixels: u64,
        /// Largest number of bytes of texels allowed.
        most_bytes: u64,
    },
    /// The file may be valid, but is of a kind that is not read.
    #[error("is {format} of a kind that is not read: {reason}")]
    Unsupported {
        /// Format of the file.
        format: Format,
        /// Kind of the file, and what would be right.
        reason: String,
    },
    /// The file is damaged.
    #[error("is {format} that is damaged: {reason}")]
    Malformed {
        /// Format of the file.
        format: Format,
        /// Damage found by the decoder.
        reason: String,
    },
}

impl Problem {
    pub(crate) fn malformed(format: Format, reason: impl fmt::Display) -> Self {
        Self::Malformed { format, reason: printable(&reason.to_string()) }
    }

    pub(crate) fn unsupported(format: Format, reason: impl fmt::Display) -> Self {
        Self::Unsupported { format, reason: printable(&reason.to_string()) }
    }
}

/// Escapes control characters of files in a message, because messages go to terminals.
pub(crate) fn printable(text: &str) -> String {
    let escape = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(escape).collect()
}

struct Prefix<'a>(Option<&'a str>);

impl fmt::Display for Prefix<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |file| write!(f, "{file}: "))
    }
}
