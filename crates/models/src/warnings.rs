//! Warnings for the user, few whatever the file.

use std::collections::HashMap;

/// Most warnings of a kind that are told one by one.
const MOST_ALIKE: usize = 4;

/// Warnings in the order in which their kinds came first. Those of a kind differ only in their numbers and in the words of
/// the file that they quote; of many, only the first is told, with the number of the others.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    kinds: Vec<Kind>,
    places: HashMap<String, usize>,
}

#[derive(Debug)]
struct Kind {
    first: Vec<String>,
    count: usize,
}

impl Warnings {
    pub(crate) fn push(&mut self, warning: impl Into<String>) {
        let warning = warning.into();
        let place = *self.places.entry(kind(&warning)).or_insert_with(|| {
            self.kinds.push(Kind { first: Vec::new(), count: 0 });
            self.kinds.len() - 1
        });
        let kind = &mut self.kinds[place];
        kind.count += 1;
        if kind.first.len() < MOST_ALIKE {
            kind.first.push(warning);
        }
    }

    /// One sentence each.
    pub(crate) fn into_sentences(self) -> Vec<String> {
        self.kinds.into_iter().flat_map(Kind::into_sentences).collect()
    }
}

impl Kind {
    fn into_sentences(mut self) -> Vec<String> {
        if self.count > MOST_ALIKE {
            self.first.truncate(1);
            let others = self.count - 1;
            self.first.iter_mut().for_each(|first| *first += &format!(" (and {others} more like this)"));
        }
        self.first
    }
}

impl<S: Into<String>> Extend<S> for Warnings {
    fn extend<T: IntoIterator<Item = S>>(&mut self, warnings: T) {
        warnings.into_iter().for_each(|warning| self.push(warning));
    }
}

/// The warning without its numbers and without what it quotes.
fn kind(warning: &str) -> String {
    let mut quoted = false;
    let told = |c: &char| {
        quoted ^= *c == '`';
        !quoted && !c.is_ascii_digit()
    };
    warning.chars().filter(told).collect()
}
