//! Bitmaps from paths or bytes: the format is told by the magic bytes.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::bitmap::Bitmap;
use crate::error::{ImageError, Problem, printable};
use crate::format::Format;
use crate::guard::caught;
use crate::limits::Limits;
use crate::{hdr, ktx, openexr, raster};

/// An image, and what the user should know of how it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Texels of the image.
    pub bitmap: Bitmap,
    /// Warnings, one sentence each, without the file's name.
    pub warnings: Vec<String>,
}

impl Image {
    /// Decodes the bytes of an image file.
    ///
    /// # Errors
    /// When the bytes are of no known format, are damaged, or hold more than `limits` allow. No file is named.
    pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Self, ImageError> {
        read(bytes, limits).map_err(|problem| ImageError { file: None, problem })
    }

    /// Reads and decodes an image file; the format is told by its bytes, not by its extension.
    ///
    /// # Errors
    /// The errors are those of [`Image::decode`], and one when the file cannot be read; the file is named.
    pub fn load(path: &Path, limits: &Limits) -> Result<Self, ImageError> {
        let result = bytes_of(path, limits.most_bytes).and_then(|bytes| read(&bytes, limits));
        result.map_err(|problem| ImageError { file: Some(printable(&path.display().to_string())), problem })
    }
}

impl From<Bitmap> for Image {
    fn from(bitmap: Bitmap) -> Self {
        Self { bitmap, warnings: Vec::new() }
    }
}

/// Decodes the bytes of an image file, for callers who have no use for warnings.
///
/// # Errors
/// The errors are those of [`Image::decode`].
pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Bitmap, ImageError> {
    Image::decode(bytes, limits).map(|image| image.bitmap)
}

/// Reads and decodes an image file, for callers who have no use for warnings.
///
/// # Errors
/// The errors are those of [`Image::load`].
pub fn load(path: &Path, limits: &Limits) -> Result<Bitmap, ImageError> {
    Image::load(path, limits).map(|image| image.bitmap)
}

fn read(bytes: &[u8], limits: &Limits) -> Result<Image, Problem> {
    if bytes.len() as u64 > limits.most_bytes {
        return Err(Problem::FileTooLarge { most: limits.most_bytes });
    }
    let format = Format::of_bytes(bytes).ok_or(Problem::UnknownFormat)?;
    let bitmap = match format {
        // Several threads decompress the blocks, and each of them has a guard of its own.
        Format::Exr => return openexr::decode(bytes, limits),
        Format::Hdr => caught(format, || hdr::decode(bytes, limits)),
        Format::Ktx2 => caught(format, || ktx::decode(bytes, limits)),
        Format::Png | Format::Jpeg | Format::WebP | Format::Bmp | Format::Tga | Format::Tiff => {
            caught(format, || raster::decode(format, bytes, limits))
        }
    };
    bitmap.map(Image::from)
}

fn bytes_of(path: &Path, most: u64) -> Result<Vec<u8>, Problem> {
    let cannot = |error: io::Error| Problem::Unreadable(printable(&error.to_string()));
    let file = File::open(path).map_err(cannot)?;
    let metadata = file.metadata().map_err(cannot)?;
    if metadata.is_dir() {
        return Err(cannot(io::ErrorKind::IsADirectory.into()));
    }
    // Devices and pipes have no length, so the limit holds while reading, too.
    let mut bytes = Vec::new();
    if metadata.len() <= most {
        file.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(cannot)?;
    }
    let too_large = metadata.len() > most || bytes.len() as u64 > most;
    if too_large { Err(Problem::FileTooLarge { most }) } else { Ok(bytes) }
}
