//! History of a document: the texts to go back to.

/// Most steps that are kept; older ones are forgotten.
const MOST_STEPS: usize = 1000;

/// Name of an edit, and the text on the other side of it.
#[derive(Debug)]
struct Step {
    name: String,
    text: String,
}

#[derive(Debug, Default)]
pub(super) struct History {
    undo: Vec<Step>,
    redo: Vec<Step>,
    gesture: Option<String>,
    /// Whether the last step was made by the present gesture.
    is_continued: bool,
}

impl History {
    pub(super) fn begin_gesture(&mut self, key: &str) {
        if self.gesture.as_deref() != Some(key) {
            self.gesture = Some(key.to_string());
            self.is_continued = false;
        }
    }

    pub(super) fn end_gesture(&mut self) {
        self.gesture = None;
        self.is_continued = false;
    }

    /// Notes that `before` became `after`.
    pub(super) fn record(&mut self, name: &str, before: String, after: &str) {
        self.redo.clear();
        if !self.is_continued {
            self.undo.push(Step { name: name.to_string(), text: before });
            self.is_continued = self.gesture.is_some();
        } else if self.undo.last().is_some_and(|step| step.text == after) {
            // A gesture that came back to where it began did nothing.
            self.undo.pop();
            self.is_continued = false;
        }
        if self.undo.len() > MOST_STEPS {
            self.undo.remove(0);
        }
    }

    pub(super) fn can_undo(&self) -> Option<&str> {
        self.undo.last().map(|step| step.name.as_str())
    }

    pub(super) fn can_redo(&self) -> Option<&str> {
        self.redo.last().map(|step| step.name.as_str())
    }

    /// Goes back one step and returns its name, and the text before it.
    pub(super) fn undo(&mut self, text: &str) -> Option<(String, String)> {
        self.end_gesture();
        exchange(&mut self.undo, &mut self.redo, text)
    }

    /// Goes forward one step and returns its name, and the text after it.
    pub(super) fn redo(&mut self, text: &str) -> Option<(String, String)> {
        self.end_gesture();
        exchange(&mut self.redo, &mut self.undo, text)
    }
}

/// Takes the last step off one pile and puts it on the other, with the text as it is now.
fn exchange(from: &mut Vec<Step>, to: &mut Vec<Step>, text: &str) -> Option<(String, String)> {
    let step = from.pop()?;
    to.push(Step { name: step.name.clone(), text: text.to_string() });
    Some((step.name, step.text))
}
