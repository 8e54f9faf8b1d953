//! PNG, JPEG, WebP, BMP, TGA and TIFF.

use std::io::Cursor;

use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use crate::bitmap::{Bitmap, Texels};
use crate::error::Problem;
use crate::format::Format;
use crate::guard::{grouped, radiance};
use crate::limits::Limits;

/// Decodes an image of one of these formats.
pub(crate) fn decode(format: Format, bytes: &[u8], limits: &Limits) -> Result<Bitmap, Problem> {
    let failed = |error| problem(format, error);
    let mut allowed = image::Limits::no_limits();
    allowed.max_alloc = Some(limits.most_bytes);
    let library_format = library_format(format).ok_or(Problem::UnknownFormat)?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), library_format);
    reader.limits(allowed);
    let decoder = reader.into_decoder().map_err(failed)?;
    let (width, height) = decoder.dimensions();
    let pixels = u64::from(width) * u64::from(height);
    limits.check(width.into(), height.into(), texel_bytes(decoder.color_type()))?;
    if pixels > most_pixels_per_byte(format).saturating_mul(bytes.len() as u64) {
        return Err(Problem::malformed(format, format!("{} bytes cannot hold {width} x {height} pixels", bytes.len())));
    }
    let texels = texels(DynamicImage::from_decoder(decoder).map_err(failed)?)?;
    Ok(Bitmap { width, height, texels })
}

fn library_format(format: Format) -> Option<ImageFormat> {
    match format {
        Format::Png => Some(ImageFormat::Png),
        Format::Jpeg => Some(ImageFormat::Jpeg),
        Format::WebP => Some(ImageFormat::WebP),
        Format::Bmp => Some(ImageFormat::Bmp),
        Format::Tga => Some(ImageFormat::Tga),
        Format::Tiff => Some(ImageFormat::Tiff),
        Format::Hdr | Format::Exr | Format::Ktx2 => None,
    }
}

/// Most pixels that a byte of the file can stand for, where the format sets a limit.
fn most_pixels_per_byte(format: Format) -> u64 {
    match format {
        // A block of 8 x 8 pixels takes at least a bit.
        Format::Jpeg => 512,
        // A run of at most 128 pixels takes at least two bytes.
        Format::Tga => 64,
        _ => u64::MAX,
    }
}

/// The library's error as one of ours.
pub(crate) fn problem(format: Format, error: image::ImageError) -> Problem {
    match error {
        image::ImageError::Unsupported(error) => Problem::unsupported(format, error),
        error => Problem::malformed(format, error),
    }
}

fn texel_bytes(color: ColorType) -> u64 {
    match color {
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => 8,
        ColorType::Rgb32F | ColorType::Rgba32F => 12,
        _ => 4,
    }
}

/// Texels of the image: grey becomes red, green and blue alike, and alpha is 1 where there is none.
fn texels(image: DynamicImage) -> Result<Texels, Problem> {
    Ok(match image.color() {
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            Texels::Rgba16(grouped(image.into_rgba16().into_raw())?)
        }
        ColorType::Rgb32F | ColorType::Rgba32F => {
            let mut texels: Vec<[f32; 3]> = grouped(image.into_rgb32f().into_raw())?;
            texels.as_flattened_mut().iter_mut().for_each(|value| *value = radiance(*value, f32::MAX));
            Texels::Rgb32F(texels)
        }
        _ => Texels::Rgba8(grouped(image.into_rgba8().into_raw())?),
    })
}
