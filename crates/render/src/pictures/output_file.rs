//! Files that are written whole or not at all.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{File, Metadata};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use raggio_scene::display_name;
use tempfile::{NamedTempFile, TempPath};

use crate::pictures::file_faults::{Sink, attempt};

/// Most links that are followed from a name to a file, as systems have it.
const MOST_LINKS: usize = 40;

/// Most names that are tried for a file in its refuge.
const MOST_NAMES: usize = 1000;

/// Paths of temporary files.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

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
    /// Folder for what cannot be written to its place.
    refuge: Option<PathBuf>,
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
            Temporary::beside(place)?;
        }
        Ok(Self { path: path.into(), target, refuge: None })
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

    /// Checks that the file takes the place of none of `inputs`, by whatever names and links they are called.
    ///
    /// # Errors
    /// An error that names the input.
    pub fn check_apart<'a>(&self, inputs: impl IntoIterator<Item = &'a Path>) -> io::Result<()> {
        let Some(place) = self.place() else { return Ok(()) };
        match inputs.into_iter().find(|input| is_same_file(place, input)) {
            Some(input) => Err(io::Error::other(format!("it would replace what is read, {}", display_name(input)))),
            None => Ok(()),
        }
    }

    /// This file with `folder` as its refuge: what cannot be written to its place goes there, under its name or the next
    /// that is free. A folder that is not there is no refuge.
    pub fn with_refuge(self, folder: &Path) -> Self {
        Self { refuge: folder.canonicalize().ok(), ..self }
    }

    /// Writes the file. A folder that has vanished since the place was found is made again: what took hours is not lost
    /// for somebody's tidiness.
    ///
    /// # Errors
    /// The system's error when the file cannot be written to its place; it names the file in the refuge if there is one,
    /// and otherwise nothing is left of it.
    pub fn write(&self, bytes: &[u8]) -> io::Result<()> {
        self.write_with(&|to| to.write_all(bytes))
    }

    /// Writes what `write` writes as [`OutputFile::write`] does; for the refuge it is asked once more.
    pub(crate) fn write_with(&self, write: &dyn Fn(&mut Sink) -> io::Result<()>) -> io::Result<()> {
        let folder = self.place().and_then(Path::parent).map_or(Ok(()), std::fs::create_dir_all);
        folder.and_then(|()| self.target.write(write)).map_err(|error| match self.rescue(write) {
            Some(path) => io::Error::new(error.kind(), format!("{error}: it is in {} instead", display_name(&path))),
            None => error,
        })
    }

    /// Has `write` fill a file under a temporary name, whose path it is given; the file takes its place when it is whole.
    ///
    /// # Errors
    /// The system's error, or that of `write`; nothing is left of the file then.
    pub fn write_by(&self, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
        let Target::File(place) = &self.target else {
            return Err(io::Error::other("it is a device: give a file"));
        };
        place.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        let mut temporary = Temporary::beside(place)?;
        write(&temporary.path)?;
        temporary.sync()?;
        temporary.replace(place)
    }

    /// Writes a file into the refuge, if that is another folder than the file's own. Returns its name there.
    fn rescue(&self, write: &dyn Fn(&mut Sink) -> io::Result<()>) -> Option<PathBuf> {
        let name = Path::new(self.place()?.file_name()?);
        let folder = self.refuge.as_deref().filter(|folder| self.place().and_then(Path::parent) != Some(folder))?;
        let path = write_free(folder, name, write).ok()?;
        path.file_name().map(PathBuf::from)
    }
}

/// Writes what `write` writes into `folder`, whole or not at all, under `name` or the next that is free: `NAME-2.film`.
/// Returns the path that it has got.
pub(crate) fn write_free(
    folder: &Path,
    name: &Path,
    write: &dyn Fn(&mut Sink) -> io::Result<()>,
) -> io::Result<PathBuf> {
    let mut temporary = Temporary::new(folder)?;
    write(&mut temporary.sink()?)?;
    temporary.sync()?;
    let ending = name.extension().map(|ending| format!(".{}", ending.to_string_lossy())).unwrap_or_default();
    let stem = name.file_stem().unwrap_or_default().to_string_lossy();
    let numbered = (2..=MOST_NAMES).map(|number| PathBuf::from(format!("{stem}-{number}{ending}")));
    let names = std::iter::once(name.to_path_buf()).chain(numbered);
    names
        .map(|name| folder.join(name))
        .find(|path| temporary.take_free(path))
        .ok_or_else(|| io::ErrorKind::AlreadyExists.into())
}

/// Path that `path` leads to, from the root and without links, of a file that may be written there.
///
/// # Errors
/// The system's error when the folder cannot be written to, and one of ours where the path is a device.
pub(crate) fn place_of(path: &Path) -> io::Result<PathBuf> {
    match Target::of(path)? {
        Target::Stream(_) => Err(io::Error::other("it is a device: give a file")),
        Target::File(place) => Temporary::beside(&place).map(|_| place),
    }
}

/// Path with more at its end: `NAME.png` becomes `NAME.png.part`.
pub(crate) fn appended(path: &Path, ending: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(ending);
    name.into()
}

/// Writes to `place`, whole or not at all, what `write` writes; the file that was there becomes `kept`. The temporary name
/// is always the same, `PLACE.part`, so that what a killed program leaves is replaced by the next.
pub(crate) fn write_keeping(place: &Path, kept: &Path, write: &dyn Fn(&mut Sink) -> io::Result<()>) -> io::Result<()> {
    place.parent().map_or(Ok(()), std::fs::create_dir_all)?;
    let mut temporary = Temporary::at(appended(place, ".part"))?;
    write(&mut temporary.sink()?)?;
    temporary.sync()?;
    match attempt().and_then(|()| std::fs::rename(place, kept)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => temporary.replace(place),
    }
}

/// Has the file at `path` removed where the program ends at once.
pub(crate) fn remember_unfinished(path: &Path) {
    unfinished().insert(path.into());
}

/// Leaves the file at `path` to whoever has asked for [`remember_unfinished`].
pub(crate) fn forget_unfinished(path: &Path) {
    unfinished().remove(path);
}

/// Removes what there is of files that are being written, for a program that ends at once. Whoever is writing one waits
/// for that end.
pub fn abandon_files() {
    let unfinished = unfinished();
    for path in unfinished.iter() {
        let _ = std::fs::remove_file(path);
    }
    std::mem::forget(unfinished);
}

/// Writes `bytes` to `path`, whole or not at all, as an [`OutputFile`] does.
///
/// # Errors
/// The system's error when the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_whole_with(path, |to| to.write_all(bytes))
}

/// Writes to `path`, whole or not at all as [`write_whole`] does, the bytes that `write` writes; they need not be in
/// memory together.
pub(crate) fn write_whole_with(path: &Path, write: impl FnOnce(&mut Sink) -> io::Result<()>) -> io::Result<()> {
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

    fn write(&self, write: impl FnOnce(&mut Sink) -> io::Result<()>) -> io::Result<()> {
        let place = match self {
            // What has been written to an open file before stays.
            Self::Stream(path) => return write(&mut Sink(&mut File::options().append(true).open(path)?)),
            Self::File(place) => place,
        };
        let mut temporary = Temporary::beside(place)?;
        #[cfg(unix)]
        if let Ok(replaced) = place.metadata() {
            use std::os::unix::fs::PermissionsExt;
            let mode = replaced.permissions().mode() & 0o777;
            temporary.file()?.set_permissions(std::fs::Permissions::from_mode(mode))?;
        }
        write(&mut temporary.sink()?)?;
        temporary.sync()?;
        temporary.replace(place)
    }
}

/// Whether the file at `place`, a path without links, is the one called `other`.
fn is_same_file(place: &Path, other: &Path) -> bool {
    // A folder that is mounted twice has two canonical paths, and a file with two names (hard links) is meant to be one.
    #[cfg(unix)]
    if let (Ok(there), Ok(other)) = (place.metadata(), other.metadata()) {
        use std::os::unix::fs::MetadataExt;
        return (there.dev(), there.ino()) == (other.dev(), other.ino());
    }
    other.canonicalize().is_ok_and(|other| other == place)
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

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A hidden file that vanishes unless it is kept, also where the program ends early. What its name stands for only changes
/// while the list of such files is locked.
struct Temporary {
    /// The file, until it has another name.
    file: Option<NamedTempFile>,
    path: PathBuf,
}

impl Temporary {
    /// A file in the folder of `place`.
    fn beside(place: &Path) -> io::Result<Self> {
        Self::new(place.parent().unwrap_or(Path::new(".")))
    }

    fn new(folder: &Path) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".raggio-");
        // Permissions are those of any new file: the temporary one would be for its owner alone.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        attempt()?;
        let mut unfinished = unfinished();
        let file = builder.tempfile_in(folder).map_err(|e| of_system(&e))?;
        let path = file.path().to_path_buf();
        unfinished.insert(path.clone());
        Ok(Self { file: Some(file), path })
    }

    /// A file at `path`, in place of one that a program before has left there.
    fn at(path: PathBuf) -> io::Result<Self> {
        attempt()?;
        let mut unfinished = unfinished();
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        // A link that somebody has put there meanwhile is not followed.
        let file = File::options().write(true).create_new(true).open(&path)?;
        let file = NamedTempFile::from_parts(file, TempPath::try_from_path(&path)?);
        unfinished.insert(path.clone());
        Ok(Self { file: Some(file), path })
    }

    fn file(&mut self) -> io::Result<&mut File> {
        self.file.as_mut().map(NamedTempFile::as_file_mut).ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn sink(&mut self) -> io::Result<Sink<'_>> {
        self.file().map(Sink)
    }

    /// Waits until all of the file has reached the disk.
    fn sync(&mut self) -> io::Result<()> {
        attempt()?;
        self.file()?.sync_all()
    }

    /// Puts the file in the place of whatever is there.
    fn replace(mut self, place: &Path) -> io::Result<()> {
        attempt()?;
        let unfinished = unfinished();
        self.file.take().map_or(Ok(()), |file| file.persist(place).map(drop).map_err(|e| e.error))?;
        drop(unfinished);
        sync_folder_of(place);
        Ok(())
    }

    /// Gives the file a name that is free, if this one is. Returns whether it was.
    fn take_free(&mut self, place: &Path) -> bool {
        if attempt().is_err() {
            return false;
        }
        let _unfinished = unfinished();
        let Some(file) = self.file.take() else { return false };
        match file.persist_noclobber(place) {
            Ok(_) => true,
            Err(error) => {
                self.file = Some(error.file);
                false
            }
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let mut unfinished = unfinished();
        self.file = None;
        unfinished.remove(&self.path);
    }
}

/// Waits until a name has reached the disk, where the system can: the file itself has.
fn sync_folder_of(place: &Path) {
    #[cfg(unix)]
    let _ = place.parent().map(|folder| File::open(folder).and_then(|folder| folder.sync_all()));
    #[cfg(not(unix))]
    let _ = place;
}

/// The system's own words: `tempfile` puts the name of a temporary file behind them, which nobody has asked for.
fn of_system(error: &io::Error) -> io::Error {
    let words = error.to_string();
    let words = words.split_once(" at path \"").map_or(words.as_str(), |(words, _)| words);
    io::Error::new(error.kind(), words)
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    /// Abandons a file in a program of its own, which is this test once more: no file is written after that.
    #[test]
    fn an_abandoned_file_leaves_nothing() {
        const FOLDER: &str = "RAGGIO_TEST_ABANDONED";
        if let Some(folder) = std::env::var_os(FOLDER) {
            let path = Path::new(&folder).join("a.png");
            let written = write_whole_with(&path, |file| {
                file.write_all(b"half of it")?;
                let count = std::fs::read_dir(&folder)?.count();
                abandon_files();
                std::process::exit(if count == 1 { 42 } else { 1 })
            });
            panic!("{written:?}");
        }
        let folder = tempfile::tempdir().expect("a folder");
        let mut again = Command::new(std::env::current_exe().expect("a program"));
        again.args(["--exact", "pictures::output_file::tests::an_abandoned_file_leaves_nothing"]);
        let status = again.env(FOLDER, folder.path()).status().expect("the program starts");
        assert_eq!(status.code(), Some(42));
        assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0);
    }
}
