//! Devices that fail in the middle of a render: what there is of it stays, and the render goes on where it can.

use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use raggio_scene::counted;

use super::Rendering;
use crate::checkpoint::{Checkpoint, Gathered};
use crate::devices::device::DeviceError;
use crate::renderer::Progress;
use crate::request::Observer;

/// Failures in a row, without a film that could be gathered in between, after which a render ends.
const MOST_FAILURES: u32 = 3;
/// Seconds between two films that are gathered in case that the device is lost, at least.
const GATHERING_SECONDS: f64 = 10.0;
/// Multiple of the time that gathering takes that lies between two of them, at least.
const GATHERING_PART: f64 = 100.0;
/// Time that a driver gets for its reset before the second attempt to open the device again.
const PAUSE: Duration = Duration::from_secs(1);

/// Film in safety from a device that may be lost.
#[derive(Default)]
pub(super) struct Safety {
    film: Option<Arc<Gathered>>,
    /// Moment at which it was gathered, or at which sampling began, and the seconds that it took.
    last: Option<(Instant, f64)>,
    /// Whether the device was lost, and has not been opened again.
    is_lost: bool,
    /// Failures since a film was gathered.
    failures: u32,
}

impl Safety {
    /// The film that was gathered last.
    pub fn gathered(&self) -> Option<Arc<Gathered>> {
        self.film.clone()
    }

    fn is_due(&self) -> bool {
        let is_over = |(moment, took): (Instant, f64)| {
            moment.elapsed().as_secs_f64() >= GATHERING_SECONDS.max(GATHERING_PART * took)
        };
        self.last.is_none_or(is_over)
    }
}

impl Rendering {
    /// Makes ready for sampling: a device that stayed lost is opened again, if it can be by now.
    pub(super) fn begin_safely(&mut self) -> Result<(), DeviceError> {
        if self.safety.is_lost {
            self.revive()?;
        }
        self.safety.last.get_or_insert((Instant::now(), 0.0));
        Ok(())
    }

    /// Gathers the film where a checkpoint is due, or where it is time to have it in safety.
    pub(super) fn keep(&mut self, progress: &Progress, observer: &mut dyn Observer) -> Result<(), DeviceError> {
        if let Some(keeper) = &mut self.keeper {
            keeper.look_after(observer);
        }
        if self.renderer.finished() {
            return Ok(());
        }
        let is_checkpoint_due = self.keeper.as_ref().is_some_and(|keeper| keeper.is_due(progress));
        if is_checkpoint_due || self.renderer.session().may_be_lost() && self.safety.is_due() {
            let gathered = self.gather()?;
            if let Some(keeper) = self.keeper.as_mut().filter(|_| is_checkpoint_due) {
                keeper.begin_writing(gathered, observer);
            }
        }
        Ok(())
    }

    /// The film as it is now.
    pub(super) fn read(&mut self) -> Result<Gathered, DeviceError> {
        if self.safety.is_lost {
            return Err(DeviceError::Host("the device was lost, and its film with it".into()));
        }
        // What may be lost may be asked again.
        let takes = self.is_last && !self.renderer.session().may_be_lost();
        let mut gathered = self.renderer.gather(takes)?;
        gathered.notes = self.metadata.notes();
        gathered.state.spent = self.spent;
        Ok(gathered)
    }

    /// The film as it is now, which stays in safety if the device may be lost.
    fn gather(&mut self) -> Result<Arc<Gathered>, DeviceError> {
        let start = Instant::now();
        let gathered = Arc::new(self.read()?);
        if self.renderer.session().may_be_lost() {
            self.safety.film = Some(gathered.clone());
            self.safety.last = Some((Instant::now(), start.elapsed().as_secs_f64()));
            self.safety.failures = 0;
        }
        Ok(gathered)
    }

    /// Has the film of a checkpoint, from which the render goes on, in safety.
    pub(super) fn keep_safe(&mut self, checkpoint: Checkpoint) {
        if self.renderer.session().may_be_lost() {
            let Checkpoint { film, state } = checkpoint;
            let (label, progress) = (self.renderer.late_label(), self.renderer.progress());
            let notes = self.metadata.notes();
            self.safety.film = Some(Arc::new(Gathered { film, label, notes, state, progress }));
        }
    }

    /// Goes back after `error` to the film that was gathered last, on the device opened again: what it has lost is sampled once more.
    ///
    /// # Errors
    /// `error` where the film can still be read, the device stays lost, or this has happened too often.
    pub(super) fn overcome(&mut self, error: DeviceError, observer: &mut dyn Observer) -> Result<(), DeviceError> {
        if !self.renderer.session().may_be_lost() || self.gather().is_ok() {
            return Err(error);
        }
        self.safety.is_lost = true;
        if self.safety.failures >= MOST_FAILURES {
            return Err(error);
        }
        self.safety.failures += 1;
        let Ok(done) = self.revive() else { return Err(error) };
        let samples = counted(self.renderer.progress().samples as usize, "sample");
        observer.warn(&format!("{error}: {done}, and the render goes on from {samples} per pixel"));
        Ok(())
    }

    /// Opens the device again, and brings the film that was gathered last to it. Returns what has been done, in words.
    fn revive(&mut self) -> Result<String, DeviceError> {
        let film = self.safety.gathered();
        let done = match self.renderer.revive(&self.scene, film.as_deref()) {
            Err(error) if error.is_lost() => {
                sleep(PAUSE);
                self.renderer.revive(&self.scene, film.as_deref())?
            }
            revived => revived?,
        };
        self.safety.is_lost = false;
        Ok(done)
    }

    /// Begins anew with the scene as it is now, opened again where the device was lost.
    pub(super) fn restart_device(&mut self) -> Result<(), DeviceError> {
        self.safety = Safety { is_lost: self.safety.is_lost, ..Safety::default() };
        if !self.safety.is_lost {
            match self.renderer.restart(&self.scene) {
                Err(error) if error.is_lost() => self.safety.is_lost = true,
                restarted => return restarted,
            }
        }
        self.renderer.restart_lost(&self.scene)?;
        self.safety.is_lost = false;
        Ok(())
    }
}
