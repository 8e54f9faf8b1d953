//! Renderers that go on from a checkpoint.

use std::path::Path;
use std::time::Duration;

use raggio_kernels::Feature;

use super::{Adaptive, Course, Renderer};
use crate::checkpoint::{AdaptiveState, Checkpoint, CheckpointError, SamplingState};
use crate::devices::adaptive::Blocks;
use crate::devices::device::DeviceError;
use crate::pictures::film::{Film, FilmError, MergeError};

impl Renderer {
    /// State of the sampling of the film that is shown, from which [`Renderer::resume`] goes on.
    pub(crate) fn sampling_state(&self) -> SamplingState {
        let Course { pass, row, sampling, total, .. } = self.courses.shown();
        let adaptive = self.adaptive.as_ref().map(|adaptive| AdaptiveState {
            judgement: adaptive.judgement,
            error: adaptive.error,
            resting: adaptive.blocks.words().to_vec(),
        });
        SamplingState {
            first: self.samples.start,
            pass: pass.clone(),
            row: *row,
            seconds: sampling.as_secs_f64(),
            spent: sampling.as_secs_f64(),
            total: *total,
            adaptive,
        }
    }

    /// Checks that a film, found at `path`, is of this renderer's picture.
    ///
    /// # Errors
    /// [`CheckpointError::Other`] when it is of another.
    pub(crate) fn check_film(&self, film: &Film, path: &Path) -> Result<(), CheckpointError> {
        let other = |difference| CheckpointError::Other { path: path.into(), difference: Box::new(difference) };
        let (now, then) = ([self.width, self.height], [film.width(), film.height()]);
        if now != then {
            return Err(other(MergeError::Size(now, then)));
        }
        let label = film.label().ok_or_else(|| other(MergeError::Unlabelled))?;
        self.label().check_same_picture(label).map_err(other)
    }

    /// Goes on from a checkpoint, found at `path`, of the same picture and of samples that are to be rendered, in place of
    /// the first sample.
    ///
    /// # Errors
    /// A [`CheckpointError`] when the checkpoint is of something else, or the device fails.
    pub(crate) fn resume(&mut self, checkpoint: &Checkpoint, path: &Path) -> Result<(), CheckpointError> {
        let Checkpoint { film, state } = checkpoint;
        let damaged = || FilmError::Damaged {
            path: path.into(),
            reason: "how its sampling goes on is not as its film says".into(),
        };
        self.check_film(film, path)?;
        let label = film.label().ok_or_else(damaged)?;
        if state.first != self.samples.start || state.pass.end > self.samples.end {
            let [found, wanted] =
                [state.first..state.pass.end, self.samples.clone()].map(|range| [range.start, range.end]);
            return Err(CheckpointError::Samples { path: path.into(), found, wanted });
        }
        let adaptive = self.adaptive_of(state).ok_or_else(damaged)?;
        if self.late_label_at(&state.pass, state.row).make().portions() != label.portions() {
            return Err(damaged().into());
        }
        self.show(Feature::Radiance)?;
        Ok(self.go_on(film, state, adaptive)?)
    }

    /// Adaptive sampling as `state` has it, if this renderer samples so; `None` where the state is not one of such a picture.
    pub(super) fn adaptive_of(&self, state: &SamplingState) -> Option<Option<Adaptive>> {
        match (&self.adaptive, &state.adaptive) {
            (None, None) => Some(None),
            (Some(Adaptive { noise, .. }), Some(AdaptiveState { judgement, error, resting })) => {
                let blocks = Blocks::from_words(self.width, self.height, resting.clone())?;
                let active = blocks.active_pixels(0..self.height);
                Some(Some(Adaptive { noise: *noise, blocks, active, judgement: *judgement, error: *error }))
            }
            _ => None,
        }
    }

    /// Goes on from the sums of `film`, whose sampling is in `state`, in the film of radiance, which is shown.
    pub(super) fn go_on(
        &mut self,
        film: &Film,
        state: &SamplingState,
        adaptive: Option<Adaptive>,
    ) -> Result<(), DeviceError> {
        self.session.set_film(film)?;
        if let Some(adaptive) = &adaptive {
            self.session.rest(Some(&adaptive.blocks))?;
        }
        *self.courses.shown_mut() = Course {
            pass: state.pass.clone(),
            row: state.row,
            sampling: Duration::try_from_secs_f64(state.seconds).unwrap_or_default(),
            total: state.total,
            ..Course::new(self.height, self.samples.start, self.rate(), 0.0)
        };
        self.adaptive = adaptive;
        Ok(())
    }
}
