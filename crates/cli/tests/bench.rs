//! Figures and words of `raggio bench`.

use std::path::Path;

use serde_json::Value;

use crate::common::{assert_refused, raggio, text};

const SCENES: [&str; 5] = ["cornell", "lamp", "nested", "weekend", "rock"];

/// Figures of a short run in `folder`, with what it printed.
fn run(folder: &Path) -> (Value, String) {
    let arguments = ["bench", "--device", "cpu", "--threads", "2", "--seconds", "0.1", "--json", "bench.json"];
    let output = raggio(folder, &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json = std::fs::read(folder.join("bench.json")).expect("the figures are written");
    (serde_json::from_slice(&json).expect("the figures are JSON"), text(&output.stdout))
}

#[test]
fn all_scenes_have_figures_that_fit_together() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (report, printed) = run(folder.path());
    let device = &report["devices"][0];
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} is no number in {report:#}"));
    let scenes = device["scenes"].as_array().expect("a list of scenes");
    let names: Vec<_> = scenes.iter().map(|scene| scene["scene"].as_str().expect("a name")).collect();
    assert_eq!(names, SCENES);
    let mut product = 1.0;
    for scene in scenes {
        let [samples, rays, seconds] = ["samples", "rays", "seconds"].map(|key| number(&scene[key]));
        // A portion of work may end after the limit, and the last may be left out.
        assert!(seconds > 0.02 && seconds < 10.0, "{scene:#}");
        assert!(samples > 0.0 && rays > samples, "each sample has a ray at least, and most more: {scene:#}");
        let rate = number(&scene["samples_per_second"]);
        assert!((rate * seconds / samples - 1.0).abs() < 1e-9, "{scene:#}");
        product *= number(&scene["score"]);
    }
    // The baseline of `cornell` is 0.67 Msamples/s.
    let [rate, score] = ["samples_per_second", "score"].map(|key| number(&scenes[0][key]));
    assert!((score / (rate / 0.67e6 * 100.0) - 1.0).abs() < 1e-9, "{:#}", scenes[0]);
    assert!((number(&device["score"]) / product.powf(0.2) - 1.0).abs() < 1e-9, "a geometric mean: {report:#}");
    assert_eq!(scenes[4]["triangles"], 327_682);
    assert_eq!(scenes[0]["triangles"], 0);

    let device = device["device"].as_str().expect("a name");
    assert!(device.contains("(cpu, 2 threads, "), "{device}");
    assert!(printed.contains(device), "expected `{device}` in:\n{printed}");
    let driver = report["devices"][0]["driver"].as_str().expect("cores and kernels");
    assert!(driver.contains("core") && printed.contains(driver), "{driver}");
    assert!(SCENES.iter().all(|name| printed.lines().any(|line| line.starts_with(name))), "{printed}");
}

#[test]
fn several_devices_are_measured_in_their_order() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["bench", "--device", "cpu,cpu", "--threads", "1", "--seconds", "0.01"];
    let output = raggio(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    assert_eq!(printed.matches("(cpu, 1 thread, ").count(), 2, "{printed}");
    assert_eq!(printed.matches("\nall ").count(), 2, "{printed}");
}

#[test]
fn what_cannot_be_measured_or_written_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bench = |arguments: &[&str]| raggio(folder.path(), &[&["bench"], arguments].concat());
    assert_refused(&bench(&["--device", "toaster"]), "toaster");
    assert_refused(&bench(&["--seconds", "0"]), "give a number greater than 0");
    assert_refused(&bench(&["--json", "nowhere/bench.json"]), "cannot write nowhere/bench.json");
}
