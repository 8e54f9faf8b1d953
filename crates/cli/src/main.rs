//! The program `raggio`: scene files in, pictures out.

mod args;
mod error;
mod listing;
mod progress;
mod render;
mod stats;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command};

fn main() -> ExitCode {
    // What a user cannot do anything about is still one sentence, not a backtrace.
    std::panic::set_hook(Box::new(|info| {
        eprintln!("error: raggio has a fault of its own, please report it: {info}");
    }));
    let outcome = match Arguments::parse().command {
        Command::Render(arguments) => render::render(&arguments),
        Command::Demo(arguments) => render::demo(&arguments),
        Command::Devices => listing::devices(),
        Command::Check { scene } => listing::check(&scene),
        Command::Schema => listing::schema(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            error.exit_code()
        }
    }
}
