//! Files that others change while they are shown.

use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use notify::{RecommendedWatcher, RecursiveMode, Watcher};

/// Quiet time after the last step of a change: programs write a file in several steps.
const QUIET: Duration = Duration::from_millis(80);

/// Tells when something in a folder has changed.
pub struct Watch {
    // The watcher stops watching when it goes.
    _watcher: RecommendedWatcher,
    files: Vec<PathBuf>,
    changes: Receiver<()>,
    last: Option<Instant>,
}

enum Wanted {
    Files(HashSet<PathBuf>),
    Ending(&'static str),
}

impl Watch {
    /// Watches files, given by their canonical paths, through their folders: many programs replace a file rather than
    /// write into it.
    pub fn files(files: Vec<PathBuf>, wake: impl Fn() + Send + 'static) -> Result<Self, notify::Error> {
        let folders: BTreeSet<_> = files.iter().filter_map(|file| file.parent()).map(Path::to_path_buf).collect();
        let wanted = Wanted::Files(files.iter().cloned().collect());
        let folders = folders.iter().map(PathBuf::as_path);
        Ok(Self { files, ..Self::new(folders, RecursiveMode::NonRecursive, wanted, wake)? })
    }

    /// Files that [`Watch::files`] was given.
    pub fn watched(&self) -> &[PathBuf] {
        &self.files
    }

    /// Watches all files below `folder` with this ending.
    pub fn files_below(
        folder: &Path,
        ending: &'static str,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, notify::Error> {
        Self::new([folder], RecursiveMode::Recursive, Wanted::Ending(ending), wake)
    }

    fn new<'a>(
        folders: impl IntoIterator<Item = &'a Path>,
        mode: RecursiveMode,
        wanted: Wanted,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, notify::Error> {
        let (sender, changes) = channel();
        let mut watcher = notify::recommended_watcher(move |event: Result<notify::Event, notify::Error>| {
            // Reading is no change; not to be woken by one's own eyes.
            let Some(event) = event.ok().filter(|event| !event.kind.is_access()) else { return };
            // Nobody listens once the window is closing.
            if event.paths.iter().any(|path| wanted.is(path)) && sender.send(()).is_ok() {
                wake();
            }
        })?;
        for folder in folders {
            watcher.watch(folder, mode)?;
        }
        Ok(Self { _watcher: watcher, files: Vec::new(), changes, last: None })
    }

    /// Whether a change is over; true once after each.
    pub fn changed(&mut self) -> bool {
        if self.changes.try_iter().count() > 0 {
            self.last = Some(Instant::now());
        }
        let over = self.last.is_some_and(|at| at.elapsed() >= QUIET);
        if over {
            self.last = None;
        }
        over
    }

    /// Whether a change is under way, which makes it worth asking again soon.
    pub fn is_waiting(&self) -> bool {
        self.last.is_some()
    }
}

impl Wanted {
    fn is(&self, path: &Path) -> bool {
        match self {
            Self::Files(files) => files.contains(path),
            Self::Ending(ending) => path.extension().is_some_and(|e| e == *ending),
        }
    }
}
