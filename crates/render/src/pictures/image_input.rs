//! Pictures from disk.

use std::fs::File;
use std::io::{self, BufReader, Seek};
use std::path::{Path, PathBuf};

use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers, Vec2};
use image::{ImageDecoder, ImageReader};
use raggio_kernels::View;
use raggio_scene::display_name;

use crate::pictures::display::{Display, displayed};
use crate::pictures::film::{Film, FilmError};
use crate::pictures::format::PictureFormat;
use crate::pictures::linear_image::Image;

/// Most pixels of a picture that is read: 8192 x 8192.
const MOST_PIXELS: u64 = 1 << 26;

/// Reasons why a picture cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// An ending that names no format.
    #[error("{}: the ending must be {}", display_name(path), PictureFormat::listed())]
    UnknownFormat {
        /// Path of the file.
        path: PathBuf,
    },
    /// A file that cannot be opened or read.
    #[error("cannot read {}: {source}", display_name(path))]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A picture that is larger than any that is meant.
    #[error(
        "{}: {width}x{height} pixels are more than the {MOST_PIXELS} that a reference image may have",
        display_name(path)
    )]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// Width in pixels.
        width: u64,
        /// Height in pixels.
        height: u64,
    },
    /// A file that is not what its ending says, or is damaged.
    #[error("{}: not {format} image with red, green and blue that can be read: {reason}", display_name(path))]
    Malformed {
        /// Path of the file.
        path: PathBuf,
        /// Name of the format: `an OpenEXR` or `a PNG`.
        format: &'static str,
        /// Error of the format's reader.
        reason: String,
    },
    /// A film that cannot be read.
    #[error(transparent)]
    Film(#[from] FilmError),
}

impl Image {
    /// Reads an OpenEXR file, whose R, G and B are linear radiance, a PNG, whose sRGB is made linear, or a film. Opacity is
    /// left out, and what is not a number or infinite becomes black.
    ///
    /// # Errors
    /// An [`InputError`] when the file cannot be read, is no such picture, is damaged, or has more than 2^26 pixels.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        let format = PictureFormat::of_path(path).ok_or_else(|| InputError::UnknownFormat { path: path.into() })?;
        Self::load_as(path, format)
    }

    /// Reads a file of this format, as [`Image::load`] does, whatever its name ends in.
    pub(crate) fn load_as(path: &Path, format: PictureFormat) -> Result<Self, InputError> {
        let (format, read): (_, Reader) = match format {
            PictureFormat::Exr => ("an OpenEXR", read_exr),
            PictureFormat::Png => ("a PNG", read_png),
            PictureFormat::Film => return read_film(path),
        };
        let unreadable = |source| InputError::Unreadable { path: path.into(), source };
        let file = File::open(path).map_err(unreadable)?;
        if file.metadata().map_err(unreadable)?.is_dir() {
            return Err(unreadable(io::ErrorKind::IsADirectory.into()));
        }
        read(BufReader::new(file)).map_err(|fault| match fault {
            Fault::System(source) => unreadable(source),
            Fault::TooLarge(width, height) => InputError::TooLarge { path: path.into(), width, height },
            Fault::Malformed(reason) => InputError::Malformed { path: path.into(), format, reason },
        })
    }
}

/// A picture as it is looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisplayedImage {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Bytes red, green, blue in sRGB, row by row from the top left.
    pub pixels: Vec<u8>,
}

impl DisplayedImage {
    /// Reads a picture: a PNG as it is, others as `display` shows their radiance, before black where they have no background.
    ///
    /// # Errors
    /// The errors of [`Image::load`].
    pub fn load(path: &Path, display: Display) -> Result<Self, InputError> {
        if PictureFormat::of_path(path) == Some(PictureFormat::Png) {
            let picture = image::open(path).map_err(|error| match Fault::from(error) {
                Fault::System(source) => InputError::Unreadable { path: path.into(), source },
                Fault::TooLarge(width, height) => InputError::TooLarge { path: path.into(), width, height },
                Fault::Malformed(reason) => InputError::Malformed { path: path.into(), format: "a PNG", reason },
            })?;
            let picture = picture.into_rgba8();
            let [width, height] = [picture.width(), picture.height()].map(|side| side as usize);
            let over_black = |color: u8, alpha: u8| ((u32::from(color) * u32::from(alpha) + 127) / 255) as u8;
            let pixels = picture.pixels().flat_map(|pixel| {
                let [red, green, blue, alpha] = pixel.0;
                [red, green, blue].map(|color| over_black(color, alpha))
            });
            return Ok(Self { width, height, pixels: pixels.collect() });
        }
        let picture = Image::load(path)?;
        let shown = displayed(&Film::from_image(&picture), Display { view: View::Radiance, ..display });
        let pixels = shown.iter().flat_map(|pixel| [0, 8, 16].map(|shift| (pixel >> shift) as u8)).collect();
        Ok(Self { width: picture.width as usize, height: picture.height as usize, pixels })
    }
}

fn read_film(path: &Path) -> Result<Image, InputError> {
    let film = Film::read(path)?;
    let [width, height] = [film.width(), film.height()].map(u64::from);
    if width * height > MOST_PIXELS {
        return Err(InputError::TooLarge { path: path.into(), width, height });
    }
    Ok(film.mean())
}

/// Reader of one format.
type Reader = fn(BufReader<File>) -> Result<Image, Fault>;

/// An [`InputError`] that does not know its file yet.
enum Fault {
    System(io::Error),
    TooLarge(u64, u64),
    Malformed(String),
}

impl From<exr::error::Error> for Fault {
    fn from(error: exr::error::Error) -> Self {
        match error {
            exr::error::Error::Io(source) if source.kind() != io::ErrorKind::UnexpectedEof => Self::System(source),
            error => Self::Malformed(error.to_string()),
        }
    }
}

impl From<image::ImageError> for Fault {
    fn from(error: image::ImageError) -> Self {
        match error {
            image::ImageError::IoError(source) if source.kind() != io::ErrorKind::UnexpectedEof => Self::System(source),
            error => Self::Malformed(error.to_string()),
        }
    }
}

/// Checks the size of a picture, before anything is reserved for it.
fn check_size(width: u64, height: u64) -> Result<(), Fault> {
    if width.saturating_mul(height) > MOST_PIXELS { Err(Fault::TooLarge(width, height)) } else { Ok(()) }
}

fn read_exr(mut file: BufReader<File>) -> Result<Image, Fault> {
    for header in MetaData::read_from_buffered(&mut file, false)?.headers {
        check_size(header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    }
    file.rewind().map_err(Fault::System)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size: Vec2<usize>, _| (size.width(), vec![[0.0; 3]; size.area()]),
            |(width, pixels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = [r, g, b].map(|v| if v.is_finite() { v } else { 0.0 });
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(file)?;
    let size = image.layer_data.size;
    let (_, pixels) = image.layer_data.channel_data.pixels;
    Ok(Image { width: size.width() as u32, height: size.height() as u32, pixels, alpha: None })
}

fn read_png(file: BufReader<File>) -> Result<Image, Fault> {
    let decoder = ImageReader::with_format(file, image::ImageFormat::Png).into_decoder()?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into())?;
    let rgb = image::DynamicImage::from_decoder(decoder)?.into_rgb16();
    let pixels =
        rgb.pixels().map(|pixel| pixel.0.map(|value| srgb_decode(f64::from(value) / 65535.0) as f32)).collect();
    Ok(Image { width, height, pixels, alpha: None })
}

/// The inverse of the sRGB transfer function (IEC 61966-2-1).
fn srgb_decode(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}
