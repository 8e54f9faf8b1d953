//! Lines of OBJ and MTL files: without comments, with continued lines joined.

use std::borrow::Cow;

type Split<'a> = std::slice::Split<'a, u8, fn(&u8) -> bool>;

/// Yields the number (from 1) and the text of each line that is not blank.
pub(crate) struct Lines<'a> {
    lines: std::iter::Enumerate<Split<'a>>,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let ends_line: fn(&u8) -> bool = |byte| *byte == b'\n';
        Self { lines: bytes.split(ends_line).enumerate() }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let (index, first) = self.lines.next()?;
            let first = without_comment(first);
            let mut text = Cow::Borrowed(first);
            let mut last = first;
            while let Some(begun) = last.strip_suffix(b"\\") {
                let kept = text.len() - (last.len() - begun.len());
                text.to_mut().truncate(kept);
                last = self.lines.next().map(|(_, line)| without_comment(line)).unwrap_or_default();
                text.to_mut().push(b' ');
                text.to_mut().extend_from_slice(last);
            }
            if !text.is_empty() {
                return Some((index + 1, text));
            }
        }
    }
}

fn without_comment(line: &[u8]) -> &[u8] {
    let length = line.iter().position(|byte| *byte == b'#').unwrap_or(line.len());
    line[..length].trim_ascii()
}

/// The first word of a line, and what follows it.
pub(crate) fn keyword(line: &[u8]) -> (&[u8], &[u8]) {
    let length = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
    (&line[..length], line[length..].trim_ascii())
}

pub(crate) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}
