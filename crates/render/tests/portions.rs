//! The renderer cuts work into portions that a device has patience for, and leaves nothing out.

use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use raggio_render::{DeviceError, DeviceScene, Feature, Renderer};
use raggio_scene::Scene;

use crate::scripted::{Script, Scripted};

const WIDTH: u32 = 100;
const HEIGHT: u32 = 70;

/// Record of what a device was asked to do.
#[derive(Default)]
struct Log {
    /// Samples of each row, in order of arrival.
    samples: Vec<Vec<Range<u32>>>,
    /// Pixel samples of each call.
    portions: Vec<f64>,
}

/// A device that only takes its time.
struct Clock {
    seconds_per_sample: f64,
    shown: Feature,
    log: Arc<Mutex<Log>>,
}

impl Script for Clock {
    fn show(&mut self, feature: Feature) {
        self.shown = feature;
    }

    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError> {
        let mut log = self.log.lock().expect("no test panicked");
        log.samples.resize(HEIGHT as usize, vec![]);
        let portion = f64::from(WIDTH) * rows.len() as f64 * samples.len() as f64;
        log.portions.push(portion);
        // The samples of the picture alone are recorded.
        for row in rows.filter(|_| self.shown == Feature::Radiance) {
            log.samples[row as usize].push(samples.clone());
        }
        std::thread::sleep(Duration::from_secs_f64(portion * self.seconds_per_sample));
        Ok(())
    }
}

fn renderer(seconds_per_sample: f64, samples: Range<u32>, log: &Arc<Mutex<Log>>) -> Renderer {
    let clock = Clock { seconds_per_sample, shown: Feature::Radiance, log: log.clone() };
    let session = Scripted { size: [WIDTH, HEIGHT], patience: 0.02, script: clock };
    Renderer::new(Box::new(session), &scene(), samples)
}

/// An empty scene whose picture has the size that all tests take.
fn scene() -> DeviceScene {
    let text = format!(
        "version = 1\nrender = {{ width = {WIDTH}, height = {HEIGHT} }}\ncamera = {{ position = [0, 0, 1], look_at = [0, 0, 0], vertical_fov_degrees = 40 }}\n"
    );
    DeviceScene::new(&Scene::parse(&text, "empty.toml").expect("the scene is valid")).expect("it fits devices")
}

fn render(seconds_per_sample: f64, target: u32) -> Log {
    render_range(seconds_per_sample, 0..target)
}

fn render_range(seconds_per_sample: f64, samples: Range<u32>) -> Log {
    let target = samples.end - samples.start;
    let log = Arc::new(Mutex::new(Log::default()));
    let mut renderer = renderer(seconds_per_sample, samples, &log);
    let mut last = 0.0;
    while !renderer.finished() {
        let progress = renderer.advance().expect("a portion");
        assert!(progress.fraction > last && progress.fraction <= 1.0, "{last} then {progress:?}");
        last = progress.fraction;
    }
    assert_eq!(renderer.progress().samples, target);
    assert_eq!(renderer.progress().total_samples, u64::from(WIDTH * HEIGHT) * u64::from(target));
    drop(renderer);
    Arc::into_inner(log).expect("the session is gone").into_inner().expect("no test panicked")
}

fn assert_each_sample_once(log: &Log, target: u32) {
    assert_each_sample_of(log, 0..target);
}

fn assert_each_sample_of(log: &Log, samples: Range<u32>) {
    for ranges in &log.samples {
        let mut next = samples.start;
        for range in ranges {
            assert_eq!(range.start, next, "ranges in order, without gap or overlap");
            next = range.end;
        }
        assert_eq!(next, samples.end);
    }
}

#[test]
fn a_range_begins_where_it_says() {
    let log = render_range(1e-7, 700..1000);
    assert_each_sample_of(&log, 700..1000);
}

#[test]
fn a_slow_device_gets_portions_of_its_patience() {
    // A second for the whole image at one sample: fifty portions of 20 ms.
    let seconds_per_sample = 1.0 / f64::from(WIDTH * HEIGHT);
    let log = render(seconds_per_sample, 1);
    assert_each_sample_once(&log, 1);
    // The first portion is a guess.
    for portion in &log.portions[1..] {
        assert!(portion * seconds_per_sample <= 0.03, "a portion took {} s", portion * seconds_per_sample);
    }
    // Some sixty on an idle machine; on a busy one a sleep takes longer, and the renderer takes that for a slow device.
    assert!(log.portions.len() < 500, "{} portions", log.portions.len());
}

#[test]
fn a_fast_device_gets_many_samples_at_once() {
    let log = render(1e-9, 20_000);
    assert_each_sample_once(&log, 20_000);
    // 0.14 s of work in portions of at most 20 ms, and a few small ones while the rate is found out.
    assert!(log.portions.len() < 200, "{} portions", log.portions.len());
}

#[test]
fn a_session_of_no_cost_ends_too() {
    let log = render(0.0, 3);
    assert_each_sample_once(&log, 3);
}

#[test]
fn each_film_goes_on_from_where_it_was_left() {
    let log = Arc::new(Mutex::new(Log::default()));
    let mut renderer = renderer(1e-7, 0..1000, &log);
    let finish = |renderer: &mut Renderer| {
        while !renderer.finished() {
            renderer.advance().expect("a portion");
        }
    };
    for _ in 0..3 {
        renderer.advance().expect("a portion");
    }
    let before = renderer.progress();
    renderer.show(Feature::Normal).expect("normals are shown");
    assert_eq!((renderer.feature(), renderer.progress().total_samples), (Feature::Normal, 0));
    finish(&mut renderer);
    renderer.show(Feature::Radiance).expect("radiance is shown");
    assert_eq!(renderer.progress(), before);
    finish(&mut renderer);
    assert_each_sample_once(&log.lock().expect("no test panicked"), 1000);

    // The last feature's film is kept, another one begins anew.
    renderer.show(Feature::Normal).expect("normals are shown");
    assert!(renderer.finished());
    renderer.show(Feature::Depth).expect("depth is shown");
    assert_eq!(renderer.progress().total_samples, 0);
}

/// A device on which the rows of the lower half take as long as paths can be over those of a single ray.
struct Room {
    seconds_per_ray: f64,
    longest: Arc<Mutex<Duration>>,
}

const DEPTH: u32 = 500;

impl Script for Room {
    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError> {
        let rays: f64 = rows.map(|row| if row < HEIGHT / 2 { 1.0 } else { f64::from(2 * DEPTH) }).sum();
        let seconds = rays * f64::from(WIDTH) * samples.len() as f64 * self.seconds_per_ray;
        let start = std::time::Instant::now();
        std::thread::sleep(Duration::from_secs_f64(seconds));
        let mut longest = self.longest.lock().expect("no test panicked");
        *longest = start.elapsed().max(*longest);
        Ok(())
    }
}

#[test]
fn rows_that_nobody_knows_are_taken_with_caution() {
    // A row of the sky takes 0.2 ms and one of the room 0.2 s: after the sky's portions of 1, 4 and 16 rows the next would
    // be all that is left, of 7 s.
    let longest = Arc::new(Mutex::new(Duration::ZERO));
    let room = Room { seconds_per_ray: 2e-6, longest: longest.clone() };
    let session = Scripted { size: [WIDTH, HEIGHT], patience: 0.02, script: room };
    let mut scene = scene();
    scene.work.max_depth = DEPTH;
    let mut renderer = Renderer::new(Box::new(session), &scene, 0..1);
    let mut portions = 0;
    while *longest.lock().expect("no test panicked") < Duration::from_millis(150) {
        renderer.advance().expect("a portion");
        portions += 1;
    }
    let longest = *longest.lock().expect("no test panicked");
    assert!(longest < Duration::from_secs(1), "the first portion with rows of the room took {longest:?}");
    assert!(portions < 40, "{portions} portions before the room");
}
