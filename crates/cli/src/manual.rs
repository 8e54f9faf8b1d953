//! The commands `raggio completions` and `raggio manual`: what `make install` puts beside the program.

use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::args::Arguments;
use crate::error::{Failure, cannot_write};
use crate::output;

/// Prints the completion script of `shell`.
pub fn completions(shell: Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "raggio", &mut script);
    output::print(String::from_utf8_lossy(&script))
}

/// Writes the manual pages into `folder`.
pub fn pages(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), folder))
        .map_err(|e| cannot_write(folder, &e))
}
