//! Pictures on disk, written whole or not at all.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, WritableImage};
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

use crate::pictures::aov::{Channel, Values};
use crate::pictures::display::{Display, displayed};
use crate::pictures::film::Film;
use crate::pictures::format::PictureFormat;
use crate::pictures::metadata::Metadata;

/// A file to be written.
#[derive(Clone, Debug)]
pub struct ImageFile {
    path: PathBuf,
    format: PictureFormat,
}

/// Layers and metadata that an EXR holds beside the picture.
#[derive(Clone, Debug, Default)]
pub struct Extras {
    /// Channels of layers, as `albedo.R`; as many values each as the picture has pixels.
    pub channels: Vec<Channel>,
    /// Record of how the picture was made.
    pub metadata: Option<Metadata>,
}

/// Reasons why a picture cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// An ending that names no format.
    #[error("{}: the ending must be {}", path.display(), PictureFormat::listed())]
    UnknownFormat {
        /// Path of the file.
        path: PathBuf,
    },
    /// A folder or file that cannot be written to.
    #[error("cannot write {}: {source}", path.display())]
    Unwritable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
}

impl ImageFile {
    /// Checks, before any work is spent, that `path` names a known format in a folder that can be written to.
    ///
    /// # Errors
    /// An [`OutputError`] when it does not.
    pub fn new(path: &Path) -> Result<Self, OutputError> {
        let Some(format) = PictureFormat::of_path(path) else {
            return Err(OutputError::UnknownFormat { path: path.into() });
        };
        let file = Self { path: path.into(), format };
        check_writable(path).map_err(|e| file.unwritable(e))?;
        Ok(file)
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the file can hold layers and metadata beside the picture.
    pub fn has_layers(&self) -> bool {
        self.format.has_layers()
    }

    /// File `NAME.denoised.ENDING` beside this one.
    ///
    /// # Errors
    /// An [`OutputError`] when it cannot be written to.
    pub fn denoised(&self) -> Result<Self, OutputError> {
        let mut ending = std::ffi::OsString::from("denoised.");
        ending.push(self.path.extension().unwrap_or_default());
        Self::new(&self.path.with_extension(ending))
    }

    /// Writes `film`, whole or not at all; PNGs are made as `display` says.
    ///
    /// # Errors
    /// An [`OutputError`] when the file cannot be written.
    pub fn write(&self, film: &Film, display: Display) -> Result<(), OutputError> {
        self.write_with(film, display, &Extras::default())
    }

    /// Writes `film` together with layers and metadata, which EXR alone has room for, whole or not at all.
    ///
    /// # Errors
    /// An [`OutputError`] when the file cannot be written.
    pub fn write_with(&self, film: &Film, display: Display, extras: &Extras) -> Result<(), OutputError> {
        let mut bytes = io::Cursor::new(Vec::new());
        match self.format {
            PictureFormat::Png => {
                let pixels = displayed(film, display);
                encode_png([film.width(), film.height()], bytemuck::cast_slice(&pixels), &mut bytes)
            }
            PictureFormat::Exr => write_exr(film, extras, &mut bytes),
        }
        .and_then(|()| write_whole(&self.path, bytes.get_ref()))
        .map_err(|e| self.unwritable(e))
    }

    fn unwritable(&self, source: io::Error) -> OutputError {
        OutputError::Unwritable { path: self.path.clone(), source }
    }
}

/// Writes `bytes` to `path`, whole or not at all: under a temporary name first, renamed when all of it has reached the
/// disk. A link is followed; a pipe or a device is written to as it is.
///
/// # Errors
/// The system's error when the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_whole_with(path, |file| file.write_all(bytes))
}

/// Writes to `path`, whole or not at all as [`write_whole`] does, the bytes that `write` writes; they need not be in
/// memory together.
pub(crate) fn write_whole_with(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let path = destination(path)?;
    if is_special(&path) {
        return write(&mut File::options().write(true).open(&path)?);
    }
    let mut temporary = temporary_beside(&path)?;
    write(temporary.as_file_mut())?;
    temporary.as_file().sync_all()?;
    temporary.persist(&path).map_err(|e| e.error)?;
    Ok(())
}

/// Finds out early whether [`write_whole`] can succeed.
///
/// # Errors
/// The system's error when it cannot.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let path = destination(path)?;
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !is_special(&path) {
        temporary_beside(&path)?;
    }
    Ok(())
}

/// Path of what `path` links to, or `path` itself.
fn destination(path: &Path) -> io::Result<PathBuf> {
    if path.is_symlink() && path.exists() { path.canonicalize() } else { Ok(path.into()) }
}

/// Whether there is something at `path` that is neither a file nor a folder.
fn is_special(path: &Path) -> bool {
    path.metadata().is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Temporary file in the folder of `path`, hidden, which vanishes unless it is kept.
fn temporary_beside(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".raggio-");
    // Permissions are those of any new file: the temporary one would be for its owner alone.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Writes `pixels` as they are to a PNG, whole or not at all: bytes red, green, blue, opacity, row by row from the top
/// left. Opacity is left out. `size` is width and height in pixels.
///
/// # Errors
/// An [`OutputError`] when the file cannot be written.
pub fn write_png(path: &Path, size: [u32; 2], pixels: &[u8]) -> Result<(), OutputError> {
    let mut bytes = io::Cursor::new(Vec::new());
    let outcome = encode_png(size, pixels, &mut bytes).and_then(|()| write_whole(path, bytes.get_ref()));
    outcome.map_err(|source| OutputError::Unwritable { path: path.into(), source })
}

fn encode_png([width, height]: [u32; 2], pixels: &[u8], to: &mut impl Write) -> io::Result<()> {
    let rgb: Vec<u8> = pixels.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    PngEncoder::new_with_quality(to, CompressionType::Best, FilterType::Adaptive)
        .write_image(&rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(io::Error::other)
}

fn write_exr(film: &Film, extras: &Extras, to: &mut io::Cursor<Vec<u8>>) -> io::Result<()> {
    let mean = film.mean();
    let (width, height) = (mean.width as usize, mean.height as usize);
    let color = |i: usize| FlatSamples::F32(mean.pixels.iter().map(|pixel| pixel[i]).collect());
    let colors = ["R", "G", "B"].into_iter().enumerate().map(|(i, name)| AnyChannel::new(name, color(i)));
    let others = extras.channels.iter().map(|channel| {
        let samples = match &channel.values {
            Values::F32(values) => FlatSamples::F32(values.clone()),
            Values::U32(values) => FlatSamples::U32(values.clone()),
        };
        AnyChannel::new(channel.name.as_str(), samples)
    });
    let channels = AnyChannels::sort(colors.chain(others).collect());
    let mut image = exr::prelude::Image::from_channels((width, height), channels);
    let attributes = &mut image.layer_data.attributes;
    let software = concat!("raggio ", env!("CARGO_PKG_VERSION"));
    attributes.software_name = Some(software.into());
    if let Some(metadata) = &extras.metadata {
        metadata.describe(attributes);
    }
    image.layer_data.encoding.compression = exr::prelude::Compression::ZIP16;
    // Otherwise blocks are written in the order in which threads compress them, and no two files are the same.
    image.layer_data.encoding.line_order = exr::prelude::LineOrder::Increasing;
    image.write().to_buffered(&mut *to).map_err(io::Error::other)?;
    sort_attributes(to.get_mut());
    Ok(())
}

/// Orders the attributes of an OpenEXR file of one part by their names: the library writes ours in another order each
/// time. Pixels stay where they are.
fn sort_attributes(file: &mut [u8]) {
    // Attributes begin after the magic number and the version; each has a name and a type that end with a zero, a
    // length and a value.
    const FIRST: usize = 8;
    let mut end = FIRST;
    let mut attributes = vec![];
    while file[end] != 0 {
        let start = end;
        for _ in 0..2 {
            end += file[end..].iter().take_while(|&&byte| byte != 0).count() + 1;
        }
        let length = u32::from_le_bytes([file[end], file[end + 1], file[end + 2], file[end + 3]]);
        end += 4 + length as usize;
        attributes.push(file[start..end].to_vec());
    }
    attributes.sort_unstable();
    file[FIRST..end].copy_from_slice(&attributes.concat());
}
