//! Devices that fail in the middle of a render, at each of their calls.

use std::ops::ControlFlow;
use std::path::Path;

use raggio_render::{
    Aov, CpuDevice, CpuOptions, Device, DeviceChoice, DeviceGroup, Observer, OpenOptions, Progress, RenderError,
    RenderRequest, Rendered, Rendering, open,
};
use raggio_scene::{AssetOptions, Assets, Scene};
use raggio_vulkan::Fault;

use crate::checkpoints::{Ear, TEXT, request, same, scene};

/// A Vulkan device, if there is one.
fn vulkan() -> Option<Box<dyn Device>> {
    let found = open(DeviceChoice::Vulkan(None), OpenOptions::default(), |_| ());
    let required = std::env::var("RAGGIO_TEST_EVERYTHING").is_ok_and(|value| value == "1");
    match found {
        Ok(device) => Some(device),
        Err(error) if required => panic!("RAGGIO_TEST_EVERYTHING=1, and {error}"),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

/// Whatever call fails, and however: what a checkpoint has is not lost, and the picture that comes of it is right.
#[test]
fn whichever_call_fails_the_film_is_saved() {
    let Some(device) = vulkan() else { return };
    let context = device.vulkan().expect("it is one");
    let mut scene = scene();
    (scene.render.width, scene.render.height, scene.render.samples) = (12, 10, 3);
    let render = |request: RenderRequest| -> Result<Rendered, RenderError> {
        Ok(Rendering::begin(&scene, &*device, request)?.run(&mut Ear::default())?)
    };
    // Mesa's in software takes half a minute to compile the kernel of other layers.
    let is_long = std::env::var("RAGGIO_TEST_LONG").is_ok_and(|value| value == "1");
    let layers = if is_long { vec![Aov::Albedo, Aov::Depth] } else { vec![Aov::Samples, Aov::Variance] };
    let with_layers = |request: RenderRequest| RenderRequest { layers: layers.clone(), ..request };
    let whole = render(with_layers(RenderRequest { label: true, ..RenderRequest::default() }))
        .expect("the device renders")
        .picture;
    for fault in [Fault::OutOfMemory, Fault::NoMemory, Fault::Lost, Fault::Gone] {
        let (mut overcome, mut saved) = (0, 0);
        // Opening a device that is gone is tried again after a while, and one that was lost compiles its kernels anew.
        let step = if is_long || [Fault::OutOfMemory, Fault::NoMemory].contains(&fault) { 1 } else { 13 };
        for call in (1..).step_by(step) {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("a.checkpoint");
            context.pretend_fault(call, fault);
            let outcome = render(with_layers(request(&path)));
            let is_over = context.fault_is_due();
            context.pretend_fault(0, fault);
            let said = |error: String| {
                let is_lost = [Fault::Lost, Fault::Gone].contains(&fault);
                let words = ["out of memory on the device", "the device was lost"][usize::from(is_lost)];
                assert!(error.contains(words), "call {call}: {error}");
            };
            match &outcome {
                Ok(Rendered { failure: None, picture, finished, .. }) => {
                    // Without memory for the last wait, all has been done nevertheless.
                    assert!(is_over || fault != Fault::Gone, "call {call} was lost and nobody has noticed");
                    assert!(*finished && same(picture, &whole), "call {call}: another picture");
                    overcome += 1;
                }
                Ok(Rendered { failure: Some(error), checkpoint, picture, .. }) => {
                    said(error.to_string());
                    assert_eq!(checkpoint.as_deref(), Some(&*path), "call {call}");
                    assert!(picture.film.samples() > 0);
                    saved += 1;
                }
                Err(error) => {
                    said(error.to_string());
                    assert!(!path.exists(), "call {call}: the checkpoint has a film, and there is no picture");
                }
            }
            drop(outcome);
            // Whatever it was, the same request makes the picture, from the checkpoint where there is one.
            let again = render(with_layers(request(&path))).expect("the device renders");
            assert!(again.failure.is_none() && same(&again.picture, &whole), "call {call}: another picture");
            if is_over {
                assert!(call > 100, "only {call} calls");
                break;
            }
        }
        // One call too many is made again, and a device that was lost is opened again; what lasts ends the render, and what
        // there was is saved.
        let is_once = [Fault::OutOfMemory, Fault::Lost].contains(&fault);
        let enough = 12 / step;
        let is_right = if is_once { overcome > enough && saved == 0 } else { overcome < 4 && saved > enough };
        assert!(is_right, "{fault:?}: {saved} saved, {overcome} overcome");
    }
    assert_eq!(device.validation_messages(), Vec::<String>::new());
}

/// A device that is lost after each of the portions that `is_lost` says, by their number and what there is by then.
struct Losing<F> {
    context: std::sync::Arc<raggio_vulkan::Device>,
    portion: usize,
    is_lost: F,
    ear: Ear,
}

impl<F: FnMut(usize, &Progress) -> bool> Observer for Losing<F> {
    fn warn(&mut self, warning: &str) {
        self.ear.warn(warning);
    }

    fn saved(&mut self, path: &Path) {
        self.ear.saved(path);
    }

    fn progress(&mut self, progress: &Progress) -> ControlFlow<()> {
        if (self.is_lost)(self.portion, progress) {
            self.context.pretend_lost();
        }
        self.portion += 1;
        ControlFlow::Continue(())
    }
}

/// A device that is lost now and then is opened again each time; one that comes to nothing any more ends the render with what
/// there is, and where there is nothing, with the error.
#[test]
fn a_lost_device_is_opened_again_so_often() {
    let Some(device) = vulkan() else { return };
    let context = device.vulkan().expect("it is one");
    let folder = tempfile::tempdir().expect("a folder");
    // Its hierarchy has to be there once more, too.
    let corners = "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\nv 0 0 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    std::fs::write(folder.path().join("pyramid.obj"), corners).expect("a file");
    let shapes = format!("{}[[shapes]]\nmaterial = \"a\"\nmesh = {{ file = \"pyramid.obj\" }}\n", TEXT);
    let mut assets = Assets::new(AssetOptions::default());
    let parsed = Scene::parse_with(&shapes, &folder.path().join("scene.toml"), &mut assets);
    let mut scene = parsed.expect("the scene is right");
    (scene.render.width, scene.render.height, scene.render.samples) = (12, 10, 5);
    let path = folder.path().join("a.checkpoint");
    let run = |device: &dyn Device, request: RenderRequest, is_lost: &mut dyn FnMut(usize, &Progress) -> bool| {
        let mut losing = Losing { context: context.clone(), portion: 0, is_lost, ear: Ear::default() };
        let rendering = Rendering::begin(&scene, device, request).expect("the scene loads");
        (rendering.run(&mut losing), losing.ear.warnings)
    };
    let (whole, _) = run(&*device, RenderRequest { label: true, ..RenderRequest::default() }, &mut |_, _| false);
    let whole = whole.expect("the device renders").picture;

    // Films that are gathered in between make it go on: it is lost once with each sample, which comes before its film is gathered.
    let mut seen = 0;
    let mut with_each = |_: usize, progress: &Progress| {
        let is_new = progress.samples > seen;
        seen = seen.max(progress.samples);
        is_new
    };
    let (rendered, warnings) = run(&*device, request(&path), &mut with_each);
    let rendered = rendered.expect("the device renders");
    assert!(rendered.failure.is_none() && same(&rendered.picture, &whole));
    rendered.remove_checkpoints().expect("files can be removed");
    drop(rendered);
    assert!(warnings.len() > 3, "more often than in a row: {warnings:?}");
    for warning in &warnings {
        let words = "the device was lost: the driver reset it, or it went away: it was opened again, and the render goes on from ";
        assert!(warning.starts_with(words) && warning.contains("sample"), "{warning}");
    }

    // Without anything gathered it begins anew, a few times.
    let nothing = RenderRequest::default();
    let (lost, warnings) = run(&*device, nothing.clone(), &mut |_, _| true);
    assert!(lost.expect_err("the device is lost").to_string().contains("the device was lost"));
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert!(warnings[0].ends_with("from 0 samples per pixel"), "{warnings:?}");
    let (rendered, warnings) = run(&*device, nothing, &mut |portion, _| portion < 2);
    let film = rendered.expect("the device renders").picture.film;
    assert!(film.pixels() == whole.film.pixels() && warnings.len() == 2, "{warnings:?}");

    // With a checkpoint, what there is is saved, and another render goes on from it.
    let (rendered, _) = run(&*device, request(&path), &mut |portion, _| portion > 3);
    let rendered = rendered.expect("a film");
    assert!(rendered.failure.is_some() && rendered.checkpoint.as_deref() == Some(&*path) && !rendered.finished);
    let samples = rendered.picture.film.samples();
    assert!(samples > 0 && rendered.progress.total_samples == samples, "{:?}", rendered.progress);
    drop(rendered);
    let (rendered, _) = run(&*device, request(&path), &mut |_, _| false);
    let rendered = rendered.expect("the device renders");
    assert!(same(&rendered.picture, &whole));
    assert_eq!(device.validation_messages(), Vec::<String>::new());

    // Others of a group do the work of the one that is lost for good.
    let cpu = CpuDevice::new(CpuOptions::default()).expect("threads can be had");
    let group = DeviceGroup::new(vec![device, Box::new(cpu)]);
    let (rendered, warnings) = run(&group, RenderRequest::default(), &mut |portion, _| portion % 2 == 1);
    let rendered = rendered.expect("the CPU goes on");
    assert!(rendered.finished && rendered.failure.is_none());
    assert_eq!(rendered.picture.film.sample_range(), (5, 5));
    assert!(warnings[0].contains("(vulkan:0): it was opened again, and the render goes on from "), "{warnings:?}");
    assert!(warnings[1].contains("the others go on without ") && warnings.len() == 2, "{warnings:?}");
}
