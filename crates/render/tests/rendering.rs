//! Requests come true: samples, layers, an early end, and what is left of a render whose device fails.

use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::sync::Arc;

use raggio_render::{
    Aov, CpuDevice, CpuOptions, Device, DeviceError, DeviceScene, InstructionSet, Observer, Portion, Progress,
    RenderError, RenderRequest, Rendered, Rendering, Session, Stop, Values, Walk,
};
use raggio_scene::Scene;

use crate::scripted::{Script, Scripted};

const WIDTH: u32 = 6;
const HEIGHT: u32 = 5;

fn scene() -> Scene {
    let text = "version = 1\n[render]\nwidth = 6\nheight = 5\nsamples = 3\n[camera]\nposition = [0, 0, 3]\n\
                look_at = [0, 0, 0]\nvertical_fov_degrees = 60\n[environment]\ncolor = [0.5, 0.7, 1]\n[materials.a]\n\
                [materials.unused]\n[[shapes]]\nmaterial = \"a\"\nsphere = { center = [0, 0, 0], radius = 1 }\n";
    Scene::parse(text, "scene.toml").expect("the scene is right")
}

fn cpu() -> CpuDevice {
    CpuDevice::new(CpuOptions::default()).expect("threads can be had")
}

/// Observer that keeps what it hears, and breaks off after so many portions.
struct Ear {
    warnings: Vec<String>,
    portions: usize,
    patience: usize,
}

impl Ear {
    fn patient(patience: usize) -> Self {
        Self { warnings: vec![], portions: 0, patience }
    }
}

impl Observer for Ear {
    fn warn(&mut self, warning: &str) {
        self.warnings.push(warning.to_owned());
    }

    fn progress(&mut self, _: &Progress) -> ControlFlow<()> {
        self.portions += 1;
        if self.portions >= self.patience { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

fn rendered(scene: &Scene, device: &dyn Device, request: RenderRequest, ear: &mut Ear) -> Rendered {
    let rendering = Rendering::begin(scene, device, request).expect("the scene loads");
    rendering.run(ear).expect("the film is there")
}

/// Request for a picture whose film has a label.
fn labelled() -> RenderRequest {
    RenderRequest { label: true, ..RenderRequest::default() }
}

#[test]
fn a_plain_request_is_the_scene_with_its_samples() {
    let mut ear = Ear::patient(usize::MAX);
    let rendered = rendered(&scene(), &cpu(), labelled(), &mut ear);
    assert!(rendered.finished && rendered.failure.is_none());
    assert_eq!((rendered.progress.samples, rendered.shapes, rendered.triangles), (3, 1, 0));
    assert!(ear.warnings.is_empty(), "{:?}", ear.warnings);
    let picture = rendered.picture;
    assert_eq!(picture.film.label().expect("a label").portions(), [Portion { samples: 0..3, rows: 0..HEIGHT }]);
    assert!(picture.extras.channels.is_empty());
}

#[test]
fn samples_and_layers_are_those_asked_for() {
    let stop = Stop { samples: Some(5..9), ..Stop::default() };
    let request = RenderRequest { layers: vec![Aov::Depth, Aov::Samples], stop, ..labelled() };
    let picture = rendered(&scene(), &cpu(), request, &mut Ear::patient(usize::MAX)).picture;
    assert_eq!(picture.film.label().expect("a label").portions(), [Portion { samples: 5..9, rows: 0..HEIGHT }]);
    let names: Vec<_> = picture.extras.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["depth.Z", "samples.N"]);
    assert_eq!(picture.extras.channels[1].values, Values::U32(vec![4; (WIDTH * HEIGHT) as usize]));
}

#[test]
fn who_breaks_off_gets_what_there_is() {
    let stop = Stop { samples: Some(0..1 << 30), ..Stop::default() };
    let request = RenderRequest { layers: vec![Aov::Albedo], stop, ..RenderRequest::default() };
    let rendered = rendered(&scene(), &cpu(), request, &mut Ear::patient(1));
    assert!(!rendered.finished);
    assert!(rendered.picture.film.samples() > 0, "the first portion is there");
    assert!(rendered.picture.film.label().is_none(), "nobody asked for a label");
    assert_eq!(rendered.picture.extras.channels.len(), 3, "and so are the layers");
}

#[test]
fn time_ends_a_render_without_a_number_of_samples() {
    let stop = Stop { time_limit: Some(0.05), ..Stop::default() };
    let rendered =
        rendered(&scene(), &cpu(), RenderRequest { stop, ..RenderRequest::default() }, &mut Ear::patient(usize::MAX));
    assert!(!rendered.finished);
    assert!(rendered.progress.samples > 3, "the scene's number does not count");
}

#[test]
fn noise_ends_a_render_where_it_is_low() {
    // An even sky has no noise at all.
    let mut scene = scene();
    scene.shapes.clear();
    scene.entries.clear();
    let stop = Stop { noise: Some(0.1), ..Stop::default() };
    let request = RenderRequest { stop, ..RenderRequest::default() };
    let rendered = rendered(&scene, &cpu(), request, &mut Ear::patient(usize::MAX));
    assert!(rendered.finished);
    assert_eq!(rendered.progress.samples, 64, "the first time that it is judged");
}

#[test]
fn pictures_that_no_machine_holds_are_refused() {
    let mut scene = scene();
    (scene.render.width, scene.render.height) = (65536, 65536);
    let refused = Rendering::begin(&scene, &cpu(), RenderRequest::default());
    // Nobody knows whether it is too large where the system does not tell its memory.
    if raggio_render::total_memory_bytes().is_some_and(|bytes| bytes < 300 << 30) {
        assert!(matches!(refused, Err(RenderError::TooLarge(_))));
    }
}

/// A device that fails at its third portion.
struct Failing {
    /// Whether the film is lost too.
    loses_film: bool,
}

struct FailingSession {
    portions: u32,
    loses_film: bool,
}

impl Device for Failing {
    fn name(&self) -> String {
        "failing".into()
    }

    fn load(&self, _: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        let session = FailingSession { portions: 0, loses_film: self.loses_film };
        Ok(Box::new(Scripted { size: [WIDTH, HEIGHT], patience: 1e-9, script: session }))
    }
}

impl Script for FailingSession {
    fn add_samples(&mut self, _: Range<u32>, _: Range<u32>) -> Result<(), DeviceError> {
        self.portions += 1;
        if self.portions < 3 { Ok(()) } else { Err(DeviceError::Host("the third portion".into())) }
    }

    fn film(&self) -> Result<(), DeviceError> {
        if self.loses_film && self.portions >= 3 { Err(DeviceError::Host("no film".into())) } else { Ok(()) }
    }
}

#[test]
fn a_device_that_fails_leaves_its_film() {
    let request = || RenderRequest { layers: vec![Aov::Samples], ..labelled() };
    let device = Failing { loses_film: false };
    let rendered = rendered(&scene(), &device, request(), &mut Ear::patient(usize::MAX));
    assert_eq!(rendered.failure.expect("it failed").to_string(), "the third portion");
    assert!(!rendered.finished && rendered.picture.extras.channels.is_empty());
    assert_eq!(rendered.picture.film.label().expect("a label").portions(), [Portion { samples: 0..1, rows: 0..2 }]);

    let rendering = Rendering::begin(&scene(), &Failing { loses_film: true }, request()).expect("the scene loads");
    let error = rendering.run(&mut Ear::patient(usize::MAX)).expect_err("the film is lost");
    assert_eq!(error.to_string(), "the third portion", "the first failure is told");
}

/// The scene seen from elsewhere, in another size.
fn elsewhere() -> Scene {
    let mut scene = scene();
    scene.camera.position.x = 2.0;
    (scene.render.width, scene.render.height) = (8, 4);
    scene
}

/// Picture of a rendering that is kept.
fn developed(rendering: &mut Rendering) -> Rendered {
    rendering.sample(&mut Ear::patient(usize::MAX)).expect("the device works");
    rendering.develop(&mut Ear::patient(usize::MAX), None).expect("the film is there")
}

#[test]
fn a_rendering_that_looks_elsewhere_is_a_new_one() {
    let request = RenderRequest { layers: vec![Aov::Depth, Aov::Distance, Aov::ObjectId], ..RenderRequest::default() };
    let device = cpu();
    let mut kept = Rendering::begin(&scene(), &device, request.clone()).expect("the scene loads");
    developed(&mut kept);
    let mut brighter = elsewhere();
    brighter.materials[0].color.x = 0.1;
    brighter.shapes.push(brighter.shapes[0].clone());
    for (scene, changed) in [(elsewhere(), false), (brighter, true), (scene(), true)] {
        let done = if changed { kept.change(&scene) } else { kept.look(&scene) };
        done.expect("the scene loads");
        let (again, anew) =
            (developed(&mut kept), rendered(&scene, &device, request.clone(), &mut Ear::patient(usize::MAX)));
        assert_eq!(again.picture.film, anew.picture.film);
        assert_eq!(again.picture.extras.channels, anew.picture.extras.channels);
        assert_eq!(again.shapes, anew.shapes);
    }
}

#[test]
fn samples_that_follow_are_those_of_one_render() {
    let device = cpu();
    let stop = Stop { samples: Some(0..2), ..Stop::default() };
    let request = RenderRequest { stop, layers: vec![Aov::Depth, Aov::Samples], ..RenderRequest::default() };
    let mut kept = Rendering::begin(&scene(), &device, request.clone()).expect("the scene loads");
    assert_eq!(developed(&mut kept).picture.film.sample_range(), (2, 2));
    kept.set_target(7);
    let stop = Stop { samples: Some(0..7), ..Stop::default() };
    let whole = rendered(&scene(), &device, RenderRequest { stop, ..request }, &mut Ear::patient(usize::MAX));
    let picture = developed(&mut kept).picture;
    assert_eq!(picture.film, whole.picture.film);
    assert_eq!(picture.extras.channels[1], whole.picture.extras.channels[1]);
}

/// Observer that asks of each portion whether something is there.
struct Looker<F>(F, Vec<bool>);

impl<F: Fn() -> bool> Observer for Looker<F> {
    fn warn(&mut self, warning: &str) {
        panic!("{warning}");
    }

    fn progress(&mut self, _: &Progress) -> ControlFlow<()> {
        self.1.push(self.0());
        ControlFlow::Continue(())
    }
}

/// Binary nodes of meshes go where rays walk through wide ones, and stay where rays need them; pictures, layers and labels
/// are the same.
#[test]
fn renders_give_up_nodes_that_nothing_reads() {
    let mut scene = Scene::rock(3);
    (scene.render.width, scene.render.height, scene.render.samples) = (24, 20, 2);
    let mut pictures = vec![];
    for set in InstructionSet::available() {
        for walk in [Walk::Wide, Walk::Portable] {
            let device = CpuDevice::new(CpuOptions { instruction_set: Some(set), walk, ..CpuOptions::default() });
            let translated = DeviceScene::new(&scene).expect("the scene fits devices");
            let nodes = Arc::downgrade(&translated.buffers.mesh_nodes);
            let request = RenderRequest { layers: vec![Aov::Depth], ..labelled() };
            let device = device.expect("threads can be had");
            let rendering = Rendering::begin_translated(&scene, translated, &device, request).expect("it loads");
            let mut looker = Looker(|| nodes.upgrade().is_some(), vec![]);
            let rendered = rendering.run(&mut looker).expect("the film is there");
            let are_read = walk == Walk::Portable || !matches!(set, InstructionSet::X86V3 | InstructionSet::X86V4);
            assert!(
                !looker.1.is_empty() && looker.1.iter().all(|are_there| *are_there == are_read),
                "{set:?}, {walk:?}"
            );
            pictures.push((set, walk, rendered.picture));
        }
    }
    let (_, _, first) = &pictures[0];
    for (set, walk, picture) in &pictures {
        assert!(picture.film.pixels() == first.film.pixels(), "{set:?}, {walk:?}");
        assert_eq!(picture.film.label(), first.film.label(), "{set:?}, {walk:?}");
        assert_eq!(picture.extras.channels[0].values, first.extras.channels[0].values, "{set:?}, {walk:?}");
    }
}

/// Parts that one rendering takes one after the other, in any order, are the picture that another makes of their sum, with
/// layers and alpha.
#[test]
fn a_film_that_others_have_sampled_becomes_the_picture() {
    let mut scene = scene();
    scene.render.alpha = true;
    let request = RenderRequest { layers: vec![Aov::Depth], ..labelled() };
    let whole = rendered(&scene, &cpu(), request.clone(), &mut Ear::patient(usize::MAX));

    let mut worker = Rendering::begin(&scene, &cpu(), labelled()).expect("the scene loads");
    let mut part = |samples: Range<u32>| {
        worker.restart_with(samples.clone()).expect("the device is well");
        let film = developed(&mut worker).picture.film;
        assert_eq!(film.label().expect("a label").portions(), [Portion { samples, rows: 0..HEIGHT }]);
        film
    };
    let mut film = part(1..3);
    film.merge(&part(0..1)).expect("other samples");
    assert_eq!(film.coverage(), whole.picture.film.coverage());

    let begin = |scene: &Scene| Rendering::begin(scene, &cpu(), request.clone()).expect("the scene loads");
    let path = Path::new("gathered.film");
    let mut ear = Ear::patient(usize::MAX);
    let made = begin(&scene).develop_film(film.clone(), path, 2.5, &mut ear).expect("it is of this scene");
    assert!(made.finished && made.failure.is_none());
    assert_eq!((made.progress.samples, made.progress.seconds), (3, 2.5));
    assert_eq!(made.picture.film, whole.picture.film);
    assert_eq!(made.picture.extras.channels, whole.picture.extras.channels);
    assert_eq!(made.checkpoint.as_deref(), Some(path));

    let unfinished = begin(&scene).develop_film(part(2..3), path, 2.5, &mut ear).expect("it is of this scene");
    assert!(!unfinished.finished);
    scene.camera.position.x += 1.0;
    let refused = begin(&scene).develop_film(film, path, 2.5, &mut ear).expect_err("it is of another");
    assert!(refused.to_string().contains("cannot go on from gathered.film: it is of another scene"), "{refused}");
}
