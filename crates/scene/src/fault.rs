//! A fault: a problem at a path of the file, before the line that it stands on is known.

use std::fmt::{self, Display};

use crate::hints;
use crate::names;

/// One step from a table or list to what it holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Step {
    Key(String),
    Index(usize),
}

impl From<&str> for Step {
    fn from(key: &str) -> Self {
        Self::Key(key.to_string())
    }
}

impl From<usize> for Step {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

/// List of the steps of a path, as in `steps!["shapes", 3, "sphere"]`.
macro_rules! steps {
    ($($step:expr),*) => { vec![$($crate::fault::Step::from($step)),*] };
}
pub(crate) use steps;

#[derive(Debug)]
pub(crate) struct Fault {
    /// Steps from the top of the file to the problem; kept innermost first while serde unwinds.
    steps_inwards: Vec<Step>,
    pub(crate) kind: Kind,
}

#[derive(Debug)]
pub(crate) enum Kind {
    UnknownKey {
        key: String,
        known: &'static [&'static str],
    },
    MissingKey(&'static str),
    /// A value of another type than `expected`; `found` is absent where the value's own text says it best.
    WrongType {
        expected: String,
        found: Option<&'static str>,
    },
    /// A list of another length than was expected.
    WrongLength {
        expected: usize,
        found: usize,
    },
    /// A value that a rule forbids: "must be ...", and advice that may help.
    WrongValue {
        must: String,
        advice: Option<String>,
    },
    /// A fault of the value, as a whole sentence.
    Value(String),
    /// A fault of the key, as a whole sentence.
    Key(String),
    /// A fault that the review has noted already.
    Noted,
}

impl Fault {
    pub(crate) fn new(kind: Kind) -> Self {
        Self { steps_inwards: Vec::new(), kind }
    }

    /// A fault of the value at `path`, as a whole sentence.
    pub(crate) fn value(path: Vec<Step>, sentence: impl Into<String>) -> Self {
        Self::new(Kind::Value(sentence.into())).below(path)
    }

    /// A fault of the key at `path`, as a whole sentence.
    pub(crate) fn key(path: Vec<Step>, sentence: impl Into<String>) -> Self {
        Self::new(Kind::Key(sentence.into())).below(path)
    }

    /// This fault, seen from the table or list that reaches it by `step`.
    pub(crate) fn inside(mut self, step: Step) -> Self {
        self.steps_inwards.push(step);
        self
    }

    /// Whether the fault is one of the very value whose reading ended with it, and not of one further in.
    pub(crate) fn is_here(&self) -> bool {
        self.steps_inwards.is_empty()
    }

    pub(crate) fn below(mut self, path: Vec<Step>) -> Self {
        self.steps_inwards.extend(path.into_iter().rev());
        self
    }

    /// Path from the top of the file.
    pub(crate) fn path(&self) -> Vec<Step> {
        self.steps_inwards.iter().rev().cloned().collect()
    }

    /// Path of what is at fault, with the key that is unknown or missing.
    pub(crate) fn place(&self) -> Vec<Step> {
        let mut path = self.path();
        match &self.kind {
            Kind::UnknownKey { key, .. } => path.push(Step::Key(key.clone())),
            Kind::MissingKey(key) => path.push(Step::from(*key)),
            _ => {}
        }
        path
    }

    /// Key that an unknown one is taken for.
    pub(crate) fn meant(&self) -> Option<&'static str> {
        match &self.kind {
            Kind::UnknownKey { key, known } => hints::meant(&self.path(), key, known),
            _ => None,
        }
    }

    /// Common part of the faults of one kind: the key and its sentence, without numbers and without names
    /// in quotes or brackets.
    pub(crate) fn likeness(&self) -> String {
        let mut likeness = match self.path().pop() {
            Some(Step::Key(key)) => key + " ",
            _ => String::new(),
        };
        let mut closing = None;
        for character in self.sentence("").chars() {
            match (closing, character) {
                (Some(end), _) => closing = closing.filter(|_| character != end),
                (None, '`' | '"') => closing = Some(character),
                (None, '[') => closing = Some(']'),
                (None, _) if !character.is_ascii_digit() => likeness.push(character),
                (None, _) => {}
            }
        }
        likeness
    }

    /// Sentence for the user; `text` is the value in question as the file writes it.
    pub(crate) fn sentence(&self, text: &str) -> String {
        let path = self.path();
        match &self.kind {
            Kind::UnknownKey { key, known } => unknown_key(&path, key, known),
            Kind::MissingKey(key) => missing_key(&path, key),
            Kind::WrongType { expected, found } => {
                let found = found.map_or_else(|| names::quoted(text), str::to_string);
                format!("{} must be {expected}, not {found}", subject(&path))
            }
            Kind::WrongLength { expected, found } => {
                format!("{} must be a list of {expected} numbers, not of {found}", subject(&path))
            }
            Kind::WrongValue { must, advice } => {
                let advice = advice.as_ref().map_or(String::new(), |it| format!(": {it}"));
                let text = names::quoted(text);
                format!("{} {must}, not {text}{advice}", subject(&path))
            }
            Kind::Value(sentence) | Kind::Key(sentence) => sentence.clone(),
            Kind::Noted => String::new(),
        }
    }
}

fn unknown_key(path: &[Step], key: &str, known: &[&str]) -> String {
    let hint = hints::hint(path, key, known);
    format!("unknown key {} {}: {hint}", names::quoted(key), place(path))
}

fn missing_key(path: &[Step], key: &str) -> String {
    match (path, key) {
        ([], "version") => "`version` is missing: a scene file starts with `version = 1`".to_string(),
        ([], "camera") => "[camera] is missing: a scene needs one, with `position`, `look_at` and \
                           `vertical_fov_degrees`"
            .to_string(),
        _ => format!("`{key}` is missing {}", place(path)),
    }
}

/// Name of the table at `path`, with its preposition.
pub(crate) fn place(path: &[Step]) -> String {
    match path {
        [] => "at the top level of the scene".to_string(),
        [Step::Key(shapes), Step::Index(index)] if shapes == "shapes" => {
            format!("in shape {}", index + 1)
        }
        [Step::Key(shapes), Step::Index(index), Step::Key(key)] if shapes == "shapes" => {
            format!("in {} of shape {}", names::quoted(key), index + 1)
        }
        [Step::Key(groups), Step::Key(name), Step::Index(index)] if groups == "groups" => {
            format!("in shape {} of group {}", index + 1, names::quoted(name))
        }
        [Step::Key(groups), Step::Key(name), Step::Index(index), Step::Key(key)] if groups == "groups" => {
            format!("in {} of shape {} of group {}", names::quoted(key), index + 1, names::quoted(name))
        }
        [Step::Key(lights), Step::Index(index)] if lights == "lights" => format!("in light {}", index + 1),
        [Step::Key(lights), Step::Index(index), Step::Key(key)] if lights == "lights" => {
            format!("in {} of light {}", names::quoted(key), index + 1)
        }
        [table, list, Step::Index(index)] if is_keyframes(table, list) => {
            format!("in keyframe {} of [camera]", index + 1)
        }
        _ => format!("in [{}]", dotted(path)),
    }
}

fn is_keyframes(table: &Step, list: &Step) -> bool {
    [table, list] == [&Step::from("camera"), &Step::from("keyframes")]
}

fn dotted(path: &[Step]) -> String {
    let steps = path.iter().map(|step| match step {
        Step::Key(key) => names::key(key),
        Step::Index(index) => (index + 1).to_string(),
    });
    steps.collect::<Vec<_>>().join(".")
}

/// Name of the value at `path`, as the subject of a sentence.
pub(crate) fn subject(path: &[Step]) -> String {
    match path {
        [] => "the scene".to_string(),
        [Step::Key(key)] => names::quoted(key),
        [Step::Key(shapes), Step::Index(index)] if shapes == "shapes" => {
            format!("shape {}", index + 1)
        }
        [Step::Key(groups), Step::Key(name), Step::Index(index)] if groups == "groups" => {
            format!("shape {} of group {}", index + 1, names::quoted(name))
        }
        [Step::Key(groups), Step::Key(name)] if groups == "groups" => format!("group {}", names::quoted(name)),
        [Step::Key(lights), Step::Index(index)] if lights == "lights" => format!("light {}", index + 1),
        [table, list, Step::Index(index)] if is_keyframes(table, list) => {
            format!("keyframe {} of [camera]", index + 1)
        }
        [head @ .., Step::Key(key)] => format!("{} {}", names::quoted(key), place(head)),
        [head @ .., Step::Index(index)] => {
            format!("component {} of {}", index + 1, subject(head))
        }
    }
}

impl Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.sentence("this"))
    }
}

impl std::error::Error for Fault {}

impl serde::de::Error for Fault {
    /// Fault of the text that `number::Rule` writes, "must ...: advice".
    fn custom<T: Display>(message: T) -> Self {
        let message = message.to_string();
        let (must, advice) = match message.split_once(": ") {
            Some((must, advice)) => (must.to_string(), Some(advice.to_string())),
            None => (message, None),
        };
        Self::new(Kind::WrongValue { must, advice })
    }

    fn unknown_field(key: &str, known: &'static [&'static str]) -> Self {
        let key = key.to_string();
        Self::new(Kind::UnknownKey { key, known })
    }

    fn missing_field(key: &'static str) -> Self {
        Self::new(Kind::MissingKey(key))
    }

    fn unknown_variant(_: &str, known: &'static [&'static str]) -> Self {
        Self::custom(format!("must be {}", names::strings(known)))
    }
}
