//! A review of a scene: all that is found wrong with it, and how reading goes on past that.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::ptr::from_ref;

use toml::de::DeValue;

use crate::fault::{Fault, Kind, Step};

/// Most faults that are kept; whoever has as many looks at the first ones.
const MOST_KEPT: usize = 100;

/// All that is found wrong with a scene.
#[derive(Default)]
pub(crate) struct Review {
    faults: RefCell<Vec<Fault>>,
    /// Number of all faults, those that were not kept included.
    count: Cell<usize>,
    /// Number of faults that readings have met, those that were not noted included.
    met: Cell<usize>,
    /// Number of the faults of reading among those kept; the others are of what was read.
    of_reading: Cell<usize>,
    /// Amendments, by the places in memory of the document's values.
    amendments: RefCell<HashMap<*const (), Amendment>>,
}

/// Remedy for a value at fault, so that the next reading finds another fault.
enum Amendment {
    /// The value of an unknown key is left out.
    LeaveOut,
    /// A wrong value is replaced by a stand-in.
    Replace,
    /// A table gets stand-ins for missing keys.
    Complete(Vec<&'static str>),
}

impl Review {
    /// Notes a fault of reading, unless it comes of another one.
    pub(crate) fn note(&self, fault: Fault) {
        self.met.set(self.met.get() + 1);
        if self.is_misspelt(&fault) {
            return;
        }
        self.keep(fault);
        self.of_reading.set(self.faults.borrow().len());
    }

    /// Whether a key is missing because it is misspelt.
    fn is_misspelt(&self, missing: &Fault) -> bool {
        let Kind::MissingKey(key) = missing.kind else { return false };
        let is_meant = |unknown: &Fault| unknown.meant() == Some(key) && unknown.path() == missing.path();
        self.faults.borrow().iter().any(is_meant)
    }

    /// Notes the fault of a part that others follow. Returns a fault in place of it, because serde wants one.
    pub(crate) fn note_part(&self, fault: Fault, path: Vec<Step>) -> Fault {
        self.note(fault.below(path));
        Fault::new(Kind::Noted)
    }

    /// The result, if there is one. A fault is objected to.
    pub(crate) fn accept<T>(&self, result: Result<T, Fault>) -> Option<T> {
        result.map_err(|fault| self.object(fault)).ok()
    }

    /// Notes a fault of what was read, unless it may come of what stands in for a value at fault.
    pub(crate) fn object(&self, fault: Fault) {
        if !self.is_doubtful(&fault.place()) {
            self.keep(fault);
        }
    }

    fn keep(&self, fault: Fault) {
        self.count.set(self.count.get() + 1);
        if !self.is_full() {
            self.faults.borrow_mut().push(fault);
        }
    }

    /// Number of faults that readings have met so far.
    pub(crate) fn met(&self) -> usize {
        self.met.get()
    }

    /// Number of faults so far.
    pub(crate) fn count(&self) -> usize {
        self.count.get()
    }

    /// Whether there are so many faults that looking for more is in vain.
    pub(crate) fn is_full(&self) -> bool {
        self.faults.borrow().len() >= MOST_KEPT
    }

    /// Whether one of the faults of reading fits the condition.
    pub(crate) fn has(&self, mut condition: impl FnMut(&[Step]) -> bool) -> bool {
        self.faults.borrow().iter().take(self.of_reading.get()).any(|fault| condition(&fault.place()))
    }

    /// Whether something was wrong with what a fault at `place` is about: keys of one table are judged together, but for
    /// those of a shape.
    fn is_doubtful(&self, place: &[Step]) -> bool {
        let together = match place {
            [_] | [_, Step::Index(_)] | [_, Step::Index(_), _] => place,
            [head @ .., _] => head,
            [] => place,
        };
        self.has(|other| other.starts_with(together) || together.starts_with(other))
    }

    /// Faults that were kept, in no order.
    pub(crate) fn into_faults(self) -> Vec<Fault> {
        self.faults.into_inner()
    }
}

/// Amendments of the document.
impl Review {
    /// Sees to it that the next reading gets past `value`, whose reading had this fault.
    pub(crate) fn amend(&self, value: &DeValue<'_>, fault: &Fault) {
        // Faults further in have been amended there.
        if !fault.is_here() {
            return;
        }
        let mut amendments = self.amendments.borrow_mut();
        match (&fault.kind, amendments.get_mut(&place(value))) {
            (Kind::UnknownKey { .. }, _) => {}
            (Kind::MissingKey(key), Some(Amendment::Complete(keys))) => keys.push(key),
            (Kind::MissingKey(key), _) => {
                amendments.insert(place(value), Amendment::Complete(vec![key]));
            }
            _ => {
                amendments.insert(place(value), Amendment::Replace);
            }
        }
    }

    /// Has the next reading leave out the value of an unknown key.
    pub(crate) fn leave_out(&self, value: &DeValue<'_>) {
        self.amendments.borrow_mut().insert(place(value), Amendment::LeaveOut);
    }

    pub(crate) fn is_left_out(&self, value: &DeValue<'_>) -> bool {
        matches!(self.amendments.borrow().get(&place(value)), Some(Amendment::LeaveOut))
    }

    pub(crate) fn is_replaced(&self, value: &DeValue<'_>) -> bool {
        matches!(self.amendments.borrow().get(&place(value)), Some(Amendment::Replace))
    }

    /// Keys that the table lacks.
    pub(crate) fn missing_in(&self, table: &DeValue<'_>) -> Vec<&'static str> {
        match self.amendments.borrow().get(&place(table)) {
            Some(Amendment::Complete(keys)) => keys.clone(),
            _ => Vec::new(),
        }
    }
}

fn place(value: &DeValue<'_>) -> *const () {
    from_ref(value).cast()
}
