//! State of sampling, as films keep it in a note.

use std::ops::Range;
use std::path::Path;

use crate::pictures::film::{Film, FilmError, Note};

/// A film with the state of its sampling.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Checkpoint {
    /// Film of radiance, with its label.
    pub film: Film,
    pub state: SamplingState,
}

/// State in which sampling goes on as if nothing had happened in between.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SamplingState {
    /// First sample of each pixel.
    pub first: u32,
    /// Samples of the pass under way.
    pub pass: Range<u32>,
    /// Row that the pass has come to.
    pub row: u32,
    /// Time of sampling so far.
    pub seconds: f64,
    /// Time so far, with that between portions of work: what a time limit limits.
    pub spent: f64,
    /// Number of samples in all pixels together.
    pub total: u64,
    pub adaptive: Option<AdaptiveState>,
}

/// State of adaptive sampling.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AdaptiveState {
    /// Samples at which blocks are judged next.
    pub judgement: u32,
    /// Largest error of a block when they were judged last.
    pub error: f64,
    /// Bits of the blocks that rest.
    pub resting: Vec<u32>,
}

impl Checkpoint {
    /// Reads a checkpoint; `None` for a film that is none.
    ///
    /// # Errors
    /// A [`FilmError`] as of [`Film::read`]; also when the state is not one of such a film.
    pub fn read(path: &Path) -> Result<Option<Self>, FilmError> {
        let (film, notes) = Film::read_with_notes(path)?;
        let Some(note) = notes.iter().find(|note| note.name == Note::SAMPLING) else { return Ok(None) };
        let state = SamplingState::from_bytes(&note.value)
            .filter(|state| state.first <= state.pass.start && state.pass.start <= state.pass.end)
            .filter(|state| state.row <= film.height());
        match state {
            Some(state) => Ok(Some(Self { film, state })),
            None => {
                Err(FilmError::Damaged { path: path.into(), reason: "how its sampling goes on cannot be read".into() })
            }
        }
    }
}

impl SamplingState {
    /// Note by which a film is a checkpoint.
    pub fn note(&self) -> Note {
        Note::new(Note::SAMPLING, self.to_bytes())
    }

    fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![];
        for word in [self.first, self.pass.start, self.pass.end, self.row] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(self.seconds.to_le_bytes());
        bytes.extend(self.spent.to_le_bytes());
        bytes.extend(self.total.to_le_bytes());
        if let Some(AdaptiveState { judgement, error, resting }) = &self.adaptive {
            bytes.extend(judgement.to_le_bytes());
            bytes.extend(error.to_le_bytes());
            bytes.extend(resting.iter().flat_map(|word| word.to_le_bytes()));
        }
        bytes
    }

    fn from_bytes(mut bytes: &[u8]) -> Option<Self> {
        let mut word = || Some(u32::from_le_bytes(take(&mut bytes)?));
        let (first, start, end, row) = (word()?, word()?, word()?, word()?);
        let [seconds, spent] = [f64::from_le_bytes(take(&mut bytes)?), f64::from_le_bytes(take(&mut bytes)?)];
        let total = u64::from_le_bytes(take(&mut bytes)?);
        let [seconds, spent] = [seconds, spent].map(|time| time.max(0.0));
        let mut state = Self { first, pass: start..end, row, seconds, spent, total, adaptive: None };
        if !bytes.is_empty() {
            let judgement = u32::from_le_bytes(take(&mut bytes)?);
            let error = f64::from_le_bytes(take(&mut bytes)?);
            let mut resting = vec![];
            while !bytes.is_empty() {
                resting.push(u32::from_le_bytes(take(&mut bytes)?));
            }
            state.adaptive = Some(AdaptiveState { judgement, error, resting });
        }
        Some(state)
    }
}

/// The next bytes, if there are so many.
fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (taken, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_come_back_as_they_were() {
        let adaptive = AdaptiveState { judgement: 96, error: f64::INFINITY, resting: vec![0, u32::MAX, 5] };
        let plain =
            SamplingState { first: 3, pass: 64..96, row: 7, seconds: 1.5, spent: 2.0, total: 1 << 40, adaptive: None };
        for state in [plain.clone(), SamplingState { adaptive: Some(adaptive), ..plain }] {
            let bytes = state.to_bytes();
            assert_eq!(SamplingState::from_bytes(&bytes), Some(state.clone()));
            for length in (0..bytes.len()).filter(|length| *length < 40 || length % 4 != 0) {
                assert_eq!(SamplingState::from_bytes(&bytes[..length]), None, "{length} bytes of {state:?}");
            }
        }
    }
}
