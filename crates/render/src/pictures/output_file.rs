//! Files that are written whole or not at all.

use std::fs::{File, Metadata};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Most links that are followed from a name to a file, as systems have it.
const MOST_LINKS: usize = 40;

/// A file to be written, whose place is found before any work is spent on what it will hold.
///
/// It goes there under a temporary name, and is renamed when all of it has reached the disk. What it replaces gives it its
/// permissions. Links are followed, also to what is not there yet, but none that somebody else may have planted. Character
/// devices and the program's own open files, as `/dev/null` and `/dev/stdout`, are written to as they are; pipes, sockets
/// and disks are refused.
#[derive(Clone, Debug)]
pub struct OutputFile {
    path: PathBuf,
    target: Target,
}

/// Place that a name leads to.
#[derive(Clone, Debug)]
enum Target {
    /// A file, which need not be there yet: its path from the root, without links.
    File(PathBuf),
    /// A device, or a file that this program has open.
    Stream(PathBuf),
}

impl OutputFile {
    /// Finds the place, and finds out whether it can be written to.
    ///
    /// # Errors
    /// The system's error when it cannot.
    pub fn new(path: &Path) -> io::Result<Self> {
        let target = Target::of(path)?;
        if let Target::File(place) = &target {
            temporary_beside(place)?;
        }
        Ok(Self { path: path.into(), target })
    }

    /// Path of the file, as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of the file from the root, without links; `None` for devices, to which any number of files may go.
    pub fn place(&self) -> Option<&Path> {
        match &self.target {
            Target::File(place) => Some(place),
            Target::Stream(_) => None,
        }
    }

    /// Writes the file. A folder that has vanished since the place was found is made again: what took hours is not lost
    /// for somebody's tidiness.
    ///
    /// # Errors
    /// The system's error when the file cannot be written; nothing is left of it then.
    pub fn write(&self, bytes: &[u8]) -> io::Result<()> {
        if let Some(folder) = self.place().and_then(Path::parent) {
            std::fs::create_dir_all(folder)?;
        }
        self.target.write(|file| file.write_all(bytes))
    }
}

/// Writes `bytes` to `path`, whole or not at all, as an [`OutputFile`] does.
///
/// # Errors
/// The system's error when the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_whole_with(path, |file| file.write_all(bytes))
}

/// Writes to `path`, whole or not at all as [`write_whole`] does, the bytes that `write` writes; they need not be in
/// memory together.
pub(crate) fn write_whole_with(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    Target::of(path)?.write(write)
}

impl Target {
    /// Follows `path` to where it leads.
    fn of(path: &Path) -> io::Result<Self> {
        let mut path = std::path::absolute(path)?;
        for _ in 0..MOST_LINKS {
            let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else {
                return Err(io::ErrorKind::IsADirectory.into());
            };
            let folder = folder.canonicalize()?;
            let place = folder.join(name);
            if has_open_files(&folder) {
                return Ok(Self::Stream(place));
            }
            match place.symlink_metadata() {
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::File(place)),
                Err(error) => return Err(error),
                Ok(link) if link.is_symlink() => {
                    refuse_planted(&folder, &link)?;
                    path = folder.join(place.read_link()?);
                }
                Ok(metadata) if metadata.is_file() => return Ok(Self::File(place)),
                Ok(metadata) if metadata.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
                Ok(metadata) => return special(&metadata).map(|()| Self::Stream(place)),
            }
        }
        Err(io::Error::other("its links lead nowhere"))
    }

    fn write(&self, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
        let place = match self {
            // What has been written to an open file before stays.
            Self::Stream(path) => return write(&mut File::options().append(true).open(path)?),
            Self::File(place) => place,
        };
        let mut temporary = temporary_beside(place)?;
        #[cfg(unix)]
        if let Ok(replaced) = place.metadata() {
            use std::os::unix::fs::PermissionsExt;
            let mode = replaced.permissions().mode() & 0o777;
            temporary.as_file().set_permissions(std::fs::Permissions::from_mode(mode))?;
        }
        write(temporary.as_file_mut())?;
        temporary.as_file().sync_all()?;
        temporary.persist(place).map_err(|e| e.error)?;
        Ok(())
    }
}

/// Whether names in the folder stand for the files that a program has open: `/dev/stdout` leads there.
fn has_open_files(folder: &Path) -> bool {
    folder == Path::new("/dev/fd") || folder.starts_with("/proc") && folder.ends_with("fd")
}

/// Lets character devices pass, of all things that are neither files nor folders: opening a pipe waits for whoever is to
/// read it, maybe for ever, and a picture on a disk would take its file system's place.
#[cfg(unix)]
fn special(metadata: &Metadata) -> io::Result<()> {
    use std::os::unix::fs::FileTypeExt;
    let kind = metadata.file_type();
    if kind.is_char_device() {
        return Ok(());
    }
    let name = match kind {
        _ if kind.is_fifo() => "a pipe",
        _ if kind.is_socket() => "a socket",
        _ => "a disk",
    };
    Err(io::Error::other(format!("it is {name}: give a file, or a device such as /dev/null or /dev/stdout")))
}

#[cfg(not(unix))]
fn special(_: &Metadata) -> io::Result<()> {
    Err(io::Error::other("it is neither a file nor a folder"))
}

/// Refuses a link that somebody else has put into a folder where everybody may: it would let them choose which of our
/// files is replaced. The rule is that of Linux's `protected_symlinks`, which is not switched on everywhere.
#[cfg(unix)]
fn refuse_planted(folder: &Path, link: &Metadata) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    const STICKY_AND_WORLD_WRITABLE: u32 = 0o1002;
    let folder = folder.metadata()?;
    let is_shared = folder.mode() & STICKY_AND_WORLD_WRITABLE == STICKY_AND_WORLD_WRITABLE;
    let is_trusted = [rustix::process::geteuid().as_raw(), folder.uid()].contains(&link.uid());
    if is_shared && !is_trusted {
        return Err(io::Error::new(
            io::ErrorKind::PermissionDenied,
            "it is a link of another user in a folder that all may write to",
        ));
    }
    Ok(())
}

#[cfg(not(unix))]
fn refuse_planted(_: &Path, _: &Metadata) -> io::Result<()> {
    Ok(())
}

/// Temporary file in the folder of `place`, hidden, which vanishes unless it is kept.
fn temporary_beside(place: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".raggio-");
    // Permissions are those of any new file: the temporary one would be for its owner alone.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(place.parent().unwrap_or(Path::new("."))).map_err(|e| of_system(&e))
}

/// The system's own words: `tempfile` puts the name of a temporary file behind them, which nobody has asked for.
fn of_system(error: &io::Error) -> io::Error {
    let words = error.to_string();
    let words = words.split_once(" at path \"").map_or(words.as_str(), |(words, _)| words);
    io::Error::new(error.kind(), words)
}
