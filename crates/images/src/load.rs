//! Bitmaps from paths or bytes: the format is told by the magic bytes.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use image::ImageFormat;

use crate::bitmap::Bitmap;
use crate::error::{ImageError, Problem, printable};
use crate::format::Format;
use crate::guard::caught;
use crate::limits::Limits;
use crate::{ktx, openexr, raster};

/// Decodes the bytes of an image file.
///
/// # Errors
/// When the bytes are of no known format, are damaged, or hold more than `limits` allow. No file is named.
pub fn decode(bytes: &[u8], limits: &Limits) -> Result<Bitmap, ImageError> {
    read(bytes, limits).map_err(|problem| ImageError { file: None, problem })
}

/// Reads and decodes an image file; the format is told by its bytes, not by its extension.
///
/// # Errors
/// The errors are those of [`decode`], and one when the file cannot be read; the file is named.
pub fn load(path: &Path, limits: &Limits) -> Result<Bitmap, ImageError> {
    let result = bytes_of(path, limits.most_bytes).and_then(|bytes| read(&bytes, limits));
    result.map_err(|problem| ImageError { file: Some(printable(&path.display().to_string())), problem })
}

fn read(bytes: &[u8], limits: &Limits) -> Result<Bitmap, Problem> {
    if bytes.len() as u64 > limits.most_bytes {
        return Err(Problem::FileTooLarge { most: limits.most_bytes });
    }
    let format = Format::of_bytes(bytes).ok_or(Problem::UnknownFormat)?;
    caught(format, || match format {
        Format::Png => raster::decode(format, ImageFormat::Png, bytes, limits),
        Format::Jpeg => raster::decode(format, ImageFormat::Jpeg, bytes, limits),
        Format::WebP => raster::decode(format, ImageFormat::WebP, bytes, limits),
        Format::Hdr => raster::decode(format, ImageFormat::Hdr, bytes, limits),
        Format::Exr => openexr::decode(bytes, limits),
        Format::Ktx2 => ktx::decode(bytes, limits),
    })
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
