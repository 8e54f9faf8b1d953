//! Lines of OBJ and MTL files: without comments, with continued lines joined.

use std::borrow::Cow;

use crate::text::first_line;

/// Yields the number (from 1) and the text of each line that is not blank.
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    /// Lines of a text without a byte order mark.
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self { rest: text, number: 0 }
    }

    fn line(&mut self) -> Option<&'a [u8]> {
        let (length, end) = first_line(self.rest);
        let line = &self.rest[..length];
        self.rest = &self.rest[end..];
        self.number += 1;
        (end > 0).then(|| line.trim_ascii())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let first = self.line()?;
            let number = self.number;
            let is_named = takes_name(keyword(first).0);
            let without_comment = |line: &'a [u8]| if is_named { line } else { without_comment(line) };
            let mut last = without_comment(first);
            let mut text = Cow::Borrowed(last);
            while let Some(begun) = last.strip_suffix(b"\\") {
                let kept = text.len() - (last.len() - begun.len());
                text.to_mut().truncate(kept);
                last = self.line().map(without_comment).unwrap_or_default();
                text.to_mut().push(b' ');
                text.to_mut().extend_from_slice(last);
            }
            if !text.is_empty() {
                return Some((number, text));
            }
        }
    }
}

/// Whether what follows the keyword is a name, in which `#` is a character as any other: Blender writes `Color_#1`.
fn takes_name(keyword: &[u8]) -> bool {
    const NAMED: [&[u8]; 12] = [
        b"o", b"g", b"usemtl", b"newmtl", b"mtllib", b"usemap", b"maplib", b"bump", b"disp", b"decal", b"refl", b"norm",
    ];
    let is_map = keyword.get(..4).is_some_and(|start| start.eq_ignore_ascii_case(b"map_"));
    is_map || NAMED.iter().any(|name| keyword.eq_ignore_ascii_case(name))
}

/// The line up to its comment. The `#` of `1.#IND` and its like, by which C libraries mean what is not a number, begins none.
fn without_comment(line: &[u8]) -> &[u8] {
    let mut signs = line.iter().enumerate().filter(|(_, byte)| **byte == b'#').map(|(at, _)| at);
    let length = signs.find(|at| !line[..*at].ends_with(b"1.")).unwrap_or(line.len());
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
