//! Films on disk. docs/film.md describes the format.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use raggio_kernels::FilmPixel;
use raggio_scene::display_name;

use crate::devices::machine::{TooLarge, check_memory};
use crate::pictures::film::label::{Label, Note, Portion};
use crate::pictures::film::{Film, film_bytes};
use crate::pictures::output_file::write_whole_with;

/// First bytes: no text begins so, and a transfer that changes line endings changes them.
const MAGIC: [u8; 8] = *b"\x89FILM\r\n\x1a";
/// Latest version of the format: that of films with coverage, whose sums follow those of radiance.
const VERSION: u32 = 3;
/// Version of films without coverage.
const PLAIN_VERSION: u32 = 2;
/// Most bytes of a text, and most entries of a list, that a header is believed.
const LONGEST: u32 = 1 << 16;
/// Most bytes of a note's value: the blocks of the largest film that rest.
const LONGEST_NOTE: u32 = 1 << 24;
/// Longest side of a film in pixels.
const LONGEST_SIDE: u32 = 1 << 16;
/// Bytes that are read at a time: no more memory is taken for a file than it has.
const CHUNK: usize = 1 << 20;
/// Bytes of the checksum.
const CHECKSUM: usize = 32;

/// Reasons why a film cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// A file that cannot be opened or read.
    #[error("cannot read {}: {source}", display_name(path))]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A file of another kind.
    #[error("{}: not a film of raggio", display_name(path))]
    NotAFilm {
        /// Path of the file.
        path: PathBuf,
    },
    /// A film in a format that came later than this program.
    #[error(
        "{}: a film of format {found}, and this raggio reads format {VERSION}: use the raggio that wrote it",
        display_name(path)
    )]
    Version {
        /// Path of the file.
        path: PathBuf,
        /// Version of the file's format.
        found: u32,
    },
    /// A film that is cut short, or is not what was written.
    #[error("{}: the film is damaged: {reason}", display_name(path))]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// Damage that was found.
        reason: String,
    },
    /// A film that this machine has no memory for.
    #[error("{}: {source}", display_name(path))]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// Memory that is needed, and what there is.
        source: TooLarge,
    },
    /// A film without a label: nobody could tell later what it is of.
    #[error("the film does not say what it is of, and is not written")]
    Unlabelled,
    /// A folder or file that cannot be written to.
    #[error("cannot write {}: {source}", display_name(path))]
    Unwritable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
}

impl FilmError {
    /// The error with `path` in place of its own, which users know by another name.
    pub(crate) fn at(mut self, name: &Path) -> Self {
        match &mut self {
            Self::Unreadable { path, .. }
            | Self::NotAFilm { path }
            | Self::Version { path, .. }
            | Self::Damaged { path, .. }
            | Self::TooLarge { path, .. }
            | Self::Unwritable { path, .. } => *path = name.into(),
            Self::Unlabelled => {}
        }
        self
    }
}

/// Something wrong with a file whose path is not known yet.
enum Fault {
    System(io::Error),
    NotAFilm,
    Version(u32),
    Damaged(String),
    TooLarge(TooLarge),
}

impl Fault {
    /// The error of the file at `path`.
    fn of(self, path: &Path) -> FilmError {
        let path = path.to_path_buf();
        match self {
            Self::System(source) => FilmError::Unreadable { path, source },
            Self::NotAFilm => FilmError::NotAFilm { path },
            Self::Version(found) => FilmError::Version { path, found },
            Self::Damaged(reason) => FilmError::Damaged { path, reason },
            Self::TooLarge(source) => FilmError::TooLarge { path, source },
        }
    }
}

impl Film {
    /// Writes the film, its label and a checksum to `path`, whole or not at all.
    ///
    /// # Errors
    /// A [`FilmError`] when the film has no label, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FilmError> {
        if self.label().is_none() {
            return Err(FilmError::Unlabelled);
        }
        let written = write_whole_with(path, |to| self.write_to(to, &[]));
        written.map_err(|source| FilmError::Unwritable { path: path.into(), source })
    }

    /// Writes the film as [`Film::write`] does, with `more` notes, to a file that is open.
    pub(crate) fn write_to(&self, to: &mut impl Write, more: &[Note]) -> io::Result<()> {
        let label = self.label().ok_or_else(|| io::Error::other(FilmError::Unlabelled))?;
        self.write_as(label, to, more)
    }

    /// Writes the film with another label than its own to a file that is open.
    pub(crate) fn write_as(&self, label: &Label, to: &mut impl Write, more: &[Note]) -> io::Result<()> {
        let mut to = Hashing { inner: to, hasher: blake3::Hasher::new() };
        to.write_all(&header(self, label, more))?;
        // Pixels are words without padding; on machines with the other byte order they are turned.
        let sums = [Some(self), self.coverage()].into_iter().flatten();
        for pixels in sums.flat_map(|film| film.pixels().chunks(CHUNK / size_of::<FilmPixel>())) {
            if cfg!(target_endian = "little") {
                to.write_all(bytemuck::cast_slice(pixels))?;
            } else {
                let words: &[u32] = bytemuck::cast_slice(pixels);
                to.write_all(&words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>())?;
            }
        }
        let checksum = to.hasher.finalize();
        to.inner.write_all(checksum.as_bytes())
    }

    /// Bytes of the file that [`Film::write`] writes.
    ///
    /// # Errors
    /// [`FilmError::Unlabelled`] when the film has no label.
    pub fn to_bytes(&self) -> Result<Vec<u8>, FilmError> {
        let label = self.label().ok_or(FilmError::Unlabelled)?;
        let sums = if self.coverage().is_some() { 2 } else { 1 };
        let mut bytes = Vec::with_capacity(sums * film_bytes(self.width(), self.height()) as usize + LONGEST as usize);
        let written = self.write_as(label, &mut bytes, &[]);
        written.map_err(|source| FilmError::Unwritable { path: "memory".into(), source })?;
        Ok(bytes)
    }

    /// Reads a film from the bytes of its file.
    ///
    /// # Errors
    /// The errors of [`Film::read`], in which the file is called `name`.
    pub fn from_bytes(bytes: &[u8], name: &Path) -> Result<Self, FilmError> {
        from_reader(bytes).map(|(film, _)| film).map_err(|fault| fault.of(name))
    }

    /// Reads a film that [`Film::write`] has written.
    ///
    /// # Errors
    /// A [`FilmError`] when the file cannot be read, is no film or one of a later format, is damaged in any byte or cut
    /// short, or needs more memory than the machine has.
    pub fn read(path: &Path) -> Result<Self, FilmError> {
        Self::read_with_notes(path).map(|(film, _)| film)
    }

    /// Reads a film, and those of its notes that belong to the file alone.
    pub(crate) fn read_with_notes(path: &Path) -> Result<(Self, Vec<Note>), FilmError> {
        let read = File::open(path).map_err(Fault::System).and_then(|file| from_reader(BufReader::new(file)));
        read.map_err(|fault| fault.of(path))
    }
}

/// Bytes of a film's file before the pixels.
fn header(film: &Film, label: &Label, more: &[Note]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    let word = |bytes: &mut Vec<u8>, word: u32| bytes.extend(word.to_le_bytes());
    let text = |bytes: &mut Vec<u8>, text: &str| {
        word(bytes, text.len() as u32);
        bytes.extend(text.as_bytes());
    };
    let version = if film.coverage().is_some() { VERSION } else { PLAIN_VERSION };
    for number in [version, film.width(), film.height()] {
        word(&mut bytes, number);
    }
    bytes.extend(label.scene);
    text(&mut bytes, &label.version);
    word(&mut bytes, label.settings.len() as u32);
    for (key, value) in &label.settings {
        text(&mut bytes, key);
        text(&mut bytes, value);
    }
    word(&mut bytes, label.portions.len() as u32);
    for Portion { samples, rows } in &label.portions {
        for number in [samples.start, samples.end, rows.start, rows.end] {
            word(&mut bytes, number);
        }
    }
    word(&mut bytes, (label.notes.len() + more.len()) as u32);
    for Note { name, value } in label.notes.iter().chain(more) {
        text(&mut bytes, name);
        word(&mut bytes, value.len() as u32);
        bytes.extend(value);
    }
    bytes
}

fn from_reader(from: impl Read) -> Result<(Film, Vec<Note>), Fault> {
    let mut from = Hashing { inner: from, hasher: blake3::Hasher::new() };
    let mut magic = [0; MAGIC.len()];
    match from.read_exact(&mut magic) {
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(Fault::System(error)),
        Ok(()) if magic == MAGIC => {}
        _ => return Err(Fault::NotAFilm),
    }
    let has_coverage = match from.word()? {
        PLAIN_VERSION => false,
        VERSION => true,
        found => return Err(Fault::Version(found)),
    };
    let [width, height] = [from.word()?, from.word()?];
    if !(1..=LONGEST_SIDE).contains(&width) || !(1..=LONGEST_SIDE).contains(&height) {
        return Err(damaged(format!("it says that it has {width}x{height} pixels")));
    }
    let mut scene = [0; 32];
    from.fill(&mut scene)?;
    let version = from.text()?;
    let settings = (0..from.length()?).map(|_| Ok((from.text()?, from.text()?))).collect::<Result<_, Fault>>()?;
    let mut portions: Vec<Portion> = vec![];
    for _ in 0..from.length()? {
        let [first, end, top, bottom] = [from.word()?, from.word()?, from.word()?, from.word()?];
        let portion = Portion { samples: first..end, rows: top..bottom };
        let meets = portions.iter().any(|other| other.common(&portion).is_some());
        if portion.is_empty() || bottom > height || meets {
            return Err(damaged(format!("{portion} are not a part of it")));
        }
        portions.push(portion);
    }
    let mut notes = vec![];
    for _ in 0..from.length()? {
        notes.push(Note { name: from.text()?, value: from.note()? });
    }
    let (own, notes) = notes.into_iter().partition(|note: &Note| note.belongs_to_file());
    check_memory(width, height).map_err(Fault::TooLarge)?;

    let pixels = from.pixels(width, height)?;
    let coverage = if has_coverage { Some(from.pixels(width, height)?) } else { None };
    let expected = from.hasher.finalize();
    let mut found = [0; CHECKSUM];
    from.fill(&mut found)?;
    if expected.as_bytes() != &found {
        return Err(damaged("its checksum is another".into()));
    }
    if from.inner.read(&mut [0]).map_err(Fault::System)? > 0 {
        return Err(damaged("it goes on after its end".into()));
    }
    let label = Label { version, scene, settings, portions, notes };
    let coverage = coverage.map(|pixels| Film::from_pixels(width, height, pixels));
    Ok((Film::from_pixels(width, height, pixels).with_label(label).with_coverage(coverage), own))
}

fn damaged(reason: String) -> Fault {
    Fault::Damaged(reason)
}

/// A stream whose bytes are hashed as they pass.
struct Hashing<T> {
    inner: T,
    hasher: blake3::Hasher,
}

impl<T: Write> Write for Hashing<T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.hasher.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<T: Read> Read for Hashing<T> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(bytes)?;
        self.hasher.update(&bytes[..count]);
        Ok(count)
    }
}

impl<T: Read> Hashing<T> {
    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), Fault> {
        self.read_exact(bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => damaged("it is cut short".into()),
            _ => Fault::System(error),
        })
    }

    fn word(&mut self) -> Result<u32, Fault> {
        let mut bytes = [0; 4];
        self.fill(&mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }

    /// Length of a text or a list.
    fn length(&mut self) -> Result<u32, Fault> {
        let length = self.word()?;
        if length > LONGEST { Err(damaged(format!("a list in it has {length} entries"))) } else { Ok(length) }
    }

    fn text(&mut self) -> Result<String, Fault> {
        let mut bytes = vec![0; self.length()? as usize];
        self.fill(&mut bytes)?;
        String::from_utf8(bytes).map_err(|_| damaged("a text in it is not UTF-8".into()))
    }

    /// Value of a note.
    fn note(&mut self) -> Result<Vec<u8>, Fault> {
        let length = self.word()?;
        if length > LONGEST_NOTE {
            return Err(damaged(format!("a note in it has {length} bytes")));
        }
        let mut bytes = vec![];
        while bytes.len() < length as usize {
            let start = bytes.len();
            bytes.resize((length as usize).min(start + CHUNK), 0);
            self.fill(&mut bytes[start..])?;
        }
        Ok(bytes)
    }

    fn pixels(&mut self, width: u32, height: u32) -> Result<Vec<FilmPixel>, Fault> {
        let mut left = (film_bytes(width, height) / size_of::<FilmPixel>() as u64) as usize;
        let mut pixels = vec![];
        while left > 0 {
            let mut chunk = vec![FilmPixel::default(); left.min(CHUNK / size_of::<FilmPixel>())];
            self.fill(bytemuck::cast_slice_mut(&mut chunk))?;
            if cfg!(target_endian = "big") {
                let words: &mut [u32] = bytemuck::cast_slice_mut(&mut chunk);
                words.iter_mut().for_each(|word| *word = word.swap_bytes());
            }
            left -= chunk.len();
            pixels.append(&mut chunk);
        }
        Ok(pixels)
    }
}
