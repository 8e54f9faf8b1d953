//! The program `raggio`: scene files in, pictures out.

mod args;
mod error;
mod listing;
mod manual;
mod output;
mod progress;
mod render;
mod stats;
#[cfg(feature = "window")]
mod view;

use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Command};

fn main() -> ExitCode {
    // A fault that no user can mend is still one sentence, not a backtrace, and a status of the documented ones.
    std::panic::set_hook(Box::new(|info| {
        // Decoders of images may give up on damaged bytes, which is no fault of the program and ends as a warning.
        if raggio_images::guarded() {
            return;
        }
        output::say(format_args!("error: raggio has a fault of its own, please report it: {info}"));
        std::process::exit(3);
    }));
    let outcome = match Arguments::parse().command {
        Command::Render(arguments) => render::render(&arguments),
        Command::Demo(arguments) => render::demo(&arguments),
        #[cfg(feature = "window")]
        Command::View(arguments) => view::view(&arguments),
        #[cfg(not(feature = "window"))]
        Command::View { .. } => Err(error::Failure::Input(
            "this raggio was built without its window: `make install` builds one with it".into(),
        )),
        Command::Devices => listing::devices(),
        Command::Check { scene, assets } => listing::check(&scene, assets.options(None)),
        Command::Schema => listing::schema(),
        Command::Completions { shell } => manual::completions(shell),
        Command::Manual { folder } => manual::pages(&folder),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error @ error::Failure::Interrupted) => error.exit_code(),
        Err(error) => {
            output::say(format_args!("error: {error}"));
            error.exit_code()
        }
    }
}
