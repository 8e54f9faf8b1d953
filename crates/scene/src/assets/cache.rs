//! A cache of files that have been read, which notices when they change.

use std::collections::{HashMap, HashSet};
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use super::Trouble;
use crate::names;

/// A file, and the moment at which it is looked at.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    path: PathBuf,
    time_bits: Option<u64>,
}

impl Key {
    pub(super) fn new(path: PathBuf, time_seconds: Option<f64>) -> Self {
        Self { path, time_bits: time_seconds.map(f64::to_bits) }
    }
}

/// Signs that tell one state of a file from another.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Stamp {
    modified: Option<SystemTime>,
    length: u64,
}

impl From<Metadata> for Stamp {
    fn from(metadata: Metadata) -> Self {
        Self { modified: metadata.modified().ok(), length: metadata.len() }
    }
}

/// Contents of a file that other files may have a part in.
pub(super) trait Depends {
    /// Paths of these, also of those that were not there.
    fn others(&self) -> impl Iterator<Item = &Path>;
}

#[derive(Debug)]
struct Entry<T> {
    value: Arc<T>,
    stamp: Stamp,
    /// Other files that have a part in the value; `None` for one that was not there.
    others: Vec<(PathBuf, Option<Stamp>)>,
}

impl<T> Entry<T> {
    /// Whether the file at `path` and all others are as they were.
    fn is_fresh(&self, path: &Path) -> bool {
        let is_as = |path: &Path, known: Option<&Stamp>| stamp(path).ok().as_ref() == known;
        is_as(path, Some(&self.stamp)) && self.others.iter().all(|(path, known)| is_as(path, known.as_ref()))
    }
}

/// Contents of files, by their canonical paths.
#[derive(Debug)]
pub(super) struct Cache<T> {
    entries: HashMap<Key, Entry<T>>,
    /// Key of the entry for each path that has been asked for, so that asking again does not touch the disk.
    canonical: HashMap<Key, Key>,
    /// The paths asked for since the last sweep.
    used: HashSet<Key>,
}

impl<T> Default for Cache<T> {
    fn default() -> Self {
        Self { entries: HashMap::new(), canonical: HashMap::new(), used: HashSet::new() }
    }
}

impl<T: Depends> Cache<T> {
    /// Contents of the file that are kept, or else those that `read` gives, who is told what the file was at another time
    /// if that is kept.
    pub(super) fn get_or_read(
        &mut self,
        key: Key,
        read: impl FnOnce(&Path, Option<&T>) -> Result<T, Trouble>,
    ) -> Result<Arc<T>, Trouble> {
        let canonical = match self.canonical.get(&key) {
            Some(canonical) => canonical.clone(),
            None => {
                let path = fs::canonicalize(&key.path).map_err(|error| cannot_be_read(&error))?;
                Key { path, ..key }
            }
        };
        let value = match self.entries.get(&canonical) {
            Some(entry) => entry.value.clone(),
            None => {
                let stamp = stamp(&canonical.path)?;
                let earlier = self.entries.iter().find(|(known, _)| known.path == canonical.path);
                let value = Arc::new(read(&key.path, earlier.map(|(_, entry)| &*entry.value))?);
                let others = value.others().map(|path| (path.to_path_buf(), self::stamp(path).ok())).collect();
                self.entries.insert(canonical.clone(), Entry { value: value.clone(), stamp, others });
                value
            }
        };
        self.used.insert(key.clone());
        self.canonical.insert(key, canonical);
        Ok(value)
    }

    pub(super) fn files(&self) -> impl Iterator<Item = &Path> {
        self.entries.keys().map(|key| key.path.as_path())
    }

    /// Contents with the paths of their files.
    pub(super) fn entries(&self) -> impl Iterator<Item = (&Path, &T)> {
        self.entries.iter().map(|(key, entry)| (key.path.as_path(), &*entry.value))
    }

    pub(super) fn values(&self) -> impl Iterator<Item = &T> {
        self.entries.values().map(|entry| &*entry.value)
    }

    /// Forgets the files that have changed. Returns whether there was one.
    pub(super) fn refresh(&mut self) -> bool {
        let before = self.entries.len();
        self.entries.retain(|key, entry| entry.is_fresh(&key.path));
        // A link may lead elsewhere now.
        self.canonical.clear();
        self.entries.len() < before
    }

    /// Forgets the files that have not been asked for since the last sweep.
    pub(super) fn sweep(&mut self) {
        let used = std::mem::take(&mut self.used);
        self.canonical.retain(|key, _| used.contains(key));
        let named: HashSet<&Key> = self.canonical.values().collect();
        self.entries.retain(|key, _| named.contains(key));
    }
}

/// Stamp of a file. Pipes and devices are refused, because reading them may never end.
fn stamp(path: &Path) -> Result<Stamp, Trouble> {
    let metadata = fs::metadata(path).map_err(|error| cannot_be_read(&error))?;
    if metadata.is_file() { Ok(metadata.into()) } else { Err(Trouble::whole("is not a file")) }
}

fn cannot_be_read(error: &io::Error) -> Trouble {
    match error.kind() {
        io::ErrorKind::NotFound => Trouble::whole("there is no such file"),
        _ => Trouble::whole(format!("cannot be read: {}", names::escaped(&error.to_string()))),
    }
}
