//! Words and numbers of text formats, read from bytes that need not be UTF-8.

use crate::error::{Fault, Place};

/// Most characters of a file's own words that are repeated in a message.
const MOST_QUOTED_CHARS: usize = 40;

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
        let blank = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
        let mut skipped = 0;
        for byte in blank {
            skipped += 1;
            self.line += usize::from(*byte == b'\n');
        }
        let rest = &rest[skipped..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.position += skipped + length;
        (length > 0).then(|| &rest[..length])
    }

    /// Rest of the current line, without blanks around it.
    pub(crate) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = self.bytes.get(self.position..).unwrap_or_default();
        let length = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
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
