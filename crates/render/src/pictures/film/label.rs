//! Labels of films: the picture that a film is of, and the samples that it has.

use std::fmt;
use std::ops::Range;

use crate::pictures::fingerprint;

/// Samples that all pixels of some rows have been given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Portion {
    /// Numbers of the samples.
    pub samples: Range<u32>,
    /// Rows of pixels, from the top.
    pub rows: Range<u32>,
}

/// Label of a film: the picture that it is of, and the samples that it has. Films of one picture that share no sample
/// may be merged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    pub(super) version: String,
    pub(super) scene: [u8; 32],
    pub(super) settings: Vec<(String, String)>,
    pub(super) portions: Vec<Portion>,
    pub(super) notes: Vec<Note>,
}

/// What a film says besides; films may be merged whatever their notes are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Note {
    pub name: String,
    pub value: Vec<u8>,
}

impl Note {
    /// Name of the note by which a render goes on from the film: it is right of the very file that has it.
    pub const SAMPLING: &str = "sampling";

    pub fn new(name: &str, value: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), value: value.into() }
    }

    /// Whether the note is no longer true of a film to which others have been added.
    pub fn belongs_to_file(&self) -> bool {
        [Self::SAMPLING, fingerprint::NAME].contains(&&*self.name)
    }
}

/// Reasons why two films cannot be merged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// Widths and heights in pixels that differ.
    #[error("films of {}x{} and {}x{} pixels cannot be merged", .0[0], .0[1], .1[0], .1[1])]
    Size([u32; 2], [u32; 2]),
    /// Versions of raggio that differ, and with them perhaps the values of samples.
    #[error("the films were made by raggio {0} and raggio {1}: sample both with one version")]
    Version(String, String),
    /// Scenes, or cameras, that differ.
    #[error("the films are of different scenes, or of one that was changed in between")]
    Scene,
    /// A setting that differs, and its two values; empty where a film has none.
    #[error("the films differ in {key}: `{first}` and `{second}`")]
    Setting {
        /// Name of the setting, as `max_depth`.
        key: String,
        /// Value of the film that was to grow.
        first: String,
        /// Value of the film that was to be added.
        second: String,
    },
    /// Samples that both films have: they would count twice.
    #[error("both films have {0}: they would count twice")]
    Overlap(Portion),
    /// A film with a label and one without.
    #[error("one of the films does not say what it is of")]
    Unlabelled,
}

impl Label {
    /// Label of a film of the scene with this hash, sampled with `settings` as keys and values.
    pub(crate) fn new(scene: [u8; 32], settings: Vec<(String, String)>, portions: Vec<Portion>) -> Self {
        let mut label =
            Self { version: env!("CARGO_PKG_VERSION").into(), scene, settings, portions: vec![], notes: vec![] };
        portions.into_iter().for_each(|portion| label.add(portion));
        label
    }

    /// Version of raggio that took the samples.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Hash (BLAKE3) of all that kernels read of the scene, the camera included.
    pub fn scene(&self) -> &[u8; 32] {
        &self.scene
    }

    /// Settings of sampling that decide the values of samples, as keys and values: `max_depth`, `10`.
    pub fn settings(&self) -> impl Iterator<Item = (&str, &str)> {
        self.settings.iter().map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// Samples that the film has, in order; no two portions have one in common. A pixel has fewer where adaptive
    /// sampling let it rest.
    pub fn portions(&self) -> &[Portion] {
        &self.portions
    }

    /// Value of a note.
    pub(crate) fn note(&self, name: &str) -> Option<&[u8]> {
        self.notes.iter().find(|note| note.name == name).map(|note| &note.value[..])
    }

    /// The label with these notes in place of its own.
    pub(crate) fn with_notes(self, notes: Vec<Note>) -> Self {
        Self { notes, ..self }
    }

    /// Samples of a film of `height` rows that are missing up to the last that it has; no two portions have one in
    /// common.
    pub fn missing(&self, height: u32) -> Vec<Portion> {
        let mut bounds: Vec<u32> = self.portions.iter().flat_map(|p| [p.samples.start, p.samples.end]).collect();
        bounds.push(0);
        bounds.sort_unstable();
        bounds.dedup();
        let mut missing = Self { portions: vec![], ..self.clone() };
        for samples in bounds.windows(2).map(|pair| pair[0]..pair[1]) {
            let has = |p: &&Portion| p.samples.start <= samples.start && p.samples.end >= samples.end;
            // Portions are in the order of their rows where they have the same samples, and share none.
            let mut rows: Vec<_> = self.portions.iter().filter(has).map(|p| p.rows.clone()).collect();
            rows.sort_by_key(|rows| rows.start);
            rows.push(height..height);
            let mut top = 0;
            for covered in rows {
                missing.add(Portion { samples: samples.clone(), rows: top..covered.start });
                top = covered.end;
            }
        }
        missing.portions
    }

    /// Takes the portions of `other` in, if that is a label of the same picture and has other samples.
    pub(super) fn merge(&mut self, other: &Self) -> Result<(), MergeError> {
        self.check_same_picture(other)?;
        let pairs = self.portions.iter().flat_map(|a| other.portions.iter().map(move |b| (a, b)));
        if let Some(common) = pairs.filter_map(|(a, b)| a.common(b)).next() {
            return Err(MergeError::Overlap(common));
        }
        other.portions.iter().cloned().for_each(|portion| self.add(portion));
        for note in &other.notes {
            if self.note(&note.name).is_none() {
                self.notes.push(note.clone());
            }
        }
        Ok(())
    }

    /// Checks that both labels are of one picture, sampled in one way.
    ///
    /// # Errors
    /// A [`MergeError`] when they are of different pictures, or of one that was sampled in different ways.
    pub(crate) fn check_same_picture(&self, other: &Self) -> Result<(), MergeError> {
        if self.version != other.version {
            return Err(MergeError::Version(self.version.clone(), other.version.clone()));
        }
        let value = |label: &Self, key: &str| {
            let found = label.settings.iter().find(|(known, _)| known == key);
            found.map(|(_, value)| value.clone()).unwrap_or_default()
        };
        // Settings first: some of them are in the scene's hash too, and the setting says more.
        for (key, _) in self.settings.iter().chain(&other.settings) {
            let (first, second) = (value(self, key), value(other, key));
            if first != second {
                return Err(MergeError::Setting { key: key.clone(), first, second });
            }
        }
        if self.scene == other.scene { Ok(()) } else { Err(MergeError::Scene) }
    }

    /// Adds a portion, none of whose samples are there, and joins it with those that it continues.
    fn add(&mut self, mut new: Portion) {
        if new.is_empty() {
            return;
        }
        while let Some(place) = self.portions.iter().position(|portion| portion.joined(&new).is_some()) {
            let neighbour = self.portions.swap_remove(place);
            new = neighbour.joined(&new).unwrap_or(new);
        }
        self.portions.push(new);
        self.portions.sort_by_key(|portion| (portion.samples.start, portion.rows.start));
    }
}

impl Portion {
    /// The portion in words, in a film of `height` rows: without its rows where they are all.
    pub fn within(&self, height: u32) -> String {
        let Self { samples, rows } = self;
        if *rows == (0..height) { format!("samples {}..{}", samples.start, samples.end) } else { self.to_string() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.samples.is_empty() || self.rows.is_empty()
    }

    /// Portion that is in both, if they have one in common.
    pub(super) fn common(&self, other: &Self) -> Option<Self> {
        let both = |a: &Range<u32>, b: &Range<u32>| a.start.max(b.start)..a.end.min(b.end);
        let common = Self { samples: both(&self.samples, &other.samples), rows: both(&self.rows, &other.rows) };
        (!common.is_empty()).then_some(common)
    }

    /// Portion that is both together, if one continues the other.
    fn joined(&self, other: &Self) -> Option<Self> {
        let meet = |a: &Range<u32>, b: &Range<u32>| a.end == b.start || b.end == a.start;
        let around = |a: &Range<u32>, b: &Range<u32>| a.start.min(b.start)..a.end.max(b.end);
        let (samples, rows) = (around(&self.samples, &other.samples), around(&self.rows, &other.rows));
        let continues = self.rows == other.rows && meet(&self.samples, &other.samples)
            || self.samples == other.samples && meet(&self.rows, &other.rows);
        continues.then_some(Self { samples, rows })
    }
}

impl fmt::Display for Portion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { samples, rows } = self;
        write!(f, "samples {}..{} of rows {}..{}", samples.start, samples.end, rows.start, rows.end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn portion(samples: Range<u32>, rows: Range<u32>) -> Portion {
        Portion { samples, rows }
    }

    fn label(portions: &[Portion]) -> Label {
        Label::new([7; 32], vec![("seed".into(), "0".into())], portions.to_vec())
    }

    #[test]
    fn portions_that_continue_each_other_become_one() {
        let mut label = label(&[portion(0..4, 0..9), portion(8..12, 0..9)]);
        assert_eq!(label.portions().len(), 2);
        label.add(portion(4..8, 3..9));
        assert_eq!(label.portions().len(), 3);
        label.add(portion(4..8, 0..3));
        assert_eq!(label.portions(), [portion(0..12, 0..9)]);
        label.add(portion(12..12, 0..9));
        assert_eq!(label.portions(), [portion(0..12, 0..9)]);
    }

    #[test]
    fn what_is_missing_is_named() {
        assert_eq!(label(&[portion(0..4, 0..9)]).missing(9), []);
        assert_eq!(label(&[]).missing(9), []);
        let label = label(&[portion(2..4, 0..9), portion(8..12, 0..9), portion(12..13, 0..3), portion(12..13, 5..9)]);
        assert_eq!(label.missing(9), [portion(0..2, 0..9), portion(4..8, 0..9), portion(12..13, 3..5)]);
        let mut whole = label.clone();
        label.missing(9).into_iter().for_each(|portion| whole.add(portion));
        assert_eq!(whole.portions(), [portion(0..13, 0..9)]);
    }

    #[test]
    fn overlap_is_refused_and_named() {
        let mut first = label(&[portion(0..4, 0..9), portion(4..8, 0..3)]);
        let before = first.clone();
        let refused = first.merge(&label(&[portion(6..10, 2..9)]));
        assert_eq!(refused, Err(MergeError::Overlap(portion(6..8, 2..3))));
        assert_eq!(first, before, "nothing is taken in");
        first.merge(&label(&[portion(4..8, 3..9)])).expect("the rows that were missing");
        assert_eq!(first.portions(), [portion(0..8, 0..9)]);
    }

    #[test]
    fn other_pictures_are_refused_with_the_reason() {
        let base = label(&[portion(0..4, 0..9)]);
        let other = |change: fn(&mut Label)| {
            let mut other = label(&[portion(4..8, 0..9)]);
            change(&mut other);
            base.clone().merge(&other).map_err(|error| error.to_string())
        };
        assert_eq!(other(|_| ()), Ok(()));
        let refused = |change, part: &str| {
            let message = other(change).expect_err(part);
            assert!(message.contains(part), "{message}");
        };
        refused(|label| label.scene[3] = 0, "different scenes");
        refused(|label| label.settings[0].1 = "1".into(), "differ in seed: `0` and `1`");
        refused(|label| label.settings.push(("noise".into(), "0.1".into())), "differ in noise: `` and `0.1`");
        refused(|label| label.settings.clear(), "differ in seed: `0` and ``");
        refused(|label| label.version = "9.9.9".into(), "raggio 9.9.9");
    }
}
