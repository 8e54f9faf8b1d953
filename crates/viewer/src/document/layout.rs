//! Parts of a text that `toml_edit` does not keep: the byte order mark, the kind of line breaks, the end of the last
//! line.

use toml_edit::DocumentMut;

use super::EditError;

pub(super) struct Layout {
    has_mark: bool,
    has_carriage_returns: bool,
    ends_in_newline: bool,
}

impl Layout {
    pub(super) fn of(text: &str) -> Self {
        Self {
            has_mark: text.starts_with('\u{feff}'),
            has_carriage_returns: text.contains("\r\n"),
            ends_in_newline: text.ends_with('\n'),
        }
    }

    pub(super) fn read(&self, text: &str) -> Result<DocumentMut, EditError> {
        let text = text.trim_start_matches('\u{feff}').replace("\r\n", "\n");
        text.parse()
            .map_err(|error: toml_edit::TomlError| EditError::Path(format!("not valid TOML: {}", error.message())))
    }

    pub(super) fn write(&self, mut text: String) -> String {
        if !self.ends_in_newline && text.ends_with('\n') {
            text.pop();
        }
        if self.has_carriage_returns {
            text = text.replace('\n', "\r\n");
        }
        if self.has_mark {
            text.insert(0, '\u{feff}');
        }
        text
    }
}
