//! Formats of pictures' files.

use std::path::Path;

use raggio_choice::{Choice, choice, format_of};

choice! {
    /// Format of a picture's file, told by its ending.
    pub enum PictureFormat: "picture format" {
        /// for looking at: tone-mapped, 8 or 16 bits, sRGB
        Png = "png",
        /// linear radiance: unclamped, 32-bit floating point, with layers
        Exr = "exr",
        /// sums of samples: adds up with films of other samples, to the picture of all
        Film = "film",
    }
}

impl PictureFormat {
    /// Format that the ending tells, in upper or lower case; `None` where it tells none.
    pub fn of_path(path: &Path) -> Option<Self> {
        format_of(path)
    }

    /// Whether files of the format hold layers and metadata beside the picture.
    pub fn has_layers(self) -> bool {
        self == Self::Exr
    }

    /// Formats as help and errors list them: `.png (for looking at) or .exr (linear radiance)`.
    pub fn listed() -> String {
        let purpose = |format: &Self| format.description().split(':').next().unwrap_or_default();
        let kinds: Vec<_> = Self::ALL.iter().map(|format| format!(".{format} ({})", purpose(format))).collect();
        raggio_choice::listed(&kinds.iter().map(String::as_str).collect::<Vec<_>>())
    }
}
