//! Files that a model names: regular ones, inside the model's folder.

use std::collections::BTreeSet;
use std::fs;
use std::io::{Error, ErrorKind};
use std::path::{Component, Path, PathBuf};

/// Reason why a file that a model names is not opened; its display goes on after the name of the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Refusal {
    #[error("is outside the folder of the model, where files are not read unless `--allow-outside` is given")]
    Outside,
    #[error(
        "is a link that leads out of the folder of the model, where files are not read unless `--allow-outside` is given"
    )]
    LeadsOut,
    #[error("does not exist")]
    Missing,
    #[error("is a folder: give a file")]
    Folder,
    #[error("is a device or a pipe: only regular files are read")]
    NotRegular,
    #[error("cannot be read: {0}")]
    Unreadable(String),
}

/// Files that a model has named.
#[derive(Debug, Default)]
pub(crate) struct Named {
    /// Paths, without links, of those that were found.
    pub found: BTreeSet<PathBuf>,
    /// Paths at which there was none, in folders that exist.
    pub missing: BTreeSet<PathBuf>,
}

impl Named {
    /// Does what [`locate`] does, and keeps what it found, or did not.
    pub(crate) fn locate(&mut self, folder: &Path, name: &str, allow_outside: bool) -> Result<PathBuf, Refusal> {
        let located = locate(folder, name, allow_outside);
        match &located {
            Ok(path) => drop(self.found.insert(path.clone())),
            Err(Refusal::Missing) => self.missing.extend(would_be(folder, name, allow_outside)),
            Err(_) => {}
        }
        located
    }

    pub(crate) fn extend(&mut self, other: Self) {
        self.found.extend(other.found);
        self.missing.extend(other.missing);
    }
}

/// Path of a file that does not exist, in a folder that does.
fn would_be(folder: &Path, name: &str, allow_outside: bool) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let path = folder.join(name.replace('\\', "/"));
    let parent = path.parent()?.canonicalize().ok()?;
    let inside = allow_outside || parent.starts_with(folder.canonicalize().ok()?);
    inside.then(|| Some(parent.join(path.file_name()?))).flatten()
}

/// The real path, without links, of the regular file that a model in `folder` calls `name`. Backslashes count as slashes.
/// Without `allow_outside` neither the name nor a link on the way may lead out of the folder.
///
/// Archives carry links and pipes, so a name that looks harmless may stand for any file of the machine, or for one that
/// never ends. Nothing is opened here: to open a pipe waits for whoever writes into it.
pub(crate) fn locate(folder: &Path, name: &str, allow_outside: bool) -> Result<PathBuf, Refusal> {
    let name = name.replace('\\', "/");
    if name.is_empty() || name.contains('\0') || !(allow_outside || stays_inside(&name)) {
        return Err(Refusal::Outside);
    }
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let path = folder.join(name).canonicalize().map_err(unreadable)?;
    if !allow_outside && !path.starts_with(folder.canonicalize().map_err(unreadable)?) {
        return Err(Refusal::LeadsOut);
    }
    let kind = fs::metadata(&path).map_err(unreadable)?.file_type();
    if kind.is_file() {
        Ok(path)
    } else if kind.is_dir() {
        Err(Refusal::Folder)
    } else {
        Err(Refusal::NotRegular)
    }
}

/// Whether a relative path never climbs above the folder in which it begins, links aside.
fn stays_inside(name: &str) -> bool {
    let has_drive = name.as_bytes().get(1) == Some(&b':');
    let mut depth = 0i64;
    let inside = Path::new(name).components().all(|part| {
        depth += match part {
            Component::Normal(_) => 1,
            Component::CurDir => 0,
            Component::ParentDir => -1,
            Component::RootDir | Component::Prefix(_) => return false,
        };
        depth >= 0
    });
    inside && !has_drive
}

fn unreadable(error: Error) -> Refusal {
    match error.kind() {
        // A name whose folder is a file does not exist either.
        ErrorKind::NotFound | ErrorKind::NotADirectory => Refusal::Missing,
        _ => Refusal::Unreadable(error.to_string()),
    }
}
