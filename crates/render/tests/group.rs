//! Devices that share a picture: the same bits as one of them makes alone, in the time that their speeds add up to.

use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use raggio_render::{
    Aov, CpuDevice, CpuOptions, Device, DeviceError, DeviceGroup, DeviceScene, Display, Pixels, RenderRequest,
    Rendered, Renderer, Rendering, Session, Stop,
};

use crate::checkpoints::{Ear, request, same, scene};
use crate::scripted::{Script, Scripted};

const WIDTH: u32 = 40;
const HEIGHT: u32 = 30;

fn cpu(threads: usize) -> CpuDevice {
    CpuDevice::new(CpuOptions { threads, ..CpuOptions::default() }).expect("threads can be had")
}

fn group() -> DeviceGroup {
    DeviceGroup::new(vec![Box::new(cpu(1)), Box::new(cpu(2)), Box::new(cpu(1))])
}

fn render(device: &dyn Device, request: &RenderRequest) -> Rendered {
    let rendering = Rendering::begin(&scene(), device, request.clone()).expect("the render can begin");
    rendering.run(&mut Ear::default()).expect("the devices render")
}

#[test]
fn pictures_have_the_bits_of_one_device() {
    let plain = RenderRequest { label: true, ..RenderRequest::default() };
    let stop = |stop: Stop| RenderRequest { stop, ..plain.clone() };
    for request in [
        plain.clone(),
        stop(Stop { samples: Some(3..50), ..Stop::default() }),
        stop(Stop { noise: Some(0.05), samples: Some(0..300), ..Stop::default() }),
        RenderRequest { layers: vec![Aov::Depth, Aov::Normal, Aov::ObjectId], denoise: true, ..plain.clone() },
    ] {
        let (together, alone) = (render(&group(), &request), render(&cpu(1), &request));
        assert!(together.finished && same(&together.picture, &alone.picture), "{request:?}");
        assert_eq!(together.progress.total_samples, alone.progress.total_samples);
    }
}

#[test]
fn checkpoints_are_those_of_any_device() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.checkpoint");
    let whole = render(&cpu(1), &RenderRequest { label: true, ..RenderRequest::default() });
    let mut rendered = None;
    for i in 0..100 {
        let device: &dyn Device = if i % 2 == 0 { &group() } else { &cpu(2) };
        let rendering = Rendering::begin(&scene(), device, request(&path)).expect("the render can begin");
        let mut ear = Ear { patience: Some(2), ..Ear::default() };
        let found = rendering.run(&mut ear).expect("the devices render");
        if found.finished {
            rendered = Some((i, found));
            break;
        }
    }
    let (breaks, rendered) = rendered.expect("two portions at a time are enough");
    assert!(breaks > 2 && same(&rendered.picture, &whole.picture));
}

#[test]
fn films_are_shown_and_begun_anew() {
    let scene = DeviceScene::new(&scene()).expect("the scene fits");
    let renderer = |device: &dyn Device| Renderer::new(device.load(&scene).expect("it loads"), &scene, 0..8);
    let (mut together, mut alone) = (renderer(&group()), renderer(&cpu(1)));
    for _ in 0..2 {
        for renderer in [&mut together, &mut alone] {
            while !renderer.finished() {
                renderer.advance().expect("a portion");
            }
        }
        let shown = [&mut together, &mut alone].map(|renderer| {
            match renderer.session().display(Display::default()).expect("it can be shown") {
                Pixels::Host(pixels) => pixels,
                Pixels::Device(_) => panic!("the CPU has its pixels on the host"),
            }
        });
        assert!(shown[0] == shown[1] && shown[0].iter().any(|pixel| *pixel != shown[0][0]));
        let film = alone.film().expect("a film");
        assert_eq!(together.film().expect("a film"), film);
        let row = together.session().pixels(3..9, 15).expect("pixels");
        assert_eq!(row, film.pixels()[(15 * WIDTH + 3) as usize..(15 * WIDTH + 9) as usize]);
        for renderer in [&mut together, &mut alone] {
            renderer.restart(&scene).expect("it begins anew");
        }
    }
}

/// Rows and samples of a call.
type Call = (Range<u32>, Range<u32>);

/// A device that only takes its time, and fails at a call if it is to.
#[derive(Clone)]
struct Slow {
    name: &'static str,
    seconds_per_sample: f64,
    fails_at: Option<usize>,
    calls: Arc<Mutex<Vec<Call>>>,
}

impl Slow {
    fn new(name: &'static str, seconds_per_sample: f64) -> Self {
        Self { name, seconds_per_sample, fails_at: None, calls: Arc::default() }
    }

    fn samples(&self) -> usize {
        let calls = self.calls.lock().expect("no test panicked");
        calls.iter().map(|(rows, samples)| rows.len() * samples.len()).sum::<usize>() * WIDTH as usize
    }
}

impl Device for Slow {
    fn name(&self) -> String {
        self.name.into()
    }

    fn load(&self, _: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        Ok(Box::new(Scripted { size: [WIDTH, HEIGHT], patience: 0.05, script: self.clone() }))
    }
}

impl Script for Slow {
    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError> {
        let mut calls = self.calls.lock().expect("no test panicked");
        if self.fails_at == Some(calls.len()) {
            return Err(DeviceError::Host("it has fallen off".into()));
        }
        let pixels = rows.len() * samples.len() * WIDTH as usize;
        calls.push((rows, samples));
        drop(calls);
        std::thread::sleep(Duration::from_secs_f64(pixels as f64 * self.seconds_per_sample));
        Ok(())
    }
}

#[test]
fn work_is_shared_by_speed() {
    const SAMPLES: u32 = 2000;
    // Together they do 1.2 million samples, the number that there are in two seconds.
    let devices = [Slow::new("fast", 1e-6), Slow::new("slow", 5e-6)];
    let group = DeviceGroup::new(devices.iter().map(|device| Box::new(device.clone()) as Box<dyn Device>).collect());
    assert_eq!(group.name(), "fast + slow");
    let scene = DeviceScene::new(&scene()).expect("the scene fits");
    let mut renderer = Renderer::new(group.load(&scene).expect("it loads"), &scene, 0..SAMPLES);
    let start = Instant::now();
    while !renderer.finished() {
        renderer.advance().expect("a portion");
    }
    let seconds = start.elapsed().as_secs_f64();

    let [fast, slow] = [0, 1].map(|i| devices[i].samples() as f64);
    let all = f64::from(WIDTH * HEIGHT * SAMPLES);
    assert_eq!(fast + slow, all);
    let mut times = vec![0; (HEIGHT * SAMPLES) as usize];
    for device in &devices {
        for (rows, samples) in device.calls.lock().expect("no test panicked").iter() {
            for sample in samples.clone() {
                rows.clone().for_each(|row| times[(sample * HEIGHT + row) as usize] += 1);
            }
            // What takes one device too long is cut for it.
            let pixels = (rows.len() * samples.len()) as f64 * f64::from(WIDTH);
            assert!(pixels * device.seconds_per_sample < 0.1 || samples.len() == 1, "{rows:?} {samples:?}");
        }
    }
    assert!(times.iter().all(|times| *times == 1), "some samples are missing or there twice");
    assert!((fast / slow / 5.0 - 1.0).abs() < 0.25, "the shares are {fast} and {slow}");
    let ideal = all / 1.2e6;
    println!("{seconds:.3} s of {ideal:.3} s");
    assert!(seconds < 1.5 * ideal, "it took {seconds} s, where {ideal} s are enough");
}

#[test]
fn the_others_take_the_samples_of_one_that_fails() {
    let failing = Slow { fails_at: Some(3), ..Slow::new("b", 1e-6) };
    let other = Slow::new("a", 1e-6);
    let group = DeviceGroup::new(vec![Box::new(other.clone()), Box::new(failing)]);
    let rendering = Rendering::begin(&scene(), &group, RenderRequest::default()).expect("the render can begin");
    let mut ear = Ear::default();
    let rendered = rendering.run(&mut ear).expect("the other goes on");
    assert!(rendered.finished && rendered.failure.is_none());
    let [warning] = &ear.warnings[..] else { panic!("one warning: {:?}", ear.warnings) };
    let words =
        "it has fallen off: the others go on without b, for it cannot be opened again, and the render goes on from ";
    assert!(warning.starts_with(words), "{warning}");
    // What both had done is done once more, for the sums of one are lost.
    let all = (WIDTH * HEIGHT * scene().render.samples) as usize;
    assert!(other.samples() >= all, "{} of {all} samples", other.samples());
}

#[test]
fn nothing_is_read_after_a_failure_of_all() {
    let failing = |calls: [usize; 2]| {
        let failing = |name, fails_at| Box::new(Slow { fails_at: Some(fails_at), ..Slow::new(name, 1e-6) });
        DeviceGroup::new(vec![failing("a", calls[0]), failing("b", calls[1])])
    };
    let rendering =
        Rendering::begin(&scene(), &failing([4, 3]), RenderRequest::default()).expect("the render can begin");
    let error = rendering.run(&mut Ear::default()).expect_err("the film is lost");
    assert_eq!(error.to_string(), "it has fallen off");

    // What a checkpoint has is the picture.
    let folder = tempfile::tempdir().expect("a folder");
    let request = request(&folder.path().join("a.checkpoint"));
    let rendering = Rendering::begin(&scene(), &failing([12, 9]), request).expect("the render can begin");
    let rendered = rendering.run(&mut Ear::default()).expect("a checkpoint");
    assert!(!rendered.finished && rendered.checkpoint.is_some());
    assert_eq!(rendered.failure.expect("the reason").to_string(), "it has fallen off");
}
