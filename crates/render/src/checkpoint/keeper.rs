//! Files of checkpoints: when they are written, how they are found again, and when they go.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use raggio_scene::display_name;

use super::lock::{Lock, NoLock};
use super::{Checkpoint, CheckpointError, Checkpoints, Every, Gathered, SamplingState};
use crate::pictures::file_faults::Writing;
use crate::pictures::film::FilmError;
use crate::pictures::output_file::{appended, place_of, write_free, write_keeping};
use crate::renderer::Progress;
use crate::request::Observer;

/// Seconds that a render has to take, at least, for being long.
const LONG: f64 = 60.0;

/// Keeper of the checkpoints of a render.
#[derive(Debug)]
pub(crate) struct Keeper {
    wanted: Checkpoints,
    /// Path from the root and without links, which stays right whatever becomes of the current folder.
    place: PathBuf,
    /// Whether the files are this render's: it has written them, or goes on from them.
    owns: bool,
    /// Checkpoint that is being written, of this state.
    writing: Option<(SamplingState, Writing<io::Result<()>>)>,
    /// State of the last that was written.
    written: Option<SamplingState>,
    /// Moment and samples of the last that was written, or of the beginning.
    last: (Instant, u32),
    /// Words of the last failure, which are not to be said each minute.
    failure: Option<String>,
    /// Lock that keeps other renders from these files; it goes last.
    _lock: Option<Lock>,
}

impl Keeper {
    /// Keeper of checkpoints at a place that can be written to, and that no other render keeps any at. `warn` hears where
    /// nobody can tell.
    pub fn new(wanted: &Checkpoints, warn: &mut dyn FnMut(String)) -> Result<Self, CheckpointError> {
        let place = place_of(&wanted.path)
            .map_err(|source| CheckpointError::Unwritable { path: wanted.path.clone(), source })?;
        let lock = match Lock::take(&appended(&place, ".lock")) {
            Ok(lock) => Some(lock),
            Err(NoLock::Taken(by)) => return Err(CheckpointError::InUse { path: wanted.path.clone(), by }),
            Err(NoLock::Unknown(error)) => {
                let path = display_name(&wanted.path);
                warn(format!(
                    "{path} cannot be locked ({error}): see to it that no other render keeps its checkpoint there"
                ));
                None
            }
        };
        Ok(Self {
            wanted: wanted.clone(),
            place,
            owns: false,
            writing: None,
            written: None,
            last: (Instant::now(), 0),
            failure: None,
            _lock: lock,
        })
    }

    /// Path of the checkpoint, as it was given.
    pub fn path(&self) -> &Path {
        &self.wanted.path
    }

    /// Path of the one before.
    fn previous(&self) -> PathBuf {
        appended(&self.place, ".previous")
    }

    /// Whether the files are this render's.
    pub fn owns(&self) -> bool {
        self.owns
    }

    /// Finds the checkpoint to go on from, with its path: the newest, or the one before it where that is missing or
    /// damaged. `warn` hears of it.
    pub fn find(&mut self, warn: &mut dyn FnMut(String)) -> Result<Option<(PathBuf, Checkpoint)>, CheckpointError> {
        let previous = appended(self.path(), ".previous");
        let found = match read(&self.place, self.path()) {
            Ok(Some(checkpoint)) => Some((self.path().to_owned(), checkpoint)),
            Ok(None) => {
                let before = read(&self.previous(), &previous)?;
                if before.is_some() {
                    let [path, previous] = [self.path(), &previous].map(display_name);
                    warn(format!("{path} is missing: the checkpoint before it is used, {previous}"));
                }
                before.map(|checkpoint| (previous, checkpoint))
            }
            Err(CheckpointError::Unreadable(damage)) if is_damage(&damage) => {
                match read(&self.previous(), &previous) {
                    Ok(Some(checkpoint)) => {
                        warn(format!("{damage}: the checkpoint before it is used, {}", display_name(&previous)));
                        Some((previous, checkpoint))
                    }
                    // What is no film at all may be a file of somebody else's.
                    Ok(None) if matches!(damage, FilmError::NotAFilm { .. }) => return Err(damage.into()),
                    Ok(None) => {
                        warn(format!("{damage}, and there is none before it: the render begins anew"));
                        None
                    }
                    Err(CheckpointError::Unreadable(FilmError::Damaged { reason, .. })) => {
                        warn(format!(
                            "{damage}, and the one before it is damaged too ({reason}): the render begins anew"
                        ));
                        None
                    }
                    Err(error) => return Err(error),
                }
            }
            Err(error) => return Err(error),
        };
        self.owns |= found.is_some();
        Ok(found)
    }

    /// Counts from now on, after so many samples.
    pub fn begin(&mut self, samples: u32) {
        self.last = (Instant::now(), samples);
    }

    /// Whether the next checkpoint is due.
    pub fn is_due(&self, progress: &Progress) -> bool {
        let (moment, samples) = self.last;
        let due = match self.wanted.every {
            Every::Seconds(seconds) => moment.elapsed().as_secs_f64() >= seconds,
            Every::Samples(count) => progress.samples.saturating_sub(samples) >= count,
        };
        due && self.writing.is_none() && self.is_worth_it(progress)
    }

    /// Whether the render takes long enough for checkpoints, as far as its rate tells.
    pub fn is_worth_it(&self, progress: &Progress) -> bool {
        !self.wanted.only_long || progress.seconds > LONG * progress.fraction
    }

    /// Writes a checkpoint on a thread of its own, and keeps the one before; the last that was begun has to have ended.
    pub fn begin_writing(&mut self, gathered: Arc<Gathered>, observer: &mut dyn Observer) {
        let (place, previous) = (self.place.clone(), self.previous());
        let state = gathered.state.clone();
        self.begin(gathered.progress.samples);
        match Writing::begin(move || write_keeping(&place, &previous, &|to| gathered.write_to(to))) {
            Ok(writing) => self.writing = Some((state, writing)),
            Err(error) => self.conclude(state, Err(error), observer),
        }
    }

    /// Tells what has become of the checkpoint that is being written, once it has ended.
    pub fn look_after(&mut self, observer: &mut dyn Observer) {
        if self.writing.as_ref().is_some_and(|(_, writing)| writing.has_ended()) {
            self.finish_writing(observer);
        }
    }

    /// Waits for the checkpoint that is being written.
    pub fn finish_writing(&mut self, observer: &mut dyn Observer) {
        if let Some((state, writing)) = self.writing.take() {
            self.conclude(state, writing.end(), observer);
            // The next is due so long after the end, whatever the writing took.
            self.last.0 = Instant::now();
        }
    }

    /// A failure, of which `observer` hears once, has left the files as they were.
    fn conclude(&mut self, state: SamplingState, written: io::Result<()>, observer: &mut dyn Observer) {
        match written {
            Ok(()) => {
                self.owns = true;
                (self.failure, self.written) = (None, Some(state));
                observer.saved(self.path());
            }
            Err(error) => {
                let failure = error.to_string();
                if self.failure.as_ref() != Some(&failure) {
                    let path = display_name(self.path());
                    observer.warn(&format!("no checkpoint could be written to {path}: {failure}"));
                }
                self.failure = Some(failure);
            }
        }
    }

    /// Writes a checkpoint, unless it is the last that was, and waits for it. Returns whether it is there.
    pub fn save(&mut self, gathered: &Arc<Gathered>, observer: &mut dyn Observer) -> bool {
        self.finish_writing(observer);
        let is_there = |keeper: &Self| keeper.written.as_ref() == Some(&gathered.state);
        if !is_there(self) {
            self.begin_writing(gathered.clone(), observer);
            self.finish_writing(observer);
        }
        is_there(self)
    }

    /// Writes a checkpoint to one of `folders`, the first that takes it, for its own place does not. Returns its path.
    pub fn save_elsewhere(&self, gathered: &Gathered, folders: &[PathBuf]) -> Option<PathBuf> {
        let name = Path::new(self.place.file_name()?);
        folders.iter().find_map(|folder| write_free(folder, name, &|to| gathered.write_to(to)).ok())
    }

    /// Removes what this render has written: nothing of it is needed any more.
    pub fn remove(&self) -> io::Result<()> {
        if !self.owns {
            return Ok(());
        }
        for place in [&self.place, &self.previous(), &appended(&self.place, ".part")] {
            match std::fs::remove_file(place) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }
}

impl Drop for Keeper {
    fn drop(&mut self) {
        // Nobody else may write there before this has ended.
        if let Some((_, writing)) = self.writing.take() {
            let _ = writing.end();
        }
    }
}

/// Whether the file is not what was written. A file whose first bytes are others is no film at all.
fn is_damage(error: &FilmError) -> bool {
    matches!(error, FilmError::Damaged { .. } | FilmError::NotAFilm { .. })
}

/// Reads the checkpoint at `place`, which errors call `path`; `None` where there is no such file.
fn read(place: &Path, path: &Path) -> Result<Option<Checkpoint>, CheckpointError> {
    match Checkpoint::read(place) {
        Ok(Some(checkpoint)) => Ok(Some(checkpoint)),
        Ok(None) => Err(CheckpointError::NoCheckpoint { path: path.into() }),
        Err(FilmError::Unreadable { source, .. }) if source.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error.at(path).into()),
    }
}
