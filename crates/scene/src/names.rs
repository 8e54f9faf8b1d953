//! Names of the file in messages: quoted safely, and the known one nearest to an unknown one.

use std::path::Path;

/// Most characters of a name; longer ones are cut in messages and not compared, which would take long.
const LONGEST: usize = 60;

/// Least likeness of two names, from 0 to 1, for one to be suggested in place of the other.
const ALIKE: f64 = 0.6;

/// Name of a file in messages: control characters are escaped, because messages go to terminals.
pub fn display_name(path: &Path) -> String {
    escaped(&path.display().to_string())
}

/// The text in backquotes, with control characters escaped (a message goes to terminals) and long text cut.
pub(crate) fn quoted(text: &str) -> String {
    format!("`{}`", printable(text))
}

/// The text with control characters escaped, cut if it is long.
pub(crate) fn printable(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => escaped(&text[..end]) + "...",
        None => escaped(text),
    }
}

/// The text with control characters escaped.
pub(crate) fn escaped(text: &str) -> String {
    let mut shown = String::new();
    for character in text.chars() {
        if character.is_control() || is_invisible(character) {
            shown.extend(character.escape_unicode());
        } else {
            shown.push(character);
        }
    }
    shown
}

/// Whether the character reorders or hides the text around it.
fn is_invisible(character: char) -> bool {
    matches!(character, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// The key as TOML writes it: bare where that is allowed, else in quotes.
pub(crate) fn key(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !name.is_empty() && name.chars().all(is_bare) { printable(name) } else { format!("\"{}\"", printable(name)) }
}

/// The known name most like `name`, if any is like it at all.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > LONGEST {
        return None;
    }
    known
        .into_iter()
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| (likeness(name, candidate), candidate))
        .filter(|(likeness, _)| *likeness >= ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// Likeness of two names: 1 for equal ones, 0 for those without a letter in common; a part of a name counts as like it.
fn likeness(a: &str, b: &str) -> f64 {
    let (a, b) = (a.to_lowercase(), b.to_lowercase());
    let is_part = a.len().min(b.len()) >= 3 && (a.contains(&b) || b.contains(&a));
    let floor = if is_part { 0.7 } else { 0.0 };
    strsim::normalized_damerau_levenshtein(&a, &b).max(floor)
}

/// List of names such as "`a`, `b` and `c`", at most nine of them.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>, conjunction: &str) -> String {
    const SHOWN: usize = 9;
    let names: Vec<&str> = names.into_iter().collect();
    let mut shown: Vec<String> = names.iter().take(SHOWN).map(|name| quoted(name)).collect();
    if names.len() > SHOWN {
        shown.push(format!("{} more", names.len() - SHOWN));
    }
    match shown.as_slice() {
        [] => String::new(),
        [only] => only.clone(),
        [head @ .., last] => format!("{} {conjunction} {last}", head.join(", ")),
    }
}

/// List of the strings that a key may have, as the file writes them.
pub(crate) fn strings(values: &[&str]) -> String {
    let strings: Vec<String> = values.iter().map(|value| format!("\"{value}\"")).collect();
    list(strings.iter().map(String::as_str), "or")
}

/// Hint that follows "unknown NAME": the nearest known name, or all of them.
pub(crate) fn hint(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(candidate) => format!("did you mean {}?", quoted(candidate)),
        None => format!("choose from {}", list(known.iter().copied(), "and")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_forgives_typing_and_abbreviation() {
        let keys = ["position", "look_at", "up", "vertical_fov_degrees"];
        assert_eq!(nearest("postion", keys), Some("position"));
        assert_eq!(nearest("lookAt", keys), Some("look_at"));
        assert_eq!(nearest("fov", keys), Some("vertical_fov_degrees"));
        assert_eq!(nearest("banana", keys), None);
        assert_eq!(nearest(&"u".repeat(1 << 20), keys), None);
    }

    #[test]
    fn quoted_escapes_and_cuts() {
        assert_eq!(quoted("a\u{1b}[2J"), "`a\\u{1b}[2J`");
        assert_eq!(quoted(&"x".repeat(99)), format!("`{}...`", "x".repeat(LONGEST)));
        assert_eq!(key("two words"), "\"two words\"");
    }
}
