//! The program `raggio`, which is all in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(raggio_cli::main(std::env::args_os().collect()))
}
