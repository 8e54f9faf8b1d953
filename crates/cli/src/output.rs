//! Lines that the program says.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write, stderr, stdout};
use std::sync::OnceLock;

use serde_json::json;

use crate::error::Failure;

/// Language of the lines, once a program is to read them.
static LANGUAGE: OnceLock<Language> = OnceLock::new();

/// Language of programs that read what this one says.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// A line of JSON on standard error for all that is said.
    Json,
    /// Lines of Open Job Description on standard output; what is said besides stays on standard error.
    OpenJd,
}

/// Says everything from now on in `language`.
pub fn speak(language: Language) {
    let _ = LANGUAGE.set(language);
}

/// Prints a line on standard output: what was asked for.
///
/// # Errors
/// When not all of it can be written: whoever reads half of a schema should know.
pub fn print(line: impl Display) -> Result<(), Failure> {
    printed(writeln!(stdout(), "{line}"))
}

/// Failure of a standard output to which something was `written`, if it is one: a reader who has stopped reading, such as
/// `head`, has had enough.
pub fn printed(written: io::Result<()>) -> Result<(), Failure> {
    match written.and_then(|()| stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Input(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a line on standard error: how it goes. Whether it can be read is no reason to stop.
pub fn say(line: impl Display) {
    if LANGUAGE.get() != Some(&Language::Json) {
        let _ = writeln!(stderr(), "{line}");
        return;
    }
    let line = line.to_string();
    let (kind, words) = match line.split_once(": ") {
        Some((kind @ ("warning" | "error"), words)) => (kind, words),
        _ => ("message", &*line),
    };
    say_json(&json!({ kind: words }));
}

/// Prints an object of JSON on standard error, as a line.
pub fn say_json(object: &serde_json::Value) {
    let _ = writeln!(stderr(), "{object}");
}

/// Prints a line for the program that runs this one, on standard output and as Open Job Description has it.
pub fn say_openjd(key: &str, value: impl Display) {
    // Its lines end where they end.
    let value = value.to_string().replace(['\n', '\r'], " ");
    let _ = writeln!(stdout(), "openjd_{key}: {value}");
    let _ = stdout().flush();
}

/// Prints the failure that ends the program.
pub fn fail(failure: &Failure) {
    if LANGUAGE.get() == Some(&Language::OpenJd) {
        say_openjd("fail", failure);
    }
    say(format_args!("error: {failure}"));
}
