//! The command `raggio view`: arguments in, a window of the viewer, figures out.

use std::path::PathBuf;
use std::time::Instant;

use raggio_viewer::{Options, Report, view as open};
use serde_json::json;

use crate::args::ViewArguments;
use crate::error::{Failure, cannot_write};
use crate::files::{check_apart, output_file};

/// Opens the window.
pub fn view(arguments: &ViewArguments) -> Result<(), Failure> {
    let start = Instant::now();
    let file = arguments.stats.as_deref().map(output_file).transpose()?;
    check_apart(file.as_slice(), &inputs(arguments))?;
    #[cfg(unix)]
    leave_nothing_half_written();
    let device = arguments.machine.device.single();
    let device = device.ok_or_else(|| Failure::Input("--device: a window takes one device".into()))?;
    let options = Options {
        scene: arguments.scene.clone(),
        assets: arguments.assets.options(None),
        device,
        open: arguments.machine.options(),
        size: [arguments.size.width, arguments.size.height],
        scale: arguments.scale,
        play: arguments.play.clone(),
        watch_kernels: arguments.watch_kernels.clone(),
        hidden: arguments.hidden,
        start,
        outputs: file.iter().cloned().collect(),
    };
    let report = open(&options)?;
    if let Some(file) = file {
        let text = format!("{:#}\n", stats(&report));
        file.write(text.as_bytes()).map_err(|e| cannot_write(file.path(), &e))?;
    }
    // A script's user is not there to read them on the screen.
    if arguments.play.is_some() && !report.failures.is_empty() {
        return Err(Failure::Input(report.failures.join("\nerror: ")));
    }
    Ok(())
}

/// Has an interrupt or termination signal remove what is being written, before it ends the program as it always does.
#[cfg(unix)]
fn leave_nothing_half_written() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    // Without a handler they still end the program.
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else { return };
    std::thread::spawn(move || {
        for signal in signals.forever() {
            raggio_render::abandon_files();
            let _ = signal_hook::low_level::emulate_default_handler(signal);
        }
    });
}

fn inputs(arguments: &ViewArguments) -> Vec<PathBuf> {
    std::iter::once(&arguments.scene).chain(&arguments.play).cloned().collect()
}

fn stats(report: &Report) -> serde_json::Value {
    let sections: serde_json::Map<_, _> = report
        .pacing
        .iter()
        .map(|pacing| {
            let figures = json!({
                "frames": pacing.frames,
                "median_ms": pacing.median,
                "percentile_99_ms": pacing.percentile_99,
                "longest_ms": pacing.longest,
                "samples": pacing.samples,
            });
            (pacing.section.clone(), figures)
        })
        .collect();
    json!({
        "device": report.device,
        "denoiser": report.denoiser,
        "first_picture_seconds": report.first_picture_seconds,
        "sections": sections,
        "validation_messages": report.validation_messages,
    })
}
