//! The command `raggio view`: arguments in, a window of the viewer, figures out.

use raggio_viewer::{Options, Report, view as open};
use serde_json::json;

use crate::args::ViewArguments;
use crate::error::{Failure, cannot_write};

/// Opens the window.
pub fn view(arguments: &ViewArguments) -> Result<(), Failure> {
    if let Some(path) = &arguments.stats {
        raggio_render::check_writable(path).map_err(|e| cannot_write(path, &e))?;
    }
    let options = Options {
        scene: arguments.scene.clone(),
        assets: arguments.assets.options(None),
        device: arguments.machine.device,
        open: arguments.machine.options(),
        size: [arguments.size.width, arguments.size.height],
        scale: arguments.scale,
        play: arguments.play.clone(),
        watch_kernels: arguments.watch_kernels.clone(),
        hidden: arguments.hidden,
    };
    let report = open(&options)?;
    if let Some(path) = &arguments.stats {
        let text = format!("{:#}\n", stats(&report));
        raggio_render::write_whole(path, text.as_bytes()).map_err(|e| cannot_write(path, &e))?;
    }
    // A script's user is not there to read them on the screen.
    if arguments.play.is_some() && !report.failures.is_empty() {
        return Err(Failure::Input(report.failures.join("\nerror: ")));
    }
    Ok(())
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
            });
            (pacing.section.clone(), figures)
        })
        .collect();
    json!({ "device": report.device, "sections": sections, "validation_messages": report.validation_messages })
}
