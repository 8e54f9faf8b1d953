//! Where in a JSON text a place is, in the words of its structure.
//!
//! A reader that keeps the path while it reads (`serde_path_to_error`) is compiled anew around each structure, which took
//! longer than all other readers of models together. The path is looked for afterwards instead, where there is an error.

use std::fmt::Write as _;

/// List or object that a place is inside of.
enum Within {
    /// The number of an element.
    List(usize),
    /// The key of a member, as it is written; none before the first one.
    Object(Option<String>),
}

/// Path, as in `materials[3].normalTexture.index`, of the value that ends at `column` (in bytes, from 1 on; 0 is the line's
/// beginning) of `line` (from 1 on), or else of the innermost one that this place is inside of. It is empty for the
/// document itself.
pub(super) fn of(json: &[u8], line: usize, column: usize) -> String {
    let before: usize = json.split_inclusive(|byte| *byte == b'\n').take(line.saturating_sub(1)).map(<[u8]>::len).sum();
    let end = json.len().min(before + column);
    let mut within = Vec::new();
    let mut position = 0;
    while position < end {
        let byte = json[position];
        position += 1;
        match byte {
            b'{' => within.push(Within::Object(None)),
            b'[' => within.push(Within::List(0)),
            b'}' | b']' => drop(within.pop()),
            b',' => {
                if let Some(Within::List(number)) = within.last_mut() {
                    *number += 1;
                }
            }
            b'"' => {
                let length = length_of_string(&json[position..]);
                let text = &json[position..position + length];
                position = json.len().min(position + length + 1);
                // A string is a key if a colon follows. One that the place is inside of is not read yet.
                let is_key = json[position..].iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b':');
                if let (Some(Within::Object(key)), true) = (within.last_mut(), is_key && position <= end) {
                    *key = Some(String::from_utf8_lossy(text).into_owned());
                }
            }
            _ => {}
        }
    }
    within.iter().fold(String::new(), |mut path, within| {
        match within {
            Within::List(number) => drop(write!(path, "[{number}]")),
            Within::Object(Some(key)) if path.is_empty() => path.push_str(key),
            Within::Object(Some(key)) => drop(write!(path, ".{key}")),
            Within::Object(None) => {}
        }
        path
    })
}

/// Bytes of a string up to its closing quotation mark.
fn length_of_string(text: &[u8]) -> usize {
    let mut escaped = false;
    let end = text.iter().position(|byte| {
        let ends = *byte == b'"' && !escaped;
        escaped = *byte == b'\\' && !escaped;
        ends
    });
    end.unwrap_or(text.len())
}
