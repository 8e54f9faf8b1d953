//! Lines that the program says. Whoever has stopped reading, such as `head`, has had enough: that is no reason to stop.

use std::fmt::Display;
use std::io::Write;

/// Prints a line on standard output: what was asked for.
pub fn print(line: impl Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Prints a line on standard error: how it goes.
pub fn say(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
