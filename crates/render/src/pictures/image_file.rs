//! Pictures on disk, written whole or not at all.

use std::io;
use std::path::{Path, PathBuf};

use raggio_scene::display_name;

use crate::pictures::aov::Channel;
use crate::pictures::display::{Display, Shown, shown, shown_16_bits};
use crate::pictures::exr_file::write_exr;
use crate::pictures::film::{Film, Note};
use crate::pictures::fingerprint;
use crate::pictures::format::PictureFormat;
use crate::pictures::linear_image::Image;
use crate::pictures::metadata::Metadata;
use crate::pictures::output_file::{OutputFile, write_whole};
use crate::pictures::png_file::{PngBits, encode_8_bits, encode_16_bits};

/// A picture's file to be written.
#[derive(Clone, Debug)]
pub struct ImageFile {
    file: OutputFile,
    format: PictureFormat,
    png_bits: PngBits,
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
    #[error("{}: the ending must be {}", display_name(path), PictureFormat::listed())]
    UnknownFormat {
        /// Path of the file.
        path: PathBuf,
    },
    /// A folder or file that cannot be written to.
    #[error("cannot write {}: {source}", display_name(path))]
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
        let file = OutputFile::new(path).map_err(|source| OutputError::Unwritable { path: path.into(), source })?;
        Ok(Self { file, format, png_bits: PngBits::Eight })
    }

    /// This file with so many bits to a channel, if it is a PNG.
    pub fn with_png_bits(self, png_bits: PngBits) -> Self {
        Self { png_bits, ..self }
    }

    /// This file with `folder` as its refuge, as [`OutputFile::with_refuge`] has it.
    pub fn with_refuge(self, folder: &Path) -> Self {
        Self { file: self.file.with_refuge(folder), ..self }
    }

    /// Format of the file.
    pub(crate) fn format(&self) -> PictureFormat {
        self.format
    }

    /// Bits of each channel, if it is a PNG.
    pub(crate) fn png_bits(&self) -> PngBits {
        self.png_bits
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The file without its format.
    pub fn file(&self) -> &OutputFile {
        &self.file
    }

    /// Checks that the file takes the place of none of `inputs`, as [`OutputFile::check_apart`] does.
    ///
    /// # Errors
    /// An [`OutputError`] that names the input.
    pub fn check_apart<'a>(&self, inputs: impl IntoIterator<Item = &'a Path>) -> Result<(), OutputError> {
        self.file.check_apart(inputs).map_err(|source| OutputError::Unwritable { path: self.path().into(), source })
    }

    /// Whether the file holds a film, which needs a [label](crate::Film::label), and no picture.
    pub fn is_film(&self) -> bool {
        self.format == PictureFormat::Film
    }

    /// Whether the file is a PNG, which is a picture as it is looked at.
    pub fn is_png(&self) -> bool {
        self.format == PictureFormat::Png
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
        ending.push(self.path().extension().unwrap_or_default());
        Ok(Self::new(&self.path().with_extension(ending))?.with_png_bits(self.png_bits))
    }

    /// Writes `film`, whole or not at all; PNGs are made as `display` says.
    ///
    /// # Errors
    /// An [`OutputError`] when the file cannot be written.
    pub fn write(&self, film: &Film, display: Display) -> Result<(), OutputError> {
        self.write_with(film, display, &Extras::default())
    }

    /// Writes the means of a film that is gone, as [`ImageFile::write_with`] writes the film: an EXR of the same bytes.
    ///
    /// # Errors
    /// An [`OutputError`] when the file cannot be written.
    pub fn write_image(&self, image: &Image, display: Display, extras: &Extras) -> Result<(), OutputError> {
        if self.format != PictureFormat::Exr {
            return self.write_with(&Film::from_image(image), display, extras);
        }
        let mut bytes = io::Cursor::new(Vec::new());
        let fingerprint = self.fingerprint(display, extras);
        self.finish(write_exr(image, extras, fingerprint.as_deref(), &mut bytes), bytes)
    }

    /// Writes `film` together with layers and metadata, which EXR alone has room for, whole or not at all.
    ///
    /// # Errors
    /// An [`OutputError`] when the file cannot be written.
    pub fn write_with(&self, film: &Film, display: Display, extras: &Extras) -> Result<(), OutputError> {
        let mut bytes = io::Cursor::new(Vec::new());
        let size = [film.width(), film.height()];
        let fingerprint = self.fingerprint(display, extras);
        let text = fingerprint.as_deref().map(|text| (fingerprint::NAME, text));
        let encoded = match (self.format, self.png_bits) {
            (PictureFormat::Png, PngBits::Eight) => encode_8_bits(size, &shown(film, display), text, &mut bytes),
            (PictureFormat::Png, PngBits::Sixteen) => {
                encode_16_bits(size, &shown_16_bits(film, display), text, &mut bytes)
            }
            (PictureFormat::Exr, _) => write_exr(&film.mean(), extras, fingerprint.as_deref(), &mut bytes),
            (PictureFormat::Film, _) => {
                let note: Vec<_> = text.map(|(name, text)| Note::new(name, text)).into_iter().collect();
                let written = self.file.write_with(&|to| film.write_to(to, &note));
                return written.map_err(|source| self.unwritable(source));
            }
        };
        self.finish(encoded, bytes)
    }

    /// Fingerprint of the file, if the picture is whole and has one.
    fn fingerprint(&self, display: Display, extras: &Extras) -> Option<String> {
        let metadata = extras.metadata.as_ref()?;
        metadata.fingerprint.map(|fingerprint| fingerprint.of(self, display, metadata.denoiser.as_deref()))
    }

    fn finish(&self, encoded: io::Result<()>, bytes: io::Cursor<Vec<u8>>) -> Result<(), OutputError> {
        let written = encoded.and_then(|()| self.file.write(bytes.get_ref()));
        written.map_err(|source| self.unwritable(source))
    }

    fn unwritable(&self, source: io::Error) -> OutputError {
        OutputError::Unwritable { path: self.path().into(), source }
    }
}

/// Writes `pixels` as they are to a PNG, whole or not at all: bytes red, green, blue, opacity, row by row from the top
/// left. Opacity is left out. `size` is width and height in pixels.
///
/// # Errors
/// An [`OutputError`] when the file cannot be written.
pub fn write_png(path: &Path, size: [u32; 2], pixels: &[u8]) -> Result<(), OutputError> {
    let mut bytes = Vec::new();
    let opaque =
        Shown { colors: pixels.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect(), alpha: None };
    let outcome = encode_8_bits(size, &opaque, None, &mut bytes).and_then(|()| write_whole(path, &bytes));
    outcome.map_err(|source| OutputError::Unwritable { path: path.into(), source })
}

/// PNG of a picture, as [`ImageFile`] writes it to a file.
///
/// # Errors
/// When the picture is larger than a PNG may be.
pub fn encode_png(image: &Image, display: Display) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    encode_8_bits([image.width, image.height], &shown(&Film::from_image(image), display), None, &mut bytes)?;
    Ok(bytes)
}
