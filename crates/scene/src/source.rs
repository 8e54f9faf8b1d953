//! The text of a scene file, the places of its values, and errors that name them.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use crate::error::SceneError;
use crate::fault::{Fault, Kind, Step};
use crate::names;

/// Most warnings that are shown; more help nobody.
pub(crate) const MOST_WARNINGS: usize = 100;

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

    pub(crate) fn error(&self, fault: &Fault) -> SceneError {
        let span = self.span(fault);
        let message = fault.sentence(self.lines.slice(&span));
        self.lines.error(span.start, message)
    }

    /// Warnings of the faults, each as `file:line:column: sentence`.
    pub(crate) fn warnings(&self, faults: &[Fault]) -> Vec<String> {
        let shown = faults.iter().take(MOST_WARNINGS);
        let mut warnings: Vec<String> = shown.map(|it| self.error(it).to_string()).collect();
        if faults.len() > MOST_WARNINGS {
            let rest = faults.len() - MOST_WARNINGS;
            warnings.push(format!("{}: {rest} more warnings", self.lines.name));
        }
        warnings
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
        SceneError { file: self.name.to_string(), line, column, message }
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
