//! Renders that go on from checkpoints: the same bits as without a break, or a reason why not.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use raggio_render::{
    Aov, CheckpointError, Checkpoints, CpuDevice, CpuOptions, Every, Film, Observer, Picture, Progress, RenderError,
    RenderRequest, Rendered, Rendering, Stop,
};
use raggio_scene::Scene;

/// A sphere that is lit from above alone, so that parts of the picture rest early and others late.
pub const TEXT: &str = "version = 1\n[render]\nwidth = 40\nheight = 30\nsamples = 40\n[camera]\nposition = [0, 0, 3]\n\
                look_at = [0, 0, 0]\nvertical_fov_degrees = 60\n[environment]\nhorizon = [0, 0, 0]\nzenith = [4, 4, 4]\n\
                [materials.a]\n[[shapes]]\nmaterial = \"a\"\nsphere = { center = [0, 0, 0], radius = 1 }\n";

pub fn scene() -> Scene {
    Scene::parse(TEXT, "scene.toml").expect("the scene is right")
}

fn cpu() -> CpuDevice {
    CpuDevice::new(CpuOptions::default()).expect("threads can be had")
}

/// Observer that breaks off after so many portions, and keeps what it hears.
#[derive(Default)]
pub struct Ear {
    pub patience: Option<usize>,
    pub warnings: Vec<String>,
    pub saved: usize,
}

impl Observer for Ear {
    fn warn(&mut self, warning: &str) {
        self.warnings.push(warning.to_owned());
    }

    fn saved(&mut self, _: &Path) {
        self.saved += 1;
    }

    fn progress(&mut self, _: &Progress) -> ControlFlow<()> {
        let Some(patience) = &mut self.patience else { return ControlFlow::Continue(()) };
        *patience = patience.saturating_sub(1);
        if *patience == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Request that goes on from `path`, if there is something, with a checkpoint after each sample.
pub fn request(path: &Path) -> RenderRequest {
    let every = Every::Samples(1);
    let checkpoints = Checkpoints { path: path.into(), every, resume: true, only_long: false };
    RenderRequest { label: true, checkpoints: Some(checkpoints), ..RenderRequest::default() }
}

/// A render that has ended and has left its checkpoints to the next.
struct Ended {
    picture: Picture,
    progress: Progress,
    finished: bool,
    checkpoint: Option<PathBuf>,
}

/// Renders until `patience` portions are over, or to the end.
fn render(scene: &Scene, request: RenderRequest, patience: Option<usize>) -> (Ended, Ear) {
    let (rendered, ear) = render_and_hold(scene, request, patience);
    let Rendered { picture, progress, finished, checkpoint, .. } = rendered;
    (Ended { picture, progress, finished, checkpoint }, ear)
}

/// Renders as [`render`] does, and keeps the checkpoints from others.
fn render_and_hold(scene: &Scene, request: RenderRequest, patience: Option<usize>) -> (Rendered, Ear) {
    let mut ear = Ear { patience, ..Ear::default() };
    let rendering = Rendering::begin(scene, &cpu(), request).unwrap_or_else(|error| panic!("{error}"));
    (rendering.run(&mut ear).expect("the device renders"), ear)
}

/// Removes the checkpoints of a render.
fn remove(rendered: Rendered) {
    rendered.remove_checkpoints().expect("files can be removed");
}

pub fn same(found: &Picture, expected: &Picture) -> bool {
    found.film == expected.film && found.extras.channels == expected.extras.channels
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.checkpoint");
    (folder, path)
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Breaks a render off again and again, each time after another number of portions, and compares what comes of it with a
/// render that is let alone.
fn interrupted_is_uninterrupted(of: RenderRequest) {
    let scene = scene();
    let (whole, _) = render(&scene, RenderRequest { checkpoints: None, ..of.clone() }, None);
    assert!(whole.finished);
    for seed in 1..4 {
        let (folder, path) = folder();
        let mut breaks = 0;
        let rendered = loop {
            let request = RenderRequest { checkpoints: request(&path).checkpoints, ..of.clone() };
            let patience = 1 + (7 * breaks + 5 * seed) % 11;
            let (rendered, ear) = render(&scene, request, Some(patience));
            assert_eq!(ear.warnings, Vec::<String>::new());
            assert!(rendered.checkpoint.as_deref() == Some(&*path) && ear.saved > 0);
            if rendered.finished {
                break rendered;
            }
            breaks += 1;
        };
        assert!(breaks > 2, "the render was broken off {breaks} times");
        // Layers are whole only where nobody breaks them off.
        let same_request = RenderRequest { checkpoints: request(&path).checkpoints, ..of.clone() };
        let (again, _) = render_and_hold(&scene, same_request, None);
        assert!(same(&again.picture, &whole.picture), "the picture is another after {breaks} breaks");
        assert_eq!(again.progress.total_samples, whole.progress.total_samples);
        assert!(again.progress.seconds >= rendered.progress.seconds);
        remove(again);
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
}

#[test]
fn plain_renders_go_on_with_the_same_bits() {
    interrupted_is_uninterrupted(RenderRequest { label: true, ..RenderRequest::default() });
}

#[test]
fn ranges_of_samples_go_on_with_the_same_bits() {
    let stop = Stop { samples: Some(3..50), ..Stop::default() };
    interrupted_is_uninterrupted(RenderRequest { label: true, stop, ..RenderRequest::default() });
}

#[test]
fn renders_with_layers_go_on_with_the_same_bits() {
    let layers = vec![Aov::Normal, Aov::Depth, Aov::ObjectId, Aov::Samples, Aov::Variance];
    interrupted_is_uninterrupted(RenderRequest { label: true, layers, ..RenderRequest::default() });
}

#[test]
fn adaptive_renders_go_on_with_the_same_bits() {
    let stop = Stop { noise: Some(0.05), samples: Some(0..120), ..Stop::default() };
    let request = RenderRequest { label: true, stop, layers: vec![Aov::Samples], ..RenderRequest::default() };
    let (whole, _) = render(&scene(), request.clone(), None);
    let (fewest, most) = whole.picture.film.sample_range();
    assert!(fewest < most && most == 120, "parts rest at different times: {fewest} to {most} samples");
    interrupted_is_uninterrupted(request);
}

/// Portions of a device that is slow enough end in the middle of a pass.
#[test]
fn passes_go_on_in_their_middle() {
    let mut scene = scene();
    (scene.render.width, scene.render.height, scene.render.samples) = (500, 400, 3);
    let (_folder, path) = folder();
    let (begun, _) = render(&scene, request(&path), Some(1));
    let portions = begun.picture.film.label().expect("a label").portions().to_vec();
    assert!(portions.len() == 1 && portions[0].rows.end < 400, "{portions:?}");
    let (found, _) = render(&scene, request(&path), None);
    let (whole, _) = render(&scene, RenderRequest { checkpoints: None, ..request(&path) }, None);
    assert!(same(&found.picture, &whole.picture));
}

#[test]
fn short_renders_keep_nothing_unless_they_are_to() {
    let (folder, path) = folder();
    let only_long = |request: RenderRequest| RenderRequest {
        checkpoints: request.checkpoints.map(|kept| Checkpoints { only_long: true, ..kept }),
        ..request
    };
    let (rendered, ear) = render(&scene(), only_long(request(&path)), None);
    assert!(rendered.checkpoint.is_none() && ear.saved == 0);
    assert_eq!(names(folder.path()), Vec::<String>::new());
    let stop = Stop { samples: Some(0..i32::MAX as u32), ..Stop::default() };
    let (rendered, _) = render(&scene(), RenderRequest { stop, ..only_long(request(&path)) }, Some(5));
    assert_eq!(rendered.checkpoint, Some(path));
}

/// The clock goes on where it stood.
#[test]
fn time_that_has_been_spent_counts() {
    let (_folder, path) = folder();
    let limited = |seconds| {
        let stop = Stop { time_limit: Some(seconds), ..Stop::default() };
        RenderRequest { stop, ..request(&path) }
    };
    let (first, _) = render(&scene(), limited(0.2), None);
    let (second, _) = render(&scene(), limited(0.2), None);
    assert_eq!(second.progress.total_samples, first.progress.total_samples, "there is no time left");
    let (third, _) = render(&scene(), limited(0.4), None);
    assert!(third.progress.total_samples > first.progress.total_samples);
    assert!(third.progress.seconds < 0.5, "{} s", third.progress.seconds);
}

fn refusal(scene: &Scene, request: RenderRequest) -> String {
    match Rendering::begin(scene, &cpu(), request) {
        Err(RenderError::Checkpoint(error)) => error.to_string(),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("the checkpoint is of something else"),
    }
}

#[test]
fn checkpoints_of_something_else_are_refused_with_the_reason() {
    let (_folder, path) = folder();
    render(&scene(), request(&path), Some(6));
    let before = fs::read(&path).expect("a checkpoint");
    let other = |change: fn(&mut Scene, &mut RenderRequest), reason: &str| {
        let (mut scene, mut request) = (scene(), request(&path));
        change(&mut scene, &mut request);
        let message = refusal(&scene, request);
        let expected = format!("cannot go on from {}: {reason}", path.display());
        assert!(message.starts_with(&expected), "expected {expected} and found {message}");
    };
    let scene_reason = "it is of another scene, or of this one before it was changed: render as it was rendered";
    other(|scene, _| scene.camera.position.x = 0.1, scene_reason);
    other(|scene, _| scene.render.seed = 4, "it was made with seed `0`, and seed is `4` now: ");
    other(|scene, _| scene.render.clamp = Some(2.0), "it was made with clamp `none`, and clamp is `2` now: ");
    other(|scene, _| scene.render.width = 41, "it has 40x30 pixels, and the picture is to have 41x30: ");
    other(|_, request| request.stop.noise = Some(0.5), "it was made with noise `none`, and noise is `0.5` now: ");
    let with = |range| RenderRequest { stop: Stop { samples: Some(range), ..Stop::default() }, ..request(&path) };
    let few = refusal(&scene(), with(0..2));
    assert!(few.starts_with(&format!("cannot go on from {}: it has samples 0..", path.display())), "{few}");
    assert!(refusal(&scene(), with(2..60)).ends_with(", and 2..60 are to be rendered"));
    assert_eq!(fs::read(&path).expect("a checkpoint"), before, "what is refused stays");
    // More samples than were wanted first are no other picture.
    let (longer, _) = render(&scene(), with(0..50), None);
    let (whole, _) = render(&scene(), RenderRequest { checkpoints: None, ..with(0..50) }, None);
    assert!(same(&longer.picture, &whole.picture));
}

#[test]
fn films_that_are_no_checkpoints_are_refused() {
    let (folder, path) = folder();
    let (rendered, _) = render(&scene(), RenderRequest { checkpoints: None, ..request(&path) }, None);
    rendered.picture.film.write(&path).expect("the folder is there");
    assert!(refusal(&scene(), request(&path)).ends_with("it is a film, and no checkpoint"));
    fs::write(&path, "a letter to somebody").expect("a file");
    assert!(refusal(&scene(), request(&path)).ends_with("not a film of raggio"));
    assert_eq!(fs::read(&path).expect("a file"), b"a letter to somebody");
    let nowhere = folder.path().join("nowhere/a.checkpoint");
    let error = Rendering::begin(&scene(), &cpu(), request(&nowhere)).err().expect("there is no such folder");
    assert!(matches!(error, RenderError::Checkpoint(CheckpointError::Unwritable { .. })), "{error}");
}

/// Two checkpoints are kept, so that one may be damaged in any byte.
#[test]
fn the_one_before_is_used_where_the_newest_is_damaged() {
    let scene = scene();
    let (_folder, path) = folder();
    let (whole, _) = render(&scene, RenderRequest { checkpoints: None, ..request(&path) }, None);
    let previous = PathBuf::from(format!("{}.previous", path.display()));
    render(&scene, request(&path), Some(9));
    let [newest, before] = [&path, &previous].map(|path| fs::read(path).expect("two are kept"));
    let samples = |path: &Path| Film::read(path).expect("checkpoints are films").samples();
    assert!(samples(&previous) < samples(&path));
    let flipped = |place: usize| {
        let mut bytes = newest.clone();
        bytes[place] ^= 4;
        bytes
    };
    let places = [3, 9, 30, 200, newest.len() / 2, newest.len() - 40, newest.len() - 1];
    let damaged = places.map(flipped).into_iter().chain([0, 7, 100, newest.len() - 1].map(|n| newest[..n].to_vec()));
    for bytes in damaged {
        fs::write(&path, &bytes).expect("a file");
        fs::write(&previous, &before).expect("a file");
        let (found, ear) = match Rendering::begin(&scene, &cpu(), request(&path)) {
            Ok(rendering) => {
                assert_eq!(rendering.resumed(), Some(&*previous));
                let mut ear = Ear::default();
                (rendering.run(&mut ear).expect("the device renders"), ear)
            }
            // The number of the format.
            Err(RenderError::Checkpoint(CheckpointError::Unreadable(error))) => {
                assert!(error.to_string().contains("a film of format"), "{error}");
                continue;
            }
            Err(error) => panic!("{error}"),
        };
        let [warning] = &ear.warnings[..] else { panic!("one warning: {:?}", ear.warnings) };
        assert!(warning.contains("the checkpoint before it is used, "), "{warning}");
        assert!(same(&found.picture, &whole.picture));
    }
    // A program that is killed between two renamings leaves the one before alone.
    fs::remove_file(&path).expect("a file");
    fs::write(&previous, &before).expect("a file");
    let (found, ear) = render(&scene, request(&path), None);
    assert!(ear.warnings[0].contains("is missing: the checkpoint before it is used"), "{:?}", ear.warnings);
    assert!(same(&found.picture, &whole.picture));
    // Nothing is lost by beginning anew where both are damaged.
    fs::write(&path, &newest[..newest.len() / 2]).expect("a file");
    fs::write(&previous, &before[..before.len() / 2]).expect("a file");
    let (found, ear) = render(&scene, request(&path), None);
    assert!(ear.warnings[0].ends_with("the render begins anew"), "{:?}", ear.warnings);
    assert!(same(&found.picture, &whole.picture));
}

#[test]
fn a_film_of_another_version_is_refused() {
    let (_folder, path) = folder();
    render(&scene(), request(&path), Some(4));
    let bytes = fs::read(&path).expect("a checkpoint");
    // The text of the version follows magic, format, size and hash; the checksum is that of all bytes before.
    let mut changed = bytes[..bytes.len() - 32].to_vec();
    assert_eq!(&changed[56..61], env!("CARGO_PKG_VERSION").as_bytes());
    changed[56] = b'9';
    let checksum = blake3::hash(&changed);
    changed.extend(checksum.as_bytes());
    fs::write(&path, changed).expect("a file");
    let message = refusal(&scene(), request(&path));
    assert!(message.contains("it was made by raggio 9.") && message.contains("and this is raggio 0."), "{message}");
}

#[test]
fn a_checkpoint_belongs_to_one_render_at_a_time() {
    let (folder, path) = folder();
    let first = Rendering::begin(&scene(), &cpu(), request(&path)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(names(folder.path()), ["a.checkpoint.lock"]);
    let by = format!("process {}", std::process::id());
    let message = refusal(&scene(), request(&path));
    let words = format!("{} belongs to a render under way, {by}", path.display());
    assert!(message.starts_with(&words) && message.ends_with("name another with --checkpoint"), "{message}");
    // Whatever the place is called.
    let elsewhere = folder.path().join("./a.checkpoint");
    assert!(refusal(&scene(), request(&elsewhere)).contains("belongs to a render under way"));
    // It is free again once the other has removed its files, or has ended without.
    let rendered = first.run(&mut Ear::default()).expect("the device renders");
    assert!(
        refusal(&scene(), request(&path)).contains("belongs to a render under way"),
        "files are still to be written"
    );
    drop(rendered);
    assert_eq!(names(folder.path()), ["a.checkpoint", "a.checkpoint.previous"]);
    let (rendered, ear) = render_and_hold(&scene(), request(&path), None);
    assert!(rendered.finished && ear.warnings.is_empty());
    remove(rendered);
    // The lock of a program that was killed is none.
    fs::write(folder.path().join("a.checkpoint.lock"), "process 1 on a machine of long ago").expect("a file");
    let (rendered, ear) = render_and_hold(&scene(), request(&path), None);
    assert!(rendered.finished && ear.warnings.is_empty());
    remove(rendered);
    assert_eq!(names(folder.path()), Vec::<String>::new());
    // Where nothing can be locked, the render goes on with a warning.
    fs::create_dir(folder.path().join("a.checkpoint.lock")).expect("a folder");
    let (rendered, ear) = render_and_hold(&scene(), request(&path), None);
    assert!(rendered.finished && ear.warnings.len() == 1, "{:?}", ear.warnings);
    assert!(ear.warnings[0].contains("cannot be locked"), "{:?}", ear.warnings);
}

/// A disk that takes its time keeps no render waiting: portions go on while a checkpoint is written, and no two are at once.
#[cfg(unix)]
#[test]
fn rendering_goes_on_while_a_checkpoint_is_written() {
    let mut scene = scene();
    (scene.render.width, scene.render.height, scene.render.samples) = (1000, 1000, 12);
    let (folder, path) = folder();
    let part = folder.path().join("a.checkpoint.part");
    let mut portions_meanwhile = 0;
    let rendering = Rendering::begin(&scene, &cpu(), request(&path)).unwrap_or_else(|error| panic!("{error}"));
    let rendered = rendering.run(&mut |_: &Progress| {
        portions_meanwhile += usize::from(part.exists());
        ControlFlow::Continue(())
    });
    assert!(rendered.expect("the device renders").finished);
    assert!(portions_meanwhile > 0, "no portion ended while a checkpoint of 72 megabytes was written");
}
