//! Files that others change while they are shown.

use std::ffi::OsString;
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use notify::{RecommendedWatcher, RecursiveMode, Watcher};

/// Programs write a file in several steps; after the last one it is quiet for so long.
const QUIET: Duration = Duration::from_millis(80);

/// Tells when something in a folder has changed.
pub struct Watch {
    // Stops watching when it goes.
    _watcher: RecommendedWatcher,
    changes: Receiver<()>,
    last: Option<Instant>,
}

enum Wanted {
    File(OsString),
    Ending(&'static str),
}

impl Watch {
    /// One file. Its folder is what is watched: many programs replace a file rather than write into it.
    pub fn file(path: &Path, wake: impl Fn() + Send + 'static) -> Result<Self, notify::Error> {
        // What a link leads to is what changes.
        let path = path.canonicalize().map_err(notify::Error::io)?;
        let name = path.file_name().unwrap_or_default().to_owned();
        Self::new(path.parent().unwrap_or(Path::new("/")), RecursiveMode::NonRecursive, Wanted::File(name), wake)
    }

    /// All files below `folder` with this ending.
    pub fn files_below(
        folder: &Path,
        ending: &'static str,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, notify::Error> {
        Self::new(folder, RecursiveMode::Recursive, Wanted::Ending(ending), wake)
    }

    fn new(
        folder: &Path,
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
        watcher.watch(folder, mode)?;
        Ok(Self { _watcher: watcher, changes, last: None })
    }

    /// True once after each change, when it is over.
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

    /// A change is under way: worth asking again soon.
    pub fn is_waiting(&self) -> bool {
        self.last.is_some()
    }
}

impl Wanted {
    fn is(&self, path: &Path) -> bool {
        match self {
            Self::File(name) => path.file_name() == Some(name),
            Self::Ending(ending) => path.extension().is_some_and(|e| e == *ending),
        }
    }
}
