//! The text of a scene file, the places of its values, and errors that name them.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use toml::de::{DeTable, DeValue};

use crate::counts::counted;
use crate::error::SceneError;
use crate::fault::{Fault, Kind, Step};
use crate::names;

/// Most warnings that are shown; more help nobody.
const MOST_WARNINGS: usize = 100;

/// Most warnings of one kind that are shown each; of more, the first is shown with their number.
const MOST_ALIKE: usize = 3;

/// Most errors that are shown at once.
const MOST_ERRORS: usize = 20;

/// A TOML document that keeps its text.
pub(crate) struct Document<'a> {
    lines: Lines<'a>,
    root: DeValue<'a>,
}

impl<'a> Document<'a> {
    /// A document, or an error when `text` is not TOML; `name` stands for the file in messages.
    pub(crate) fn parse(text: &'a str, name: &'a str) -> Result<Self, SceneError> {
        let lines = Lines::new(text, name);
        match DeTable::parse(text) {
            Ok(table) => Ok(Self { lines, root: DeValue::Table(table.into_inner()) }),
            Err(error) => Err(lines.syntax_error(&error)),
        }
    }

    pub(crate) fn root(&self) -> &DeValue<'a> {
        &self.root
    }

    fn error(&self, fault: &Fault) -> SceneError {
        let span = self.span(fault);
        let message = fault.sentence(self.lines.slice(&span));
        self.lines.error(span.start, message)
    }

    /// One error for all of the faults, in the order of the file. `unseen` is the number of faults beyond these, and `None`
    /// where nobody has counted them.
    pub(crate) fn errors(&self, faults: &[Fault], unseen: Option<usize>) -> SceneError {
        let mut errors: Vec<SceneError> = faults.iter().map(|fault| self.error(fault)).collect();
        errors.sort_by_key(|error| (error.line, error.column));
        errors.truncate(MOST_ERRORS);
        let hidden = faults.len() - errors.len();
        let rest = match unseen {
            Some(unseen) if unseen + hidden == 0 => None,
            Some(unseen) => Some(format!("and {} more", unseen + hidden)),
            None if hidden == 0 => Some("and perhaps more".to_string()),
            None => Some(format!("and at least {hidden} more")),
        };
        errors.extend(rest.map(|rest| SceneError::whole_file(self.lines.name, rest)));
        let mut errors = errors.into_iter();
        let first = errors.next().unwrap_or_else(|| SceneError::whole_file(self.lines.name, "is no scene"));
        SceneError { others: errors.collect(), ..first }
    }

    /// Warnings of the faults, each as `file:line:column: sentence`.
    pub(crate) fn warnings(&self, faults: &[Fault]) -> Vec<String> {
        summed_up(faults, self.lines.name, |fault| self.error(fault).to_string())
    }

    /// Span of the value or key in question; where that is not in the file (it has a default, or is missing), that of
    /// the nearest table around it.
    fn span(&self, fault: &Fault) -> Range<usize> {
        let mut path = fault.path();
        if let Kind::UnknownKey { key, .. } = &fault.kind {
            path.push(Step::Key(key.clone()));
        }
        let about_key = matches!(fault.kind, Kind::UnknownKey { .. } | Kind::Key(_));

        let mut found = (&self.root, 0..0);
        for (index, step) in path.iter().enumerate() {
            let about_this_key = about_key && index + 1 == path.len();
            match child(found.0, step, about_this_key) {
                Some(child) => found = child,
                None => break,
            }
        }
        found.1
    }
}

/// Warnings of the faults as `words` puts each. Of many alike the first stands for all.
pub(crate) fn summed_up(faults: &[Fault], name: &str, words: impl Fn(&Fault) -> String) -> Vec<String> {
    let kinds: Vec<String> = faults.iter().map(Fault::likeness).collect();
    let mut numbers: HashMap<&str, usize> = HashMap::new();
    kinds.iter().for_each(|kind| *numbers.entry(kind).or_default() += 1);
    let mut warnings = Vec::new();
    let mut summed = HashSet::new();
    for (fault, kind) in faults.iter().zip(&kinds) {
        match numbers[kind.as_str()] {
            number if number <= MOST_ALIKE => warnings.push(words(fault)),
            number if summed.insert(kind) => {
                warnings.push(format!("{} (and {} more like this)", words(fault), number - 1));
            }
            _ => {}
        }
    }
    if warnings.len() > MOST_WARNINGS {
        let rest = warnings.split_off(MOST_WARNINGS).len();
        warnings.push(format!("{name}: {}", counted(rest, "more warning")));
    }
    warnings
}

/// The value that `step` leads to, and its span or that of its key.
fn child<'d, 'a>(value: &'d DeValue<'a>, step: &Step, about_key: bool) -> Option<(&'d DeValue<'a>, Range<usize>)> {
    match (value, step) {
        (DeValue::Table(table), Step::Key(key)) => {
            let (key, value) = table.get_key_value(key.as_str())?;
            let span = if about_key { key.span() } else { value.span() };
            Some((value.get_ref(), span))
        }
        (DeValue::Array(array), Step::Index(index)) => {
            let value = array.get(*index)?;
            Some((value.get_ref(), value.span()))
        }
        _ => None,
    }
}

/// Translates byte offsets of a text into lines and columns.
pub(crate) struct Lines<'a> {
    name: &'a str,
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(text: &'a str, name: &'a str) -> Self {
        let after_breaks = text.match_indices('\n').map(|(offset, _)| offset + 1);
        let starts = std::iter::once(0).chain(after_breaks).collect();
        Self { name, text, starts }
    }

    fn slice(&self, span: &Range<usize>) -> &'a str {
        self.text.get(span.clone()).unwrap_or_default()
    }

    pub(crate) fn error(&self, offset: usize, message: String) -> SceneError {
        let line = self.starts.partition_point(|start| *start <= offset);
        let start = self.starts[line - 1];
        let before = self.text.get(start..offset).unwrap_or_default();
        let column = before.trim_start_matches('\u{feff}').chars().count() + 1;
        SceneError { line, column, ..SceneError::whole_file(self.name, message) }
    }

    fn syntax_error(&self, error: &toml::de::Error) -> SceneError {
        let span = error.span().unwrap_or_default();
        let message = syntax_message(error.message(), self.slice(&span).trim());
        self.error(span.start, message)
    }
}

/// Message of a syntax error, the parser's but for the commonest mistakes; `text` is where the parser stumbled.
fn syntax_message(message: &str, text: &str) -> String {
    let quoted = names::quoted(text);
    if message == "duplicate key" {
        format!("{quoted} is given twice")
    } else if !message.starts_with("string values must be quoted") {
        let message = message.trim_end_matches(", expected nothing");
        format!("not valid TOML: {}", names::escaped(message))
    } else if text.is_empty() {
        "not valid TOML: a value is missing after `=`".to_string()
    } else {
        format!("not valid TOML: {quoted} is no value (a string stands in quotes)")
    }
}

/// An error at the end of `text`, for faults found before the text is parsed.
pub(crate) fn error_after(text: &str, name: &str, message: String) -> SceneError {
    Lines::new(text, name).error(text.len(), message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::steps;

    /// Warnings that differ in more than names and numbers.
    fn unlike(count: u32) -> Vec<Fault> {
        let letter = |place: u32| char::from_u32('a' as u32 + place % 26).unwrap();
        let words = (0..count).map(|i| format!("{}{} is odd", letter(i / 26), letter(i)));
        words.map(|words| Fault::value(steps!["camera"], words)).collect()
    }

    #[test]
    fn warnings_end() {
        let words = |fault: &Fault| fault.sentence("");
        assert_eq!(summed_up(&unlike(100), "it", words).len(), 100);
        assert_eq!(summed_up(&unlike(101), "it", words)[100], "it: 1 more warning");
        assert_eq!(summed_up(&unlike(103), "it", words)[100], "it: 3 more warnings");
    }

    #[test]
    fn columns_count_characters() {
        let lines = Lines::new("\u{feff}a\r\nßb", "it");
        let place_of = |offset| {
            let error = lines.error(offset, "wrong".to_string());
            (error.line, error.column)
        };
        assert_eq!(place_of(0), (1, 1));
        assert_eq!(place_of(3), (1, 1));
        assert_eq!(place_of(6), (2, 1));
        assert_eq!(place_of(8), (2, 2));
        assert_eq!(place_of(9), (2, 3));
    }
}
