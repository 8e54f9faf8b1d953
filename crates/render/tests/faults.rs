//! Devices that fail in the middle of a render, at each of their calls.

use std::ops::ControlFlow;

use raggio_render::{
    Aov, Device, DeviceChoice, OpenOptions, Progress, RenderError, RenderRequest, Rendered, Rendering, open,
};
use raggio_vulkan::Fault;

use crate::checkpoints::{Ear, request, same, scene};

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
    let context = device.vulkan().expect("it is one").clone();
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
    for fault in [Fault::OutOfMemory, Fault::NoMemory, Fault::Lost] {
        let (mut overcome, mut saved) = (0, 0);
        for call in 1.. {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("a.checkpoint");
            context.pretend_fault(call, fault);
            let outcome = render(with_layers(request(&path)));
            let is_over = context.fault_is_due();
            context.pretend_fault(0, fault);
            let said = |error: String| {
                let words = ["out of memory on the device", "the device was lost"][(fault == Fault::Lost) as usize];
                assert!(error.contains(words), "call {call}: {error}");
            };
            match outcome {
                Ok(Rendered { failure: None, picture, finished, .. }) => {
                    // Without memory for the last wait, all has been done nevertheless.
                    assert!(is_over || fault != Fault::Lost, "call {call} was lost and nobody has noticed");
                    assert!(finished && same(&picture, &whole), "call {call}: another picture");
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
            // Whatever it was, the same request makes the picture, from the checkpoint where there is one.
            let again = render(with_layers(request(&path))).expect("the device renders");
            assert!(again.failure.is_none() && same(&again.picture, &whole), "call {call}: another picture");
            if is_over {
                assert!(call > 100, "only {call} calls");
                break;
            }
        }
        // One call too many is made again; what lasts ends the render, and what there was is saved.
        let is_once = fault == Fault::OutOfMemory;
        let is_right = if is_once { overcome > 20 && saved == 0 } else { overcome < 4 && saved > 20 };
        assert!(is_right, "{fault:?}: {saved} saved, {overcome} overcome");
    }
    assert_eq!(device.validation_messages(), Vec::<String>::new());

    // Without a checkpoint, a loss is the error that it is.
    let rendering = Rendering::begin(&scene, &*device, RenderRequest::default()).expect("the scene loads");
    let lost = rendering.run(&mut |_: &Progress| {
        context.pretend_lost();
        ControlFlow::Continue(())
    });
    assert!(lost.expect_err("the device is lost").to_string().contains("the device was lost"));
}
