//! Films as they are taken from a device in the middle of a render.

use std::io;

use super::SamplingState;
use crate::pictures::file_faults::Sink;
use crate::pictures::film::{Film, Label, Note};
use crate::renderer::{LateLabel, Progress};

/// A film of radiance with all that a checkpoint of it takes: hashing and writing can be left to another thread.
#[derive(Clone, Debug)]
pub(crate) struct Gathered {
    /// Film without its label.
    pub film: Film,
    pub label: LateLabel,
    /// Notes of its label.
    pub notes: Vec<Note>,
    pub state: SamplingState,
    /// Progress at that moment.
    pub progress: Progress,
}

impl Gathered {
    /// Label of the film, which takes a hash of the whole scene.
    pub fn label(&self) -> Label {
        self.label.make().with_notes(self.notes.clone())
    }

    /// Writes the film with its state, as a checkpoint, to an open file.
    pub fn write_to(&self, to: &mut Sink) -> io::Result<()> {
        self.film.write_as(&self.label(), to, &[self.state.note()])
    }
}
