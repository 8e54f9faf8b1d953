//! Errors with their place in the document, warnings, and how much memory a file may ask for.

use std::cell::{Cell, RefCell};
use std::collections::HashSet;
use std::fmt::Display;

use crate::error::Fault;
use crate::text::escaped;

/// Most warnings that are kept; further ones are only counted.
const MOST_WARNINGS: usize = 100;

/// A fault at `path`, as in `materials[3].normalTexture.index`; `message` says what is wrong and would be right.
pub(super) fn at(path: impl Display, message: impl Display) -> Fault {
    Fault::whole(escaped(&format!("{path}: {message}")))
}

/// Sentences for the user, each once.
#[derive(Default)]
pub(super) struct Warnings {
    told: RefCell<(Vec<String>, HashSet<String>)>,
    untold: Cell<usize>,
}

impl Warnings {
    pub(super) fn push(&self, message: impl Display) {
        self.tell(escaped(&message.to_string()));
    }

    fn tell(&self, message: String) {
        let (list, known) = &mut *self.told.borrow_mut();
        if known.contains(&message) {
        } else if list.len() == MOST_WARNINGS {
            self.untold.set(self.untold.get() + 1);
        } else {
            known.insert(message.clone());
            list.push(message);
        }
    }

    /// Warnings so far.
    pub(super) fn told(&self) -> Vec<String> {
        self.told.borrow().0.clone()
    }

    /// Tells warnings once more, which have been [told](Self::told) before.
    pub(super) fn repeat(&self, told: &[String]) {
        told.iter().for_each(|message| self.tell(message.clone()));
    }

    /// Does `work`, and returns its warnings apart from all others.
    pub(super) fn apart<T>(&self, work: impl FnOnce() -> T) -> (T, Vec<String>) {
        let before = self.told.take();
        let done = work();
        let (warnings, _) = self.told.replace(before);
        (done, warnings)
    }

    /// All warnings, in the order of their first mention.
    pub(super) fn finish(self) -> Vec<String> {
        let (mut list, _) = self.told.into_inner();
        let untold = self.untold.get();
        if untold > 0 {
            list.push(format!("{untold} more warnings are not shown"));
        }
        list
    }
}

/// Bytes that may still be allocated for what a file asks for.
///
/// A few bytes of a document can ask for any amount: by accessors without data, by meshes that share one buffer, by
/// compression. So the sum of everything that is made of a file is bounded by a multiple of its size.
#[derive(Clone)]
pub(super) struct Budget {
    left: Cell<u64>,
}

impl Budget {
    /// Bytes that every file may ask for, however small it is.
    const BASE: u64 = 256 << 20;
    /// Bytes that a file may ask for in addition, for each of its own.
    const FACTOR: u64 = 256;

    /// Budget of a file that has `file_bytes` with its buffers, at most `most_bytes`.
    pub(super) fn new(file_bytes: u64, most_bytes: u64) -> Self {
        let proportional = file_bytes.saturating_mul(Self::FACTOR).saturating_add(Self::BASE);
        Self { left: Cell::new(proportional.min(most_bytes)) }
    }

    pub(super) fn left(&self) -> u64 {
        self.left.get()
    }

    /// Takes `count` elements of `size` bytes, or says why they are too many.
    pub(super) fn take(&self, count: usize, size: usize, path: impl Display) -> Result<(), Fault> {
        let bytes = (count as u64).saturating_mul(size as u64);
        let left = self.left.get();
        let too_much = || at(path, format!("asks for {bytes} bytes of memory: at most {left} are left for this file"));
        self.left.set(left.checked_sub(bytes).ok_or_else(too_much)?);
        Ok(())
    }
}
