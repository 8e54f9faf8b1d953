//! Words and numbers of text formats, read from bytes that need not be UTF-8.

use std::borrow::Cow;

use crate::error::{Fault, Place};

/// Most characters of a file's own words that are repeated in a message.
const MOST_QUOTED_CHARS: usize = 40;

/// The text without its byte order mark; UTF-16, which always has one where it is saved as a text, becomes UTF-8.
pub(crate) fn unmarked(bytes: &[u8]) -> Cow<'_, [u8]> {
    let utf8 = |unit: fn([u8; 2]) -> u16| {
        let units = bytes[2..].as_chunks::<2>().0.iter().map(|pair| unit(*pair));
        let characters = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        Cow::Owned(characters.collect::<String>().into_bytes())
    };
    match bytes {
        [0xef, 0xbb, 0xbf, text @ ..] => Cow::Borrowed(text),
        [0xff, 0xfe, ..] => utf8(u16::from_le_bytes),
        [0xfe, 0xff, ..] => utf8(u16::from_be_bytes),
        _ => Cow::Borrowed(bytes),
    }
}

/// Length of the first line of a text, and of the text up to the next line: lines end with a line feed, a carriage
/// return or both.
pub(crate) fn first_line(text: &[u8]) -> (usize, usize) {
    let length = text.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(text.len());
    let ending = match text[length..] {
        [] => 0,
        [b'\r', b'\n', ..] => 2,
        _ => 1,
    };
    (length, length + ending)
}

/// The words of a text, one after the other, and the line each stands on.
pub(crate) struct Words<'a> {
    bytes: &'a [u8],
    position: usize,
    line: usize,
}

impl<'a> Words<'a> {
    /// Words from `position` on, which stands on the line of number `line`.
    pub(crate) fn new(bytes: &'a [u8], position: usize, line: usize) -> Self {
        Self { bytes, position, line }
    }

    /// The next word, or `None` at the end.
    pub(crate) fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.position..)?;
        let skipped = rest.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(rest.len());
        let (blank, rest) = rest.split_at(skipped);
        let ends_line = |i: usize| match blank[i] {
            b'\n' => true,
            byte => byte == b'\r' && blank.get(i + 1) != Some(&b'\n'),
        };
        self.line += (0..skipped).filter(|i| ends_line(*i)).count();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.position += skipped + length;
        (length > 0).then(|| &rest[..length])
    }

    /// Rest of the current line, without blanks around it.
    pub(crate) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = self.bytes.get(self.position..).unwrap_or_default();
        let (length, _) = first_line(rest);
        self.position += length;
        rest[..length].trim_ascii()
    }

    /// The next word, which has to be a number.
    pub(crate) fn number(&mut self) -> Result<f64, Fault> {
        let word = self.next().ok_or_else(|| self.fault("the file ends where a number should be"))?;
        number(word).ok_or_else(|| self.fault(format!("{} should be a number", quoted(word))))
    }

    pub(crate) fn bytes_left(&self) -> usize {
        self.bytes.len().saturating_sub(self.position)
    }

    pub(crate) fn place(&self) -> Place {
        Place::Line(self.line)
    }

    pub(crate) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::new(self.place(), message)
    }
}

/// A number; the ways in which C libraries print "not a number" are one too.
pub(crate) fn number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| {
        let text = text.trim_start_matches(['-', '+']).to_ascii_lowercase();
        (text.starts_with("nan(") || text.starts_with("1.#")).then_some(f64::NAN)
    })
}

/// Number and noun, in the plural where there is not just one: `1 face`, `2 faces`.
pub(crate) fn counted(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// A word of a file as messages repeat it: short, and without control characters, because messages go to terminals.
pub(crate) fn quoted(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(4 * MOST_QUOTED_CHARS)]);
    let mut shown: String = text.chars().take(MOST_QUOTED_CHARS).collect();
    if shown.len() < word.len() && text.chars().count() > MOST_QUOTED_CHARS {
        shown.push('…');
    }
    format!("`{}`", escaped(&shown))
}

/// The text with control characters escaped.
pub(crate) fn escaped(text: &str) -> String {
    let escape = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(escape).collect()
}
