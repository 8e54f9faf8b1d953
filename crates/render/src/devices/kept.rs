//! Compiled kernels that are kept on disk, so that the next picture need not wait for the driver.
//!
//! A file has the pipelines of one device, driver and set of kernels, and what it is for is in its name. Nothing here is an
//! error: a folder that cannot be written to costs time alone, and a file that is not whole is as good as none.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use etcetera::BaseStrategy;
use raggio_kernels::{Spirv, Variant};
use raggio_vulkan::Compiler;

use crate::pictures::output_file::write_whole_with;

/// First bytes of a file, the version of its layout among them.
const MAGIC: &[u8; 16] = b"raggio kernels 1";
/// Bytes of a hash.
const HASH_BYTES: usize = blake3::OUT_LEN;
/// Bytes before the driver's data: magic, key, checksum of the data.
const HEADER_BYTES: usize = MAGIC.len() + 2 * HASH_BYTES;
/// Ending of the files' names.
const ENDING: &str = "pipelines";
/// Most bytes of a file: nobody's kernels take a tenth of it.
const MOST_BYTES: u64 = 64 << 20;
/// Most files in the folder: a few devices, each with the driver and kernels of now and before.
const MOST_FILES: usize = 8;

/// Folder in which compiled kernels are kept: `RAGGIO_CACHE_DIR` or, without it, the `raggio` in the user's folder of caches.
/// `None` where there is no such folder, and with `RAGGIO_NO_CACHE=1`.
pub fn cache_folder() -> Option<PathBuf> {
    let users = etcetera::base_strategy::choose_native_strategy().ok().map(|folders| folders.cache_dir());
    chosen_folder(|name| std::env::var_os(name), users)
}

/// Folder that the variables of the environment choose, or one in `users`, the user's own.
fn chosen_folder(variable: impl Fn(&str) -> Option<OsString>, users: Option<PathBuf>) -> Option<PathBuf> {
    if variable("RAGGIO_NO_CACHE").is_some_and(|value| value == "1") {
        return None;
    }
    let named = variable("RAGGIO_CACHE_DIR").filter(|folder| !folder.is_empty());
    named.map(PathBuf::from).or_else(|| users.map(|users| users.join("raggio")))
}

/// File of the pipelines of one device, driver and set of kernels.
#[derive(Clone)]
pub(crate) struct KeptPipelines {
    folder: PathBuf,
    key: blake3::Hash,
}

impl KeptPipelines {
    /// File in `folder`, which need not be there yet.
    pub fn new(folder: &Path, compiler: Compiler, kernels: &Spirv) -> Self {
        let codes = Variant::ALL.map(|variant| kernels.code(variant));
        Self { folder: folder.into(), key: key(&compiler.to_bytes(), &codes) }
    }

    fn path(&self) -> PathBuf {
        self.folder.join(format!("{}.{ENDING}", &self.key.to_hex()[..32]))
    }

    /// The driver's data in the file; `None` if there is no file, or it is anything but what was written.
    pub fn read(&self) -> Option<Vec<u8>> {
        let file = File::open(self.path()).ok()?;
        let size = file.metadata().ok().filter(fs::Metadata::is_file)?.len();
        if size > MOST_BYTES {
            return None;
        }
        let mut bytes = Vec::with_capacity(size as usize);
        file.take(MOST_BYTES).read_to_end(&mut bytes).ok()?;
        let (header, data) = bytes.split_at_checked(HEADER_BYTES)?;
        if header != self.header(data) {
            return None;
        }
        // Files that are used stay longest.
        let _ = File::options().append(true).open(self.path()).and_then(|file| file.set_modified(SystemTime::now()));
        Some(data.to_vec())
    }

    fn header(&self, data: &[u8]) -> Vec<u8> {
        [&MAGIC[..], self.key.as_bytes(), blake3::hash(data).as_bytes()].concat()
    }

    /// Writes the driver's data, whole or not at all, and removes the files that were not used for longest where there are
    /// too many.
    ///
    /// # Errors
    /// The system's error when it cannot.
    pub fn write(&self, data: &[u8]) -> io::Result<()> {
        if (HEADER_BYTES + data.len()) as u64 > MOST_BYTES {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        make_folder(&self.folder)?;
        write_whole_with(&self.path(), |file| {
            file.write_all(&self.header(data))?;
            file.write_all(data)
        })?;
        self.remove_others()
    }

    /// Removes the files beyond [`MOST_FILES`] that were not used for longest, never this one.
    fn remove_others(&self) -> io::Result<()> {
        let own = self.path();
        let others = fs::read_dir(&self.folder)?.filter_map(|entry| {
            let entry = entry.ok()?;
            let path = entry.path();
            let is_other = path.extension().is_some_and(|ending| ending == ENDING) && path != own;
            let metadata = entry.metadata().ok().filter(|metadata| is_other && metadata.is_file())?;
            Some((metadata.modified().ok()?, path))
        });
        let mut others: Vec<_> = others.collect();
        others.sort_unstable_by(|a, b| b.cmp(a));
        // Another process may have removed one.
        others.iter().skip(MOST_FILES - 1).for_each(|(_, path)| drop(fs::remove_file(path)));
        Ok(())
    }
}

/// Hash of all that compiled kernels depend on: device, driver, and the SPIR-V of each variant.
fn key(compiler: &[u8], codes: &[&[u8]]) -> blake3::Hash {
    let mut hash = blake3::Hasher::new();
    for part in std::iter::once(&compiler).chain(codes) {
        hash.update(&(part.len() as u64).to_le_bytes()).update(part);
    }
    hash.finalize()
}

/// Makes a folder and those above it, for their owner alone where the system knows owners.
fn make_folder(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn kept(folder: &Path, key: u8) -> KeptPipelines {
        KeptPipelines { folder: folder.into(), key: blake3::hash(&[key]) }
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").file_name());
        entries.map(|name| name.into_string().expect("a name")).collect()
    }

    #[test]
    fn the_environment_chooses_the_folder() {
        let users = || Some(PathBuf::from("/home/a/.cache"));
        let chosen = |variables: &[(&str, &str)], users| {
            let value = |name: &str| variables.iter().find(|(known, _)| *known == name).map(|(_, value)| value.into());
            chosen_folder(value, users)
        };
        assert_eq!(chosen(&[], users()), Some("/home/a/.cache/raggio".into()));
        assert_eq!(chosen(&[("RAGGIO_CACHE_DIR", "")], users()), Some("/home/a/.cache/raggio".into()));
        assert_eq!(chosen(&[("RAGGIO_CACHE_DIR", "fast")], users()), Some("fast".into()));
        assert_eq!(chosen(&[("RAGGIO_CACHE_DIR", "fast"), ("RAGGIO_NO_CACHE", "0")], None), Some("fast".into()));
        assert_eq!(chosen(&[("RAGGIO_CACHE_DIR", "fast"), ("RAGGIO_NO_CACHE", "1")], users()), None);
        assert_eq!(chosen(&[], None), None);
    }

    #[test]
    fn what_was_written_is_read_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().join("not/there/yet");
        let file = kept(&place, 0);
        assert_eq!(file.read(), None);
        for data in [&b"pipelines"[..], b"", &[7; 100_000]] {
            file.write(data).expect("the folder can be written to");
            assert_eq!(file.read().as_deref(), Some(data));
            assert_eq!(names(&place).len(), 1, "no temporary file is left");
        }
        assert_eq!(kept(&place, 1).read(), None);
    }

    /// Whatever is in place of the file, nothing of it gets to the driver, and the next to write replaces it.
    #[test]
    fn what_is_not_whole_is_ignored_and_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = kept(folder.path(), 0);
        file.write(b"pipelines").expect("the folder can be written to");
        let whole = fs::read(file.path()).expect("the file");
        for length in 0..whole.len() {
            fs::write(file.path(), &whole[..length]).expect("the file");
            assert_eq!(file.read(), None, "{length} bytes");
        }
        for place in 0..whole.len() {
            let mut flipped = whole.clone();
            flipped[place] ^= 0x10;
            fs::write(file.path(), &flipped).expect("the file");
            assert_eq!(file.read(), None, "byte {place}");
        }
        fs::write(file.path(), [&whole[..], b"more"].concat()).expect("the file");
        assert_eq!(file.read(), None);
        // A file for others under this name.
        kept(folder.path(), 1).write(b"pipelines").expect("the folder can be written to");
        fs::rename(kept(folder.path(), 1).path(), file.path()).expect("the file");
        assert_eq!(file.read(), None);
        let sparse = File::create(file.path()).expect("the file");
        sparse.set_len(MOST_BYTES + 1).expect("the file");
        assert_eq!(file.read(), None);

        file.write(b"pipelines").expect("the folder can be written to");
        assert_eq!(fs::read(file.path()).expect("the file"), whole);
    }

    #[test]
    fn files_that_nobody_uses_are_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("notes.txt"), "somebody's").expect("the file");
        let hours_ago = |hours: u64| SystemTime::now() - Duration::from_secs(3600 * hours);
        for number in 0..MOST_FILES as u8 {
            let file = kept(folder.path(), number);
            file.write(b"pipelines").expect("the folder can be written to");
            let opened = File::options().append(true).open(file.path()).expect("the file");
            opened.set_modified(hours_ago(100 - u64::from(number))).expect("the file");
        }
        // The oldest is used once more.
        assert!(kept(folder.path(), 0).read().is_some());
        kept(folder.path(), 100).write(b"pipelines").expect("the folder can be written to");
        let is_there = |number| kept(folder.path(), number).path().exists();
        assert!(is_there(0) && !is_there(1) && is_there(2) && is_there(100));
        assert_eq!(names(folder.path()).len(), MOST_FILES + 1);
    }

    #[test]
    fn a_folder_that_cannot_be_is_an_error_to_write_and_nothing_to_read() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("file"), "").expect("the file");
        let file = kept(&folder.path().join("file/folder"), 0);
        assert!(file.write(b"pipelines").is_err());
        assert_eq!(file.read(), None);
    }

    /// Many write and read at once, and whoever reads finds all of what somebody has written.
    #[test]
    fn processes_may_share_a_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = kept(folder.path(), 0);
        file.write(&[0; 10_000]).expect("the folder can be written to");
        std::thread::scope(|scope| {
            for writer in 1..4 {
                let file = &file;
                scope.spawn(move || (0..10).for_each(|_| file.write(&[writer; 10_000]).expect("it can be written")));
            }
            for _ in 0..200 {
                let data = file.read().expect("the file is whole");
                assert!(data.len() == 10_000 && data.iter().all(|byte| *byte == data[0]));
            }
        });
    }

    #[test]
    fn whatever_changes_the_key_is_another() {
        let first = key(b"driver", &[b"one", b"two"]);
        assert_eq!(key(b"driver", &[b"one", b"two"]), first);
        for (driver, codes) in [
            (b"drives", [&b"one"[..], b"two"]),
            (b"driver", [b"one", b"twa"]),
            (b"driver", [b"two", b"one"]),
            (b"driver", [b"onet", b"wo"]),
        ] {
            assert_ne!(key(driver, &codes), first);
        }
    }
}
