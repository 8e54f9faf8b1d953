//! Locks by which one render alone keeps a checkpoint.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use crate::pictures::output_file::{forget_unfinished, remember_unfinished};

/// A lock on a file, which is removed with it. The system frees it when the process ends, however it does.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    _file: File,
}

/// Reasons why a lock cannot be had.
pub(super) enum NoLock {
    /// Somebody else has it, who is this in words.
    Taken(String),
    /// The file system knows no locks, or takes no file.
    Unknown(io::Error),
}

impl Lock {
    /// Takes the lock in the file at `path`, without waiting for it.
    pub fn take(path: &Path) -> Result<Self, NoLock> {
        loop {
            let open = File::options().read(true).write(true).create(true).truncate(false).open(path);
            let mut file = open.map_err(NoLock::Unknown)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(NoLock::Taken(owner(&mut file))),
                Err(TryLockError::Error(error)) => return Err(NoLock::Unknown(error)),
            }
            // Whoever had it may have removed the file in between, and the lock of a file without a name keeps nobody out.
            if !is_at(&file, path) {
                continue;
            }
            // Nobody depends on what stands in it.
            let _ = file.set_len(0).and_then(|()| file.write_all(ourselves().as_bytes()));
            remember_unfinished(path);
            return Ok(Self { path: path.into(), _file: file });
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // It goes while it is still locked, so that nobody can have taken it.
        forget_unfinished(&self.path);
        let _ = std::fs::remove_file(&self.path);
    }
}

/// This process in words.
fn ourselves() -> String {
    let process = std::process::id();
    #[cfg(unix)]
    return format!("process {process} on {}", rustix::system::uname().nodename().to_string_lossy());
    #[cfg(not(unix))]
    format!("process {process}")
}

/// Owner of a lock, as it says itself.
fn owner(file: &mut File) -> String {
    let mut text = String::new();
    match file.take(256).read_to_string(&mut text) {
        Ok(length) if length > 0 => text.chars().filter(|character| !character.is_control()).collect(),
        _ => "another process".into(),
    }
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |metadata: std::fs::Metadata| (metadata.dev(), metadata.ino());
    let named = path.symlink_metadata().map(identity);
    matches!((file.metadata().map(identity), named), (Ok(ours), Ok(named)) if ours == named)
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}
