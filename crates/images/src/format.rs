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
    /// Windows' bitmap.
    Bmp,
    /// Truevision's Targa.
    Tga,
    /// Tagged Image File Format.
    Tiff,
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
            [b'B', b'M', ..] => Some(Self::Bmp),
            // The number is 43 where offsets have 64 bits.
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            [b'#', b'?', ..] => Some(Self::Hdr),
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => Some(Self::Ktx2),
            _ if is_tga(bytes) => Some(Self::Tga),
            _ => None,
        }
    }
}

/// Whether the bytes can be the header of a Targa, which begins with no signature: a kind of image, a palette where the
/// kind has one, a size and a depth.
fn is_tga(bytes: &[u8]) -> bool {
    const HEADER_BYTES: usize = 18;
    let Some(header) = bytes.first_chunk::<HEADER_BYTES>() else { return false };
    let [_, palette, kind, ..] = *header;
    let [.., width_low, width_high, height_low, height_high, depth, _] = *header;
    let kind_fits = match kind {
        1 | 9 => palette == 1 && matches!(depth, 8 | 16),
        2 | 10 => palette <= 1 && matches!(depth, 15 | 16 | 24 | 32),
        3 | 11 => palette <= 1 && matches!(depth, 8 | 16),
        _ => false,
    };
    kind_fits && (width_low | width_high) != 0 && (height_low | height_high) != 0
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Png => "a PNG",
            Self::Jpeg => "a JPEG",
            Self::WebP => "a WebP",
            Self::Bmp => "a BMP",
            Self::Tga => "a TGA",
            Self::Tiff => "a TIFF",
            Self::Hdr => "a Radiance HDR",
            Self::Exr => "an OpenEXR",
            Self::Ktx2 => "a KTX2",
        })
    }
}
