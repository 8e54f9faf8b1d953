//! Formats of image files, told by their first bytes.

use std::fmt;

/// A format of image files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics.
    Png,
    /// JPEG in JFIF or Exif.
    Jpeg,
    /// WebP.
    WebP,
    /// Radiance's RGBE.
    Hdr,
    /// OpenEXR.
    Exr,
    /// Khronos Texture 2.
    Ktx2,
}

impl Format {
    /// Format that the first bytes of a file tell, or `None` where they are of none of these.
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::WebP),
            [b'#', b'?', ..] => Some(Self::Hdr),
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Some(Self::Ktx2),
            _ => None,
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Png => "a PNG",
            Self::Jpeg => "a JPEG",
            Self::WebP => "a WebP",
            Self::Hdr => "a Radiance HDR",
            Self::Exr => "an OpenEXR",
            Self::Ktx2 => "a KTX2",
        })
    }
}
