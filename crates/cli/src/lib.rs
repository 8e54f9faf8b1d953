//! The program `raggio`: scene files in, pictures out. A library, because the Python module brings the program along.

mod args;
mod bench;
mod cluster;
mod error;
mod files;
mod listing;
mod manual;
mod merge;
mod opening;
mod order;
mod output;
mod progress;
mod render;
mod run;
mod sequence;
mod signals;
mod stats;
mod video;
#[cfg(feature = "window")]
mod view;

use std::ffi::OsString;

use clap::Parser;
use raggio_scene::display_name;

use args::{Arguments, Command};
use error::Failure;

/// Runs the program with `arguments`, the first of which is its own name, and returns its exit status.
///
/// It takes the process for its own: it sets the panic hook and the handlers of signals, and may end the process at once.
pub fn main(arguments: Vec<OsString>) -> u8 {
    // A fault that no user can mend is still one sentence, not a backtrace, and a status of the documented ones.
    std::panic::set_hook(Box::new(|info| {
        // Decoders of images may give up on damaged bytes, which is no fault of the program and ends as a warning.
        if raggio_images::guarded() {
            return;
        }
        output::say(format_args!("error: raggio has a fault of its own, please report it: {info}"));
        std::process::exit(3);
    }));
    #[cfg(unix)]
    survive_limits();
    // For tests of what follows: makes one step of writing files fail.
    if let Some(step) = std::env::var("RAGGIO_PRETEND_FILE_FAULT").ok().and_then(|step| step.parse().ok()) {
        raggio_render::pretend_file_fault(step);
    }
    match run(&arguments) {
        Ok(()) => 0,
        Err(error @ Failure::Interrupted(_)) => error.exit_status(),
        Err(error) => {
            output::fail(&error);
            error.exit_status()
        }
    }
}

fn run(arguments: &[OsString]) -> Result<(), Failure> {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(answer) if answer.use_stderr() => refuse(&answer, arguments),
        // Help, or the version.
        Err(answer) => return output::printed(answer.print()),
    };
    match arguments.command {
        Command::Render(arguments) => render::render(&arguments),
        Command::Merge(arguments) => merge::merge(&arguments),
        Command::Demo(arguments) => render::demo(&arguments),
        #[cfg(feature = "window")]
        Command::View(arguments) => view::view(&arguments),
        #[cfg(not(feature = "window"))]
        Command::View { .. } => {
            Err(Failure::Input("this raggio was built without its window: `make install` builds one with it".into()))
        }
        Command::Bench(arguments) => bench::bench(&arguments),
        Command::Devices => listing::devices(),
        Command::Check { scene, assets } => listing::check(&scene, assets.options(None)),
        Command::Schema => listing::schema(),
        Command::Completions { shell } => manual::completions(shell),
        Command::Manual { folder } => manual::pages(&folder),
    }
}

/// Ends the program, for its arguments are wrong.
fn refuse(answer: &clap::Error, arguments: &[OsString]) -> ! {
    let is_plain = |argument: &OsString| !argument.to_string_lossy().chars().any(char::is_control);
    if arguments.iter().all(is_plain) {
        answer.exit();
    }
    // The message quotes them, and terminals would do as control characters say.
    let message = answer.render().to_string();
    message.lines().for_each(|line| output::say(display_name(line.as_ref())));
    std::process::exit(answer.exit_code())
}

/// Makes a file that grows beyond the limit of its size (`ulimit -f`) an error like that of a full disk: the signal would
/// end the program and leave half a file.
#[cfg(unix)]
fn survive_limits() {
    use std::sync::{Arc, atomic::AtomicBool};
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
}
