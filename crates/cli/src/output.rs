//! Lines that the program says.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write, stderr, stdout};

use crate::error::Failure;

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
    let _ = writeln!(stderr(), "{line}");
}
