//! Files of checkpoints: when they are written, how they are found again, and when they go.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use raggio_scene::display_name;

use super::{Checkpoint, CheckpointError, Checkpoints, Every};
use crate::pictures::film::FilmError;
use crate::pictures::output_file::{appended, place_of, write_free, write_keeping};
use crate::renderer::Progress;

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
    /// Moment and samples of the last that was written, or of the beginning.
    last: (Instant, u32),
    /// Words of the last failure, which are not to be said each minute.
    failure: Option<String>,
}

impl Keeper {
    /// Keeper of checkpoints at a place that can be written to.
    pub fn new(wanted: &Checkpoints) -> Result<Self, CheckpointError> {
        let place = place_of(&wanted.path)
            .map_err(|source| CheckpointError::Unwritable { path: wanted.path.clone(), source })?;
        Ok(Self { wanted: wanted.clone(), place, owns: false, last: (Instant::now(), 0), failure: None })
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
        due && self.is_worth_it(progress)
    }

    /// Whether the render takes long enough for checkpoints, as far as its rate tells.
    pub fn is_worth_it(&self, progress: &Progress) -> bool {
        !self.wanted.only_long || progress.seconds > LONG * progress.fraction
    }

    /// Writes a checkpoint and keeps the one before. A failure, of which `warn` hears once, leaves both as they were.
    /// Returns whether it has been written.
    pub fn save(&mut self, checkpoint: &Checkpoint, samples: u32, warn: &mut dyn FnMut(&str)) -> bool {
        let written = write_keeping(&self.place, &self.previous(), &|to| checkpoint.write_to(to));
        self.begin(samples);
        match written {
            Ok(()) => {
                self.owns = true;
                self.failure = None;
                true
            }
            Err(error) => {
                let failure = error.to_string();
                if self.failure.as_ref() != Some(&failure) {
                    warn(&format!("no checkpoint could be written to {}: {failure}", display_name(self.path())));
                }
                self.failure = Some(failure);
                false
            }
        }
    }

    /// Writes a checkpoint to one of `folders`, the first that takes it, for its own place does not. Returns its path.
    pub fn save_elsewhere(&self, checkpoint: &Checkpoint, folders: &[PathBuf]) -> Option<PathBuf> {
        let name = Path::new(self.place.file_name()?);
        folders.iter().find_map(|folder| write_free(folder, name, &|to| checkpoint.write_to(to)).ok())
    }

    /// The newest of the checkpoints that this render has written.
    pub fn newest(&self) -> Option<Checkpoint> {
        let own = |place: &Path| read(place, place).ok().flatten();
        if self.owns { own(&self.place).or_else(|| own(&self.previous())) } else { None }
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
